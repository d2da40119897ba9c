// Which side of each component of the neighbour graph is outside.
#pragma once

#include <vector>

#include "orientation/sample_views.h"
#include "orientation/spanning_forest.h"

namespace shrinkwrap {

struct ComponentSides {
  std::vector<char> flip;  ///< whether to turn the normals, of each component
  Index enclosed = 0;      ///< components that were drawn again without those before them
  Index undecided = 0;     ///< components of which no view tells, or that nobody sees
  /// The mean normal (unit), once turned, of the largest flat sheet of which no view tells, if it
  /// has OrientationOptions::least_ground and all of the cloud faces there on the whole. Else zero.
  Vec3 ground = Vec3::Zero();
};

/// See orient_normals, which this is a part of. Pre: normals have the signs that the forest gives
/// them, and `votes` are on these.
ComponentSides find_component_sides(const PointCloud& cloud, const SpanningForest& forest,
                                    const SampleVotes& votes, const SampleViews& views,
                                    const OrientationOptions& options, Progress& progress);

}  // namespace shrinkwrap
