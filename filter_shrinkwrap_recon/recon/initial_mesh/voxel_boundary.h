// The boundary of a voxel image as a closed 2-manifold.
#pragma once

#include "common/progress.h"
#include "geometry/voxel_lattice.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Adds voxels until no two solid ones, nor two empty ones, meet at an edge or a corner only
/// (well-composed, Latecki et al. 1995). Parallel but for the repairs; deterministic.
void make_well_composed(VoxelImage& image, Progress& progress);

/// The part of each brick in the Euler characteristic of the boundary, which is their sum: that of
/// a patch of the boundary is the sum over the bricks that touch it. Pre: well-composed.
std::vector<Index> euler_characteristics(const VoxelImage& image, Progress& progress);

/// The mesh between solid and empty voxels: two triangles for each square, vertices at corners of
/// voxels, oriented outwards; without faces if the image is empty. Where the image is `in_blocks`,
/// a block of voxels that are alike counts as one, and its squares, twice as large, have triangles
/// to the corners of smaller squares beside them. Pre: well-composed. Parallel, the same for any
/// number of threads.
SurfaceMesh boundary_of(const VoxelImage& image, const VoxelLattice& lattice, Progress& progress);

}  // namespace shrinkwrap
