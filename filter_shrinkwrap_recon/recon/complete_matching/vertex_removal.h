// Section 2.5, "abnormal triangles": vertices that are no sample leave the mesh, by manifold-
// preserving operations only (Turk 1992, "Re-tiling polygonal surfaces").
#pragma once

#include <vector>

#include "mesh/vertex_blocks.h"

namespace shrinkwrap {

struct VertexRemovalReport {
  Index removed = 0;
  Index forced = 0;  ///< of these, removals that turned a face
  Index left = 0;    ///< vertices without which the mesh would not be a closed 2-manifold
};

/// Removes the vertices that are marked (`is_marked[v] != 0`; vertices beyond its end are not),
/// each by the half-edge collapse that leaves the flattest and best shaped triangles: cost 3 (1 -
/// min n.n_v) - min angle over the new faces, n_v the normal at the vertex. The link condition is
/// checked; a collapse that would turn a face away (n.n_v < 0.2) is put off until the neighbourhood
/// has changed; edges around each collapse are flipped to Delaunay. What is left at the end loses
/// edges by flips until it can be removed. O(V), parallel, the same for any number of threads.
/// Post: closed 2-manifold of the same topology.
VertexRemovalReport remove_vertices(SurfaceMesh& mesh, const VertexBlocks& blocks,
                                    const std::vector<char>& is_marked, Progress& progress);

}  // namespace shrinkwrap
