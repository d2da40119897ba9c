#include "filter_requests.h"

#include <cmath>
#include <sstream>
#include <string>

#include "parameter_names.h"

namespace shrinkwrap {
namespace {

using Kind = Parameter::Kind;

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

void check(const Parameter& parameter, const ParameterValues& values) {
  const auto found = values.find(parameter.name);
  if (found == values.end())
    throw InvalidInput("the parameter " + parameter.name +
                       " is missing, or of another type than declared: apply the filter in "
                       "MeshLab and save the script anew, or correct the script");
  const double value = found->second;
  const bool whole = parameter.kind == Kind::real || value == std::floor(value);
  if (value >= parameter.minimum && value <= parameter.maximum && whole) return;
  throw InvalidInput("the parameter " + parameter.name + ", \"" + parameter.label + "\", is " +
                     text_of(value) + ": it must be a" +
                     (parameter.kind == Kind::real ? "" : " whole") + " number from " +
                     text_of(parameter.minimum) + " to " + text_of(parameter.maximum));
}

// Reads values; a parameter that the filter does not have leaves its option as it is.
class Reader {
 public:
  explicit Reader(const ParameterValues& values) : values_(values) {}

  template <class Value>
  void read(const char* name, Value& option) const {
    const auto found = values_.find(name);
    if (found != values_.end()) option = static_cast<Value>(found->second);
  }
  // -1: automatic.
  void read_unless_automatic(const char* name, double& option, double unit) const {
    double value = -1.0;
    read(name, value);
    if (value == -1.0) return;
    if (value < 0.0)
      throw InvalidInput("the parameter " + std::string(name) + " is " + text_of(value) +
                         ": it must be -1, or 0 and more");
    option = value * unit;
  }
  bool is_on(const char* name) const {
    const auto found = values_.find(name);
    return found != values_.end() && found->second != 0.0;
  }

 private:
  const ParameterValues& values_;
};

}  // namespace

FilterRequest request_of(Filter filter, const ParameterValues& values) {
  for (const Parameter& parameter : parameters_of(filter))
    if (parameter.kind != Kind::layer) check(parameter, values);
  const Reader reader(values);

  FilterRequest request;
  ReconstructionOptions& options = request.options;
  if (reader.is_on(kMethod)) options = as_in_the_paper();
  request.selected_only = reader.is_on(kSelectedOnly);
  request.fail_if_incomplete = reader.is_on(kFailIfIncomplete);

  reader.read(kStopAtSurface, options.stop_at_parametric_surface);
  reader.read(kSmoothForNoise, options.stop_at_parametric_surface);
  // Who runs the stages chooses in which of them.
  if (reader.is_on(kSmoothForNoise)) options.denoising.before_initial_mesh_from = 0.0;
  reader.read(kBacksAreOpenings, options.complete_matching.backs_are_openings);
  reader.read(kExcludeOutliers, options.outliers.exclude);
  reader.read(kKeepStages, options.keep_stages);
  reader.read(kThreads, options.threads);
  reader.read(kNeighbours, options.samples.neighbours);
  reader.read(kVoxelSize, options.initial_mesh.voxel_size);
  reader.read(kLevel, options.initial_mesh.level);
  reader.read(kMinComponent, options.initial_mesh.min_component_samples);
  reader.read(kShrinkIterations, options.initial_mesh.shrink_iterations);
  reader.read(kBoxLevels, options.initial_mesh.levels);
  reader.read(kProjection, options.initial_mesh.projection);
  reader.read(kBoxRelaxation, options.initial_mesh.box_relaxation);
  reader.read(kControlVertices, options.control_mesh.target_vertices);
  reader.read(kFitIterations, options.parametric_surface.iterations);
  if (reader.is_on(kAttraction)) reader.read(kAttraction, options.parametric_surface.attraction);
  reader.read_unless_automatic(kCreaseAngle, options.edge_optimisation.crease_angle, kPi / 180.0);
  reader.read_unless_automatic(kLeastGap, options.edge_optimisation.least_gap, 1.0);
  reader.read(kRepairIntersections, options.intersection_repair.enabled);
  reader.read(kCountIntersections, options.report.count_self_intersections);
  int openings = static_cast<int>(options.complete_matching.openings);
  reader.read(kOpenings, openings);
  options.complete_matching.openings = static_cast<CompleteMatchingOptions::Openings>(openings);
  reader.read(kWidestOpening, options.complete_matching.widest_opening);
  reader.read(kMaximumGenus, options.initial_mesh.maximum_genus);
  reader.read(kCutFalseHandles, options.initial_mesh.false_handles.enabled);

  if (const Index target = options.control_mesh.target_vertices; target > 0 && target < 4)
    throw InvalidInput("the parameter " + std::string(kControlVertices) + " is " +
                       std::to_string(target) + ": it must be 0, or 4 and more");
  return request;
}

}  // namespace shrinkwrap
