// The filters and their parameters, as the host shows them. No Qt, no host types.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace shrinkwrap {

/// The filters, in the order of their identifiers in the host.
enum class Filter {
  reconstruct,
  initial_mesh,
  control_mesh,
  parametric_surface,
  complete_matching,
  edge_optimisation,
  matching_report,
  distance_to_samples,
};
constexpr int kFilterCount = 8;

/// Name in menus and scripts: a global key of the host.
const char* filter_name(Filter filter);

/// Name of the filter as a function of PyMeshLab: snake_case, and never changed, since scripts of
/// others call it.
const char* scripting_name(Filter filter);

/// One entry of a filter's dialog.
struct Parameter {
  enum class Kind { boolean, integer, real, choice, layer };
  std::string name;  ///< key in scripts
  std::string label;
  std::string tooltip;
  Kind kind = Kind::boolean;
  double default_value = 0.0;  ///< 0 or 1 for boolean, position for choice; not used by layer
  double minimum = 0.0;        ///< smallest and largest value allowed
  double maximum = 1.0;
  std::vector<std::string> choices;
  bool advanced = false;  ///< good as it is for nearly everybody
};

/// Layer parameters of the filters that work on two layers.
constexpr char kSamplesLayer[] = "Samples";
constexpr char kMeshLayer[] = "Mesh";

/// In the order of the dialog and of scripts.
std::vector<Parameter> parameters_of(Filter filter);

/// Values by name of parameter, layers left out.
using ParameterValues = std::map<std::string, double>;

/// What a dialog left untouched gives.
ParameterValues default_values(Filter filter);

}  // namespace shrinkwrap
