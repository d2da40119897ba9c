// Where the local surface is, seen from a mesh vertex: the target of shrinking and fitting.
#pragma once

#include "point_cloud.h"
#include "voxel_search.h"

namespace shrinkwrap {

/// Foot of a mesh vertex on the surface that the samples of its own side suggest. Projecting to the nearest sample
/// folds the mesh in concavities and thin parts; the plane of the normal-compatible neighbours does not.
class TangentTarget {
 public:
  TangentTarget(const PointCloud& cloud, const VoxelSearch& search) : cloud_(cloud), search_(search) {}

  struct Target {
    Vec3 point;             ///< where to go; the query itself if `is_membrane`
    Index nearest = kNone;  ///< nearest compatible sample: the hint for the next call
    bool is_membrane = false;  ///< no sample supports the surface here: smooth only
  };
  /// `normal`: of the mesh at `query`, unit. `centroid`: mean of the vertex's one-ring. `hint`: a sample near the
  /// last answer, or kNone for a full search. Thread-safe, no allocation with a hint.
  Target find(const Vec3& query, const Vec3& normal, const Vec3& centroid, Index hint) const;

 private:
  const PointCloud& cloud_;
  const VoxelSearch& search_;
};

}  // namespace shrinkwrap
