// Delaunay triangulations of vertices on a surface, by edge flips.
#pragma once

#include <vector>

#include "mesh/vertex_blocks.h"

namespace shrinkwrap {

/// True if the angles opposite to the edge of h sum to more than a half turn, so that its flip is a
/// step towards the Delaunay triangulation, and the flip turns neither face away. Geometric only:
/// ask SurfaceMesh::is_flip_legal too.
bool wants_delaunay_flip(const SurfaceMesh& mesh, Index h);

/// Flips edges named in `stack` (half-edges; emptied), and those around each flip, until all are
/// Delaunay or none is left of `budget`, the number of looks at an edge. Edges of hinges that
/// `owner` does not own are appended to `deferred`, or passed over if that is null.
void flip_to_delaunay(SurfaceMesh& mesh, const BlockOwner& owner, std::vector<Index>& stack,
                      std::vector<Index>* deferred, Index& budget);

/// Flips all edges of the mesh to Delaunay. Near-linear for vertices spread over faces, bounded in
/// any case; parallel, the same for any number of threads.
void make_delaunay(SurfaceMesh& mesh, const VertexBlocks& blocks, Progress& progress);

}  // namespace shrinkwrap
