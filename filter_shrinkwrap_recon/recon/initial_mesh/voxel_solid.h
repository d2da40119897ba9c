// The solid inside the samples, as a sparse voxel image.
#pragma once

#include "geometry/voxel_lattice.h"
#include "initial_mesh/initial_mesh.h"
#include "orientation/winding_number.h"

namespace shrinkwrap {

struct VoxelSolid {
  VoxelLattice lattice;
  VoxelImage image;
  std::vector<BrickMask> near_samples;  ///< per brick of the image: voxels that samples reach
  double spacing = 0.0;                 ///< that the size of the voxels suits: the median, or wider

  bool contains(const Vec3& p) const { return image.is_solid(lattice.voxel_of(p)); }
};

/// Voxels that are inside by the plane field near the samples and by the winding number elsewhere
/// (`InitialMeshOptions::blend_begin` and `blend_end`). Bricks are those that samples reach, those
/// through which the level set of the winding number runs from there (over openings), and all that
/// touch these. Voxels suit a wider spacing than the median in very uneven clouds
/// (`InitialMeshOptions::squares_per_sample`). They are larger than asked for, for that spacing,
/// where samples would reach over four bricks each, or voxels be very small. Pre: oriented normals.
/// O(N) expected; parallel, the same for any number of threads. Throws ReconstructionFailed if the
/// level set runs too far.
VoxelSolid make_voxel_solid(const PointCloud& cloud, const WindingNumber& winding,
                            const InitialMeshOptions& options, Progress& progress);

/// The solid with the voxels of some bricks, in reach of samples, classified anew: samples count as
/// at least `least_spacing` (x median) apart. Pre: `near_samples` has all bricks.
VoxelSolid with_bricks_classified(VoxelSolid solid, const std::vector<Index>& bricks,
                                  double least_spacing, const PointCloud& cloud,
                                  const WindingNumber& winding, const InitialMeshOptions& options,
                                  Progress& progress);

}  // namespace shrinkwrap
