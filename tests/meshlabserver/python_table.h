// How docs/pymeshlab.md shows a function of PyMeshLab: one writer for what the plugin declares and
// for what a newer host makes of it, so that both can be compared with the document to the byte.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace shrinkwrap::testing {

struct PythonParameter {
  std::string name;
  std::string type;
  std::string value;                 ///< the default, as written in Python
  std::vector<std::string> choices;  ///< of a type whose values are named
};

struct PythonFunction {
  std::string filter;  ///< name in the menus
  std::string name;
  std::vector<PythonParameter> parameters;
};

inline void print_python_function(const PythonFunction& function) {
  std::printf("\n## %s\n\n`%s`\n\n| parameter | type | default |\n|---|---|---|\n",
              function.filter.c_str(), function.name.c_str());
  for (const PythonParameter& parameter : function.parameters) {
    std::string type = parameter.type;
    for (std::size_t i = 0; i < parameter.choices.size(); ++i)
      type += (i == 0 ? ": '" : ", '") + parameter.choices[i] + "' (or " + std::to_string(i) + ")";
    std::printf("| `%s` | %s | %s |\n", parameter.name.c_str(), type.c_str(),
                parameter.value.c_str());
  }
}

}  // namespace shrinkwrap::testing
