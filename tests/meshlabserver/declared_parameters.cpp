// declared_parameters PLUGIN [--script | --save FILE]: the filters of a plugin and their
// parameters, as a document of two layers (a cloud, then a mesh) gives them. One tab-separated line
// a parameter: filter, type, name, value; or a script that runs every filter with its defaults, to
// the output or, by the host's own code, as its script dialog saves it, to a file.
// declared_parameters --python: the table of docs/pymeshlab.md, without any host.
#include <QApplication>
#include <QDomDocument>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>

#include "plugin_calls.h"
#include "python_table.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// As the newer hosts derive it: names of ours have letters only.
std::string python_name(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return name;
}

PythonParameter in_python(const Parameter& parameter) {
  const std::string number = QString::number(parameter.default_value).toStdString();
  const std::string name = python_name(parameter.name);
  switch (parameter.kind) {
    case Parameter::Kind::boolean:
      return {name, "bool", parameter.default_value != 0.0 ? "True" : "False", {}};
    case Parameter::Kind::integer:
      return {name, "int", number, {}};
    case Parameter::Kind::real:
      return {name, "float", number, {}};
    case Parameter::Kind::choice: {
      const auto chosen = static_cast<std::size_t>(parameter.default_value);
      return {name, "str", "'" + parameter.choices.at(chosen) + "'", parameter.choices};
    }
    case Parameter::Kind::layer:
      return {name, "int", "id of a layer that fits", {}};
  }
  return {};
}

void print_python_table() {
  for (int i = 0; i < kFilterCount; ++i) {
    const auto filter = static_cast<Filter>(i);
    PythonFunction function{filter_name(filter), scripting_name(filter), {}};
    for (const Parameter& parameter : parameters_of(filter))
      function.parameters.push_back(in_python(parameter));
    print_python_function(function);
  }
}

}  // namespace

// Only 2020.09 has a meshlabserver that could read it.
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
#include <common/filterscript.h>

namespace {

class SavedScript {
 public:
  void add(const QString& filter, const RichParameterList& list) {
    FilterNameParameterValuesPair step;
    step.first = filter;
    step.second = list;
    script_.append(step);
  }
  bool save(const QString& file) const { return script_.save(file); }

 private:
  FilterScript script_;
};

}  // namespace
#else
namespace {

class SavedScript {
 public:
  void add(const QString&, const RichParameterList&) {}
  bool save(const QString&) const { return false; }
};

}  // namespace
#endif

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  if (argc < 2) return 2;
  if (std::strcmp(argv[1], "--python") == 0) {
    print_python_table();
    return 0;
  }
  HostInterface* const plugin = load_plugin(QString::fromLocal8Bit(argv[1]));
  if (plugin == nullptr) return 1;
  const bool as_script = argc > 2 && std::strcmp(argv[2], "--script") == 0;
  const bool as_file = argc > 3 && std::strcmp(argv[2], "--save") == 0;

  MeshDocument document;
  document.addNewMesh("", "cloud", true);
  MeshModel* mesh = document.addNewMesh("", "mesh", true);
  vcg::tri::Allocator<CMeshO>::AddVertices(mesh->cm, 3);
  vcg::tri::Allocator<CMeshO>::AddFace(mesh->cm, 0, 1, 2);

  SavedScript saved;
  QDomDocument script("FilterScript");
  QDomElement root = script.createElement("FilterScript");
  script.appendChild(root);
  for (QAction* action : plugin->actions()) {
    QDomElement filter = script.createElement("filter");
    filter.setAttribute("name", action->text());
    root.appendChild(filter);
    const RichParameterList list = parameter_list(*plugin, action, document);
    saved.add(action->text(), list);
    for (const RichParameter& parameter : list) {
      const QDomElement element = parameter.fillToXMLDocument(script, false);
      filter.appendChild(element);
      if (!as_script && !as_file)
        std::printf("%s\t%s\t%s\t%s\n", qUtf8Printable(action->text()),
                    qUtf8Printable(parameter.stringType()), qUtf8Printable(parameter.name()),
                    qUtf8Printable(element.attribute("value")));
    }
  }
  if (as_script) std::printf("%s", script.toString(1).toUtf8().constData());
  if (as_file && !saved.save(QString::fromLocal8Bit(argv[3]))) return 1;
  return 0;
}
