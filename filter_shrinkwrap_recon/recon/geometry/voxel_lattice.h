// Where the voxels of an image are.
#pragma once

#include "geometry/voxel_bricks.h"

namespace shrinkwrap {

/// A cubic lattice of voxels: voxel (x, y, z) reaches from origin + size (x, y, z) to one voxel
/// further.
struct VoxelLattice {
  Vec3 origin = Vec3::Zero();
  double size = 1.0;
  Voxel voxel_of(const Vec3& p) const {
    const Vec3 v = ((p - origin) / size).array().floor();
    return {static_cast<Index>(v.x()), static_cast<Index>(v.y()), static_cast<Index>(v.z())};
  }
  Vec3 corner_of(const Voxel& v) const { return origin + size * Vec3(v[0], v[1], v[2]); }
  Vec3 centre_of(const Voxel& v) const {
    return origin + size * Vec3(v[0] + 0.5, v[1] + 0.5, v[2] + 0.5);
  }
};

}  // namespace shrinkwrap
