// Smaller voxels where samples are dense.
#pragma once

#include "initial_mesh/voxel_solid.h"

namespace shrinkwrap {

/// Halves the voxels of the parts of a solid whose samples lie far denser than the median spacing
/// (`InitialMeshOptions::dense_spacing`), so that sheets that are close there stay apart. A part
/// stays as it was if not most of its dense samples have solid behind and nothing before them then;
/// or if it would have more handles, since small voxels show holes where samples lie in rows or
/// their normals are wrong, unless nearly all samples agree and there are a hundred to each.
/// Returns the number of parts that were refined; if any, the rest of the image is `in_blocks`, and
/// the shape of it the same. `solid` is then to be made well-composed (voxel_boundary.h). O(N);
/// parallel, the same for any number of threads.
Index refine_dense_parts(VoxelSolid& solid, const PointCloud& cloud, const WindingNumber& winding,
                         const InitialMeshOptions& options, Progress& progress);

}  // namespace shrinkwrap
