// Samples in the middle of an opening that is left open, joined to its border.
#pragma once

#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// A sample (a vertex below `samples`) all of whose faces are dropped would be lost. Where an
/// opening has a border, such a sample gets a face that joins it to an edge of that, between two
/// samples, those near borders first: of the edges fewest faces away the one that makes the
/// smallest face, if there is one that does not lie back on the face beyond its edge; or one
/// farther away, if those would cut a face that stays. Flips of edges between dropped faces make
/// it, so nothing else changes. Samples for which that is not possible stay as they are.
/// `is_dropped`: per face slot; the faces made are dropped no more. Returns them, ascending.
///
/// Pre: closed mesh without removed slots. Post: closed 2-manifold of the same topology and
/// vertices. O(F), and the faces between each such sample and its border, some 16,000 at most.
std::vector<Index> join_isolated_samples(SurfaceMesh& mesh, Index samples,
                                         std::vector<char>& is_dropped, Progress& progress);

}  // namespace shrinkwrap
