// Openings of the scan closed by triangles between the samples around them.
#pragma once

#include <cstdint>
#include <vector>

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

struct ClosingOptions {
  /// Bounds the time: tests of pairs of triangles, some 0.2 us each; a face looked for in the tree
  /// counts as eight or more, a half-edge looked at as one. 0: two million, and 200 for each face
  /// of the mesh; openings of scans take fewer than a tenth of that. Of what costs more, vertices
  /// stay.
  std::int64_t max_tests = 0;
  /// Pairs of faces that the removal of a vertex may make meet, where it cannot go otherwise: one
  /// is tried first, then twice as many, and so on.
  Index most_cuts = 0;
  std::vector<Index> held = {};  ///< vertices that are to stay, ascending
};

struct Closing {
  std::vector<char> spans;  ///< per face slot: whether the face spans an opening
  Index trials = 0;         ///< of vertices, with and without success
  std::int64_t tests = 0;   ///< as they count for `max_tests`; not more by more than one vertex
};

/// Removes the vertices from `first_extra` on by collapses whose new faces cut, touch or overlap
/// nothing (but for `most_cuts`), so that the vertices around an opening span it; the edges among
/// the new faces are flipped to Delaunay under the same condition. Vertices go in an order that
/// thins them out evenly, so that faces grow evenly too; one that no collapse removes loses edges
/// by flips first, and is tried again, up to 60 times, only where something has changed around it.
/// One that cannot go without harm, or within the tests, stays. The `opening_faces` are to be
/// dropped: they are in nobody's way, and only what stays is looked at; a vertex at the border goes
/// to its nearest neighbour that leaves the borders simple loops, and each sample a face.
///
/// A vertex of k faces takes k searches for each collapse that is tried, of which there are up to
/// 32, more at borders; where the new faces turn or fold, also k^2 tests. Thinned out evenly, k is
/// mostly small and the whole near-linear in the vertices removed; the last vertices of a wide
/// opening see all of its rim, which is what the bound is for.
/// Pre: no removed slots. Post: closed 2-manifold of the same topology; no other face has changed.
/// Deterministic. Throws Cancelled.
Closing close_openings(SurfaceMesh& mesh, Index first_extra, Progress& progress,
                       const std::vector<Index>& opening_faces = {},
                       const ClosingOptions& options = {});

struct ClosingOfMatching {
  std::vector<Index> removed;  ///< vertices as they were numbered before, ascending
  std::int64_t tests = 0;      ///< as in `Closing`
};

/// The same for a matching whose vertex i below `samples` is sample i: vertices and faces are then
/// renumbered, the samples as they were; spanning and opening faces go along, and new ones that
/// span are added.
ClosingOfMatching close_openings(CompleteMatching& matching, Index samples, Progress& progress,
                                 const ClosingOptions& options = {});

}  // namespace shrinkwrap
