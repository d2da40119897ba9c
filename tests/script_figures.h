/// \file What a reconstruction hands to scripts, as docs/pymeshlab.md tells it: names and types, on
/// which a script may rely whatever the values are.
#pragma once

#include <array>
#include <string>

namespace shrinkwrap::testing {

/// Figures of every reconstruction, besides `seconds_<stage>`.
inline constexpr std::array<const char*, 13> kScriptFigures{
    "vertices", "faces",           "components",      "genus",          "border_loops",
    "samples",  "samples_matched", "samples_missing", "extra_vertices", "self_intersecting_faces",
    "outliers", "noise",           "seconds_total"};

/// Whether the figure of that name is a real number; the others are whole.
inline bool is_real_figure(const std::string& name) {
  return name == "noise" || name.rfind("seconds_", 0) == 0;
}

}  // namespace shrinkwrap::testing
