#include "finish_matching.h"

#include <utility>

#include "close_openings.h"

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
  if (repair.faces_after == 0) return report;
  // Without those vertices, flips may part what is left; and all faces have other indices.
  RepairReport again =
      repair_self_intersections(matching.mesh, options, progress, matching.opening_faces);
  repair.after = again.after;
  repair.faces_after = again.faces_after;
  repair.remaining_faces = std::move(again.remaining_faces);
  repair.flips += again.flips;
  repair.rounds += again.rounds;
  repair.tests += again.tests;
  return report;
}

}  // namespace shrinkwrap
