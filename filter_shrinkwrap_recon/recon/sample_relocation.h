// A sample that sits in the wrong layer of a mesh is taken out and put where it does no harm.
#pragma once

#include <vector>

#include "face_meetings.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// Takes a vertex out of the mesh, tiles its ring by cutting off the ear that meets the fewest
/// faces, of several the one that bends least (Schroeder, Zarge and Lorensen 1992), and puts the
/// vertex into the face nearby where the fewest faces meet then, of several where it bends least.
/// Does so only if fewer pairs of faces meet afterwards; otherwise the mesh is as before. The
/// vertex keeps its position, and `fixed_faces` (ascending) stay. Returns the faces that changed,
/// ascending; none if it was of no avail.
/// Post: closed 2-manifold of the same topology, same vertices. Each face that is made is as high
/// as `least_height`, a part of its longest edge.
/// O(k^2) searches for a vertex of k faces, at most 64, within the tests that `meetings` has left.
std::vector<Index> relocate_sample(SurfaceMesh& mesh, FaceMeetings& meetings, Index v,
                                   const std::vector<Index>& fixed_faces, double least_height);

}  // namespace shrinkwrap
