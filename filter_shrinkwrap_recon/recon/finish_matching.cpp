#include "finish_matching.h"

#include "close_openings.h"
#include "draw_in.h"

namespace shrinkwrap {

FinishReport finish_matching(CompleteMatching& matching, const PointCloud& cloud, HostScalar scalar,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report;
  RepairReport& repair = report.repair;
  const auto repair_mesh = [&] {
    return repair_self_intersections(matching.mesh, options, progress, matching.opening_faces,
                                     matching.spanning_faces);
  };
  repair = repair_mesh();
  if (matching.spanning_faces.empty()) return report;
  if (extra_vertices_kept(matching.mesh, cloud.size(), matching.opening_faces) > 0) {
    report.removed_extra = close_openings(matching, cloud.size(), progress);
    if (repair.faces_after > 0) {
      // Flips may part what is left now, and all faces have other indices.
      repair.add(repair_mesh());
    }
  }
  draw_in_extra_vertices(matching, cloud.size(), cloud.frame, scalar, {}, progress);
  measure_openings(matching, cloud.spacing, openings);
  return report;
}

}  // namespace shrinkwrap
