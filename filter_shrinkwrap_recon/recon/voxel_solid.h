// The solid inside the samples, on a sparse voxel grid, and its boundary as a manifold.
#pragma once

#include "initial_mesh.h"
#include "voxel_bricks.h"
#include "winding_number.h"

namespace shrinkwrap {

/// Voxels that are inside by the plane field near the samples and by the winding number elsewhere.
/// Near the rim of an opening the grid follows the level set of the winding number on its own.
class VoxelSolid {
 public:
  /// Pre: oriented normals. O(N) expected.
  VoxelSolid(const PointCloud& cloud, const WindingNumber& winding,
             const InitialMeshOptions& options, Progress& progress);

  /// Makes every voxel within `blend_end` of a sample solid: closed whatever the samples are.
  void fill_near_samples();
  /// Adds voxels until no two solid ones, nor two empty ones, meet at an edge or a corner only.
  void make_well_composed(Progress& progress);
  /// The boundary: a closed 2-manifold if the solid is well-composed. Components of the boundary
  /// that fewer than `min_samples` samples support are left out and counted in `dropped`.
  SurfaceMesh boundary(Index min_samples, Index& dropped) const;
  /// True if the voxel of a point is solid.
  bool contains(const Vec3& p) const;

 private:
  enum State : signed char { empty = 0, solid = 1 };
  Voxel voxel_of(const Vec3& p) const;
  Vec3 centre_of(const Voxel& v) const;
  State state_of(const Voxel& v) const;
  void splat(Progress& progress);
  void classify(Progress& progress);
  void follow_level_set(Progress& progress);
  struct CornerValues {  // of a field at the corners of bricks, each computed once
    BrickIndex index;
    std::vector<double> value;
  };
  bool classify_far_brick(const Voxel& brick, CornerValues& winding_at_corners);
  Index add_brick(const Voxel& brick);

  const PointCloud& cloud_;
  const WindingNumber& winding_;
  const InitialMeshOptions& options_;
  double size_;  // edge of a voxel
  Vec3 origin_;
  BrickIndex bricks_;
  std::vector<signed char> state_;   // per voxel of the bricks
  std::vector<float> distance_sum_;  // weighted signed plane distances, x 1/s_i
  std::vector<float> weight_sum_;    // 0 where no sample reaches
  std::vector<float> nearest_;       // squared distance to the nearest sample, x 1/s_i^2
  BrickIndex far_bricks_;            // bricks of one state
  std::vector<signed char> far_state_;
};

}  // namespace shrinkwrap
