// The k nearest neighbours of all samples at once, and the planes through them.
#pragma once

#include "common/progress.h"
#include "common/types.h"
#include "geometry/voxel_search.h"

namespace shrinkwrap {

struct Neighbourhoods {
  int k = 0;  ///< entries per point: the number asked for, or all points if fewer
  std::vector<Index> neighbour;  ///< k per point, nearest first; entry 0 is the point itself
  std::vector<float> radius;     ///< distance to the last entry
  std::vector<Vec3f> normal;     ///< unit; of the plane that fits the entries best, sign arbitrary
  std::vector<float> deviation;  ///< of the entries from that plane, root mean square
};

/// Finds the neighbourhoods of all points; `search` was made of the same. The points of a voxel
/// share one gathering of everything near that voxel, with coordinates relative to it in single
/// precision, in which distances are compared (ties in the order of the voxels). O(N) expected,
/// O(N log N) at worst, whatever the density; the same for any number of threads. Pre: k >= 1.
Neighbourhoods find_neighbourhoods(const std::vector<Vec3>& points, const VoxelSearch& search,
                                   int k, Progress& progress);

}  // namespace shrinkwrap
