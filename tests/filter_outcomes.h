// Runs of filters as the host makes them: values of the dialog in, meshes through layers.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "filter_runs.h"

namespace shrinkwrap::testing {

inline std::vector<Vec3> in_single_precision(std::vector<Vec3> points) {
  for (Vec3& p : points) p = rounded_to_single(p);
  return points;
}

// What a layer of the host makes of a result.
inline FilterInput through_layer(const std::vector<Vec3>& points, const FilterOutcome& outcome) {
  FilterInput input;
  input.points = points;
  input.mesh = outcome.mesh;
  input.mesh.position = in_single_precision(input.mesh.position);
  input.mesh.input_index.assign(input.mesh.position.size(), kNone);
  return input;
}

inline FilterOutcome run(Filter filter, const FilterInput& input,
                         const ParameterValues& changed = {}) {
  ParameterValues values = default_values(filter);
  for (const auto& [name, value] : changed)
    if (values.count(name) > 0) values[name] = value;
  const FilterRequest request = request_of(filter, values);
  Progress silent;
  return run_filter(filter, request, input, silent);
}

inline bool is_in(const std::vector<std::string>& lines, const std::string& what) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(what) != std::string::npos; });
}
inline bool is_told(const FilterOutcome& outcome, const std::string& what) {
  return is_in(outcome.log, what);
}

}  // namespace shrinkwrap::testing
