// Which faces span openings, once a repair has put faces into other slots.
#pragma once

#include <limits>
#include <vector>

#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// The vertices of a mesh that are no samples: those from `first` on, up to before `end`.
struct ExtraVertices {
  Index first = std::numeric_limits<Index>::max();
  Index end = std::numeric_limits<Index>::max();
  bool has(Index v) const { return v >= first && v < end; }
};

/// Names the `spanning` faces (ascending) of a mesh anew: within each of `sets` of faces
/// (ascending) that took each other's slots, as many as before, or as have a vertex that is no
/// sample if these are more. These come first, then those next to a face that spans, of several the
/// one with the longest edge. O(n log n) of the faces in sets with both kinds.
void restore_spanning_faces(const SurfaceMesh& mesh, const std::vector<std::vector<Index>>& sets,
                            const ExtraVertices& extra, std::vector<Index>& spanning);

}  // namespace shrinkwrap
