// Openings of the scan: which are spanned by faces and which are left open.
#pragma once

#include <vector>

#include "complete_matching.h"

namespace shrinkwrap {

struct OpeningsReport {
  Index spanned = 0;          ///< patches of faces that span an opening, and stay
  double longest_edge = 0.0;  ///< of these, x spacing
  Index left_open = 0;        ///< patches that are dropped
};

/// The faces to drop so that membranes become openings with clean borders, ascending: those that
/// hold a vertex from `first_extra` on, and a few more or less, so that every vertex has one fan of
/// faces left, and every vertex below `first_extra` at least one face. Pre: closed mesh.
std::vector<Index> faces_of_openings(const SurfaceMesh& mesh, Index first_extra,
                                     Progress& progress);

/// For Openings::automatic: of the patches that span openings, those with an edge longer than
/// `widest_opening` spacings become openings with clean borders. Fills in `opening_faces`, and adds
/// these to `spanning_faces`. Otherwise only counts. Pre: the mesh is closed, vertex i below
/// `samples` is sample i. O(F) where something spans.
OpeningsReport decide_openings(CompleteMatching& matching, Index samples, double spacing,
                               const CompleteMatchingOptions& options, Progress& progress);

/// Of the faces that span openings and stay, in the frame of the mesh.
double longest_spanning_edge(const CompleteMatching& matching);

}  // namespace shrinkwrap
