/// \file What filters hand to scripts, as the table of docs/pymeshlab.md tells it: names and types,
/// on which a script may rely whatever the values are.
#pragma once

#include <set>
#include <string>

#include "filter_parameters.h"

namespace shrinkwrap::testing {

/// Figures of every run of a filter, besides `seconds_<stage>` of the reconstruction.
inline std::set<std::string> script_figures(Filter filter) {
  const bool is_distance = filter == Filter::distance_to_samples;
  const bool is_report = filter == Filter::matching_report;
  const bool is_whole = filter == Filter::reconstruct;
  std::set<std::string> names = {"vertices"};
  if (is_distance) names.insert({"mean_distance", "greatest_distance"});
  if (!is_distance) names.insert({"faces", "outliers"});
  if (is_whole || is_report || filter == Filter::edge_optimisation)
    names.insert({"components", "genus", "border_loops", "self_intersecting_faces", "samples",
                  "samples_matched", "samples_missing", "extra_vertices"});
  if (is_whole || filter == Filter::initial_mesh || filter == Filter::parametric_surface)
    names.insert("noise");
  if (is_whole) names.insert("seconds_total");
  return names;
}

/// Whether the figure of that name is a real number; the others are whole.
inline bool is_real_figure(const std::string& name) {
  return name == "noise" || name == "mean_distance" || name == "greatest_distance" ||
         name.rfind("seconds_", 0) == 0;
}

}  // namespace shrinkwrap::testing
