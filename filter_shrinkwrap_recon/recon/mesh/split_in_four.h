// The connectivity of midpoint and of Loop subdivision.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Of each half-edge, the vertex that its edge gets when the faces are split: numbered after the
/// old vertices, in the order of the edges' lower half-edges. O(F). Throws InvalidInput if the
/// result cannot be indexed (178 million faces and more). Pre: no removed slots.
std::vector<Index> edge_vertices(const SurfaceMesh& mesh);

/// The mesh with every face in four: face f becomes 4f + i at its corner i, (corner, middle ahead,
/// middle behind), and 4f + 3 between the middles. `position` holds the V + E vertices, the middles
/// at `edge_vertex`, which `edge_vertices(mesh)` gave. O(F), parallel.
SurfaceMesh split_in_four(const SurfaceMesh& mesh, const std::vector<Index>& edge_vertex,
                          std::vector<Vec3> position, Progress& progress);

}  // namespace shrinkwrap
