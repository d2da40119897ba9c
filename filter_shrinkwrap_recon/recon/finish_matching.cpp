#include "finish_matching.h"

#include "close_openings.h"
#include "self_intersection.h"

namespace shrinkwrap {

FinishReport finish_matching(CompleteMatching& matching, Index samples, double spacing,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report;
  RepairReport& repair = report.repair;
  repair = repair_self_intersections(matching.mesh, options, progress, matching.opening_faces);
  if (matching.spanning_faces.empty() || matching.mesh.vertex_count() == samples) return report;
  report.removed_extra = close_openings(matching, samples, progress);
  if (report.removed_extra == 0) return report;
  openings.longest_edge = longest_spanning_edge(matching) / spacing;
  if (repair.faces_after > 0) {
    // What was closed met nothing, but faces that did may have gone, and all have other indices.
    repair.remaining_faces =
        self_intersecting_faces(matching.mesh.position, matching.mesh.triangles(), progress);
    repair.faces_after = static_cast<Index>(repair.remaining_faces.size());
  }
  return report;
}

}  // namespace shrinkwrap
