// The end of edge optimisation: faces that meet others parted, then openings closed that such faces
// had kept from it, and what stays in them drawn in.
#pragma once

#include "complete_matching/complete_matching.h"
#include "complete_matching/openings.h"
#include "edge_optimisation/intersection_repair.h"

namespace shrinkwrap {

struct FinishReport {
  /// `faces_after` and `remaining_faces` are those that stay, before what stays is drawn in, which
  /// may part some of them.
  RepairReport repair;
  Index removed_extra = 0;  ///< vertices that are no sample, removed after all
};

/// Repairs self-intersections (faces that stay open left alone). Around an opening the faces of the
/// complete matching may cut where what spans it belongs, and then vertices that are no samples
/// stay: once the faces are parted, these are removed as close_openings does it, and where faces
/// still meet, they are parted again. Those that stay even so are removed with cuts, at first with
/// few, and faces are parted near what changed. Where more meet then, all is as before, and the
/// vertices that were removed nearest to those faces are left out of the next of a few trials; none
/// is made if more than a fifth of all faces meet others. The repair insists (RepairOptions) once
/// no more vertices are to go. What stays is drawn in (draw_in.h). Spanning faces are told anew
/// where a repair changed them (spanning_faces.h). `matching` and `openings` (the longest edge) are
/// brought up to date. Pre: vertex i below the samples of the cloud is sample i, or nothing spans
/// an opening. Post: closed 2-manifold of the same topology.
FinishReport finish_matching(CompleteMatching& matching, const PointCloud& cloud, HostScalar scalar,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress);

}  // namespace shrinkwrap
