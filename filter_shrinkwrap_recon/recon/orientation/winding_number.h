// Generalised winding number of an oriented point cloud (Barill et al. 2018).
#pragma once

#include <vector>

#include "common/progress.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// About 1 inside, 0 outside; across an opening it falls smoothly. Dipoles with their first
/// derivative in a tree over the Morton order of the samples; the area of a sample is s_i^2,
/// with s_i of 4 median spacings at most; distances are softened by 0.5 s. Single precision: a
/// decision between inside and outside needs no more. Immutable after construction, thread-safe.
class WindingNumber {
 public:
  /// Pre: oriented normals; samples in Morton order. O(N log N).
  explicit WindingNumber(const PointCloud& cloud);             ///< silent
  WindingNumber(const PointCloud& cloud, Progress& progress);  ///< throws Cancelled
  /// Of a part of the samples: `sign` is -1 where the normal is to be reversed, 0 where the sample
  /// is left out.
  WindingNumber(const PointCloud& cloud, const std::vector<signed char>& sign, Progress& progress);
  double at(const Vec3& query) const;  ///< O(log N)

 private:
  // A range of samples, in one line of the cache.
  struct alignas(64) Node {
    Vec3f centre;           // of leaves by area, of their unions by the number of samples
    float squared_opening;  // squared distance from the centre from which the moments will do
    Vec3f dipole;           // sum of area x normal
    Index skip;             // the node that follows this one's subtree, in depth-first order
    float moment[6];        // symmetric part of the sum of area x normal x (sample - centre)^T
    Index begin, end;       // samples
  };
  struct Dipole {
    Vec3f position, moment;  // area x normal
  };
  struct Range;
  struct Subtree;
  class Builder;

  std::vector<Dipole> dipole_;  // per sample
  float softening_;             // squared length
  std::vector<Node> node_;
};

}  // namespace shrinkwrap
