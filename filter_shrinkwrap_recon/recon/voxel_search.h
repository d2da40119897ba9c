// Section 2.1: voxel-based nearest-point search, exact.
#pragma once

#include <cstdint>
#include <vector>

#include "types.h"

namespace shrinkwrap {

/// Nearest samples by voxels (eq. 1: i = (x - x_min)/delta, and so on). The paper stops at the first shell of
/// voxels that holds a sample, which is not always the nearest; here shells go on until every unvisited sample is
/// provably farther than the best found. Memory is O(N) whatever the extent (only occupied voxels are stored), and
/// a query far from every sample climbs to coarser voxels instead of walking through empty ones.
/// Immutable after construction: queries are safe from any number of threads.
class VoxelSearch {
 public:
  /// One answer: index into the points given, and its squared distance.
  struct Hit {
    Index index = kNone;
    double squared_distance = 0.0;
  };

  VoxelSearch() = default;
  /// Pre: finite points. `voxel_size` 0 chooses about two points per occupied voxel. O(N) expected.
  explicit VoxelSearch(std::vector<Vec3> points, double voxel_size = 0.0);

  bool empty() const { return point_.empty(); }
  double voxel_size() const { return voxel_size_; }

  /// The nearest point; of several at one distance the one of lowest index. index == kNone if there are no points.
  Hit nearest(const Vec3& query) const;
  /// The nearest point for which `accept(index)` holds, within `max_distance`.
  /// (template, defined below or in the implementation header)
  /// The k nearest, nearest first (ties by index); fewer if there are fewer points. `hits` is replaced.
  void k_nearest(const Vec3& query, int k, std::vector<Hit>& hits) const;

 private:
  std::vector<Vec3> point_;  // grouped by voxel
  double voxel_size_ = 0.0;
};

}  // namespace shrinkwrap
