// Openings of the scan closed by triangles between the samples around them.
#pragma once

#include <vector>

#include "complete_matching.h"

namespace shrinkwrap {

/// Removes the vertices from `first_extra` on by collapses whose new faces cut, touch or overlap
/// nothing, so that the vertices around an opening span it; the edges among the new faces are
/// flipped to Delaunay under the same condition. Vertices go in an order that thins them out
/// evenly, so that faces grow evenly too; one that no collapse removes loses edges by flips first.
/// One that cannot go without harm stays. The `opening_faces` are to be dropped: they are in
/// nobody's way, and only what stays is looked at; a vertex at the border goes to its nearest
/// neighbour that leaves the borders simple loops, and each sample a face. Returns, per face slot,
/// whether the face spans an opening. Near-linear in the vertices removed and the length of the
/// rim. Pre: no removed slots. Post: closed 2-manifold of the same topology; no other face has
/// changed.
std::vector<char> close_openings(SurfaceMesh& mesh, Index first_extra, Progress& progress,
                                 const std::vector<Index>& opening_faces = {});

/// The same for a matching whose vertex i below `samples` is sample i: vertices and faces are then
/// renumbered, the samples as they were; spanning and opening faces go along, and new ones that
/// span are added. Returns the number of vertices removed.
Index close_openings(CompleteMatching& matching, Index samples, Progress& progress);

}  // namespace shrinkwrap
