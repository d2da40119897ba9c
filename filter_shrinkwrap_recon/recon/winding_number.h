// Generalised winding number of an oriented point cloud (Barill et al. 2018).
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

/// About 1 inside, 0 outside; across an opening it falls smoothly. Dipoles with their first derivative in a tree
/// over the Morton order of the samples; the area of a sample is s_i^2; distances are softened by 0.5 s.
/// Immutable after construction, thread-safe.
class WindingNumber {
 public:
  /// Pre: oriented normals. O(N), parallel. The cloud must outlive the object.
  WindingNumber(const PointCloud& cloud, Progress& progress);
  double at(const Vec3& query) const;  ///< O(log N)

 private:
  struct Node;
  const PointCloud* cloud_;
  std::vector<Node> node_;
};

}  // namespace shrinkwrap
