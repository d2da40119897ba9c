// Which point is nearest, for what is told or shown of a mesh at last.
#pragma once

#include <limits>
#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

struct NearestPoint {
  Index index = kNone;  ///< kNone: the query is not finite, or too far from all points
  double distance = std::numeric_limits<double>::infinity();
};

/// The nearest of `points` to each query, in the frame that they share; of several at one distance
/// the first. Points that are not finite count for nothing. O((N + Q) log N), parallel.
std::vector<NearestPoint> nearest_points(const std::vector<Vec3>& points,
                                         const std::vector<Vec3>& queries, Progress& progress);

}  // namespace shrinkwrap
