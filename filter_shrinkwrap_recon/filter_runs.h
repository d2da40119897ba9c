// What each filter does, once its layers are read and before its result is written. No Qt, no host
// types.
#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

#include "filter_requests.h"

namespace shrinkwrap {

/// The layers that a filter reads, in one coordinate system.
struct FilterInput {
  std::vector<Vec3> points;  ///< the samples
  ResultMesh mesh;  ///< of the filters that continue from, or measure, a mesh, with the face
                    ///< quality of its layer, if that has any
};

/// What later generations of the host hand to scripts, by name: counts ("samples_matched") are
/// always Index; seconds ("seconds_total") and distances, in the layer's units, always double.
using Figures = std::map<std::string, std::variant<Index, double>>;

/// What a filter hands back to the host.
struct FilterOutcome {
  ResultMesh mesh;                  ///< a new layer; without positions there is none
  std::string layer_suffix;         ///< its name, after that of the samples' layer
  std::vector<Index> marked_faces;  ///< to be shown selected in the new layer, ascending
  std::vector<StageRecord> stages;  ///< kept stages, each a layer too
  ResultMesh outliers;           ///< points left out, a layer too; without positions there is none
  std::vector<double> distance;  ///< of every vertex of the input mesh from the nearest sample
  std::vector<std::string> log;  ///< the last line is the verdict
  std::vector<std::string> warnings;
  Figures figures;
};

/// How the verdict begins that every run ends with: in the log if it succeeded, in the error
/// message if not.
constexpr char kSucceeded[] = "Shrink Wrap succeeded: ";
constexpr char kFailed[] = "Shrink Wrap failed: ";

/// The stages that a run will pass, for the construction of its Progress.
std::vector<Stage> stages_of(Filter filter, const FilterRequest& request);

/// Runs a filter. The stage filters chained, each given the mesh of the one before rounded to
/// `request.options.host_scalar`, give the mesh of Filter::reconstruct to the byte.
/// Throws InvalidInput, Cancelled or ReconstructionFailed.
FilterOutcome run_filter(Filter filter, const FilterRequest& request, const FilterInput& input,
                         Progress& progress);

}  // namespace shrinkwrap
