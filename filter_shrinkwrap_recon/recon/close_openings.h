// Openings of the scan closed by triangles between the samples around them.
#pragma once

#include <vector>

#include "progress.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// Removes the vertices from `first_extra` on by collapses whose new faces cut, touch or overlap
/// nothing, so that the vertices around an opening span it; the edges among the new faces are
/// flipped to Delaunay under the same condition. A vertex that cannot go without harm stays.
/// Returns, per face slot, whether the face spans an opening. Near-linear.
/// Pre: no removed slots. Post: closed 2-manifold
/// of the same topology; no other face has changed.
std::vector<char> close_openings(SurfaceMesh& mesh, Index first_extra, Progress& progress);

}  // namespace shrinkwrap
