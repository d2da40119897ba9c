// Figures by vertex and by face that show what a stage did, for a host that colours by them.
#pragma once

#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"
#include "report/result_mesh.h"

namespace shrinkwrap {

/// The distance of every vertex of `mesh` from `surface`, in the units of the input. Pre: `surface`
/// is in the unit frame, has faces and no removed ones. O(V log F), parallel.
std::vector<float> distances_from_surface(const ResultMesh& mesh, const SurfaceMesh& surface,
                                          const Frame& frame, Progress& progress);

/// The longest edge of each face of `spanning` (indices ascending), in units of `spacing`; 0 for
/// every other face. Empty if none spans an opening. O(F).
std::vector<float> spanning_lengths(const ResultMesh& mesh, const std::vector<Index>& spanning,
                                    double spacing);

/// The way back, for a mesh that comes from elsewhere: faces whose quality is their longest edge in
/// units of `spacing`, ascending; other qualities are of another kind. O(F).
std::vector<Index> spanning_faces(const ResultMesh& mesh, double spacing);

}  // namespace shrinkwrap
