// After the removal of vertices: how faces are named then, and which of them did harm.
#pragma once

#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Faces, by their corners in ascending order, as they are named once the vertices `removed`
/// (ascending) are gone and those behind have moved up; faces of which a corner is gone are left
/// out. In the order given. O(log) of the vertices for each face.
std::vector<Triangle> without_vertices(std::vector<Triangle> faces,
                                       const std::vector<Index>& removed);

/// Of the vertices `removed` (ascending, at least one) from `before`, the one that was nearest to
/// the middle of each of the faces `faces_after` of `after`; faces that were among `faces_before`
/// already, with the same corners, say nothing. Ascending, each once. O(n log n) in the lists.
std::vector<Index> removed_nearest_to(const SurfaceMesh& before,
                                      const std::vector<Index>& faces_before,
                                      const std::vector<Index>& removed, const SurfaceMesh& after,
                                      const std::vector<Index>& faces_after, Progress& progress);

}  // namespace shrinkwrap
