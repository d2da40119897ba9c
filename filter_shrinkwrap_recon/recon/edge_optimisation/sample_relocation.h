// A sample that sits in the wrong layer of a mesh is taken out and put where it does no harm.
#pragma once

#include <vector>

#include "mesh/face_meetings.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

struct RelocationLimits {
  double least_height = 0.0;  ///< of each face that is made, as a part of its longest edge
  int most_added = -1;        ///< pairs of faces that meet; below 0, so many fewer there must be
  const std::vector<Index>* patch = nullptr;  ///< no face but these (ascending) may change
};

/// Takes a vertex out of the mesh, tiles its ring by cutting off the ear that meets the fewest
/// faces, of several the one that bends least (Schroeder, Zarge and Lorensen 1992), and puts the
/// vertex into the face nearby where the fewest faces meet then, of several where it bends least.
/// Does so only within the limits, as they are by default if fewer pairs of faces meet afterwards;
/// otherwise the mesh is as before. The vertex keeps its position, and `fixed_faces` (ascending)
/// stay. Returns the faces that changed, ascending; none if it was of no avail.
/// Post: closed 2-manifold of the same topology, same vertices.
/// O(k^2) searches for a vertex of k faces, at most 64, within the tests that `meetings` has left.
std::vector<Index> relocate_sample(SurfaceMesh& mesh, FaceMeetings& meetings, Index v,
                                   const std::vector<Index>& fixed_faces,
                                   const RelocationLimits& limits);

}  // namespace shrinkwrap
