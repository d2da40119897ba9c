#include "finish_matching.h"

#include "close_openings.h"

namespace shrinkwrap {

FinishReport finish_matching(CompleteMatching& matching, Index samples, double spacing,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report;
  RepairReport& repair = report.repair;
  repair = repair_self_intersections(matching.mesh, options, progress, matching.opening_faces);
  if (matching.spanning_faces.empty()) return report;
  if (extra_vertices_kept(matching.mesh, samples, matching.opening_faces) > 0) {
    report.removed_extra = close_openings(matching, samples, progress);
    if (repair.faces_after > 0) {
      // Flips may part what is left now, and all faces have other indices.
      repair.add(
          repair_self_intersections(matching.mesh, options, progress, matching.opening_faces));
    }
  }
  measure_openings(matching, spacing, openings);
  return report;
}

}  // namespace shrinkwrap
