// Generalised winding number of an oriented point cloud (Barill et al. 2018).
#pragma once

#include <vector>

#include "point_cloud.h"

namespace shrinkwrap {

/// About 1 inside, 0 outside; across an opening it falls smoothly. Dipoles with their first
/// derivative in a tree over the Morton order of the samples; the area of a sample is s_i^2;
/// distances are softened by 0.5 s. Immutable after construction, thread-safe.
class WindingNumber {
 public:
  /// Pre: oriented normals; samples in Morton order. O(N). The cloud must outlive the object.
  explicit WindingNumber(const PointCloud& cloud);
  double at(const Vec3& query) const;  ///< O(log N)

 private:
  struct Node {
    Vec3 centre;             // area-weighted
    Vec3 dipole;             // sum of area x normal
    Eigen::Matrix3d moment;  // sum of area x normal x (sample - centre)^T
    double radius;           // of the samples around the centre
    Index begin, end;        // samples
    Index skip;              // the node that follows this one's subtree, in depth-first order
  };
  Index build(Index begin, Index end, const std::vector<std::uint64_t>& keys);
  double area(Index sample) const;

  const PointCloud& cloud_;
  double softening_;  // squared length
  std::vector<Node> node_;
};

}  // namespace shrinkwrap
