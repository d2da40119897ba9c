// Openings of the scan: which are spanned by faces and which are left open.
#pragma once

#include <vector>

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

struct OpeningsReport {
  Index spanned = 0;          ///< patches of faces that span an opening, and stay
  Index stretched = 0;        ///< of these: membranes of a parametric surface (surface_openings.h)
  double longest_edge = 0.0;  ///< of the faces that span, x spacing
  Index left_open = 0;        ///< patches that are dropped
  Index notches_filled = 0;   ///< triangles that straighten their borders
};

/// Makes membranes openings with clean borders, whose notches are filled (border_notches.h). The
/// faces to drop, `opening_faces`, are those that hold a vertex beyond the samples, and a few more
/// or less, so that every vertex has one fan of faces left, and every sample at least one face
/// (isolated_samples.h). `spanning_faces` are these, and those that stay for the sake of a sample.
/// Counts the notches in `report`. Pre: closed mesh, vertex i below `cloud.size()` is sample i.
void leave_openings(CompleteMatching& matching, const PointCloud& cloud, Progress& progress);

/// For Openings::automatic: of the patches that span openings, those with an edge longer than
/// `widest_opening` spacings become openings with clean borders, whose notches are filled. Fills in
/// `opening_faces`, and adds these to `spanning_faces`, as well as those that stay for the sake of
/// a sample. For Openings::leave_open all of them do, with clean borders. Otherwise only counts.
/// Pre: the mesh is closed, vertex i below `cloud.size()` is sample i. O(F) where something spans.
OpeningsReport decide_openings(CompleteMatching& matching, const PointCloud& cloud,
                               const CompleteMatchingOptions& options, Progress& progress);

/// The faces to drop for these (ascending) to be openings: a few more or less, so that every vertex
/// has one fan of faces left, and those below `first_extra` at least one face. Ascending.
std::vector<Index> cut_openings(const SurfaceMesh& mesh, const std::vector<Index>& faces,
                                Index first_extra, Progress& progress);

/// Vertices that are no sample (from index `samples` on) of faces that are not dropped. O(F).
Index extra_vertices_kept(const SurfaceMesh& mesh, Index samples,
                          const std::vector<Index>& opening_faces);

/// Counts the patches of `spanning_faces` that stay and those of `opening_faces`, and measures the
/// longest edge of the former; `spacing` in the frame of the mesh. O(F) where something spans.
void measure_openings(const CompleteMatching& matching, double spacing, OpeningsReport& report);

}  // namespace shrinkwrap
