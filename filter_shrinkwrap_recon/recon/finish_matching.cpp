#include "finish_matching.h"

#include "close_openings.h"
#include "draw_in.h"

namespace shrinkwrap {
namespace {

// Pairs of faces that the removal of a vertex may make meet, for flips to part them again: the few
// first, since all is as it was where they do not.
constexpr Index kMostCuts[] = {8, 64};

// Removes vertices that cannot go without a cut.
template <class Repair>
void remove_with_cuts(CompleteMatching& matching, Index samples, const Repair& repair_mesh,
                      RepairReport& repair, Progress& progress) {
  for (const Index most_cuts : kMostCuts) {
    if (extra_vertices_kept(matching.mesh, samples, matching.opening_faces) == 0) break;
    CompleteMatching trial = matching;
    ClosingOptions options;
    options.most_cuts = most_cuts;
    const Index removed = close_openings(trial, samples, progress, options);
    if (removed == 0) continue;
    RepairReport further = repair_mesh(trial);
    if (further.faces_after > repair.faces_after) continue;
    matching = std::move(trial);
    matching.report.cut_out += removed;
    // What was cut here says nothing of the surface.
    further.faces_before_annealing = further.annealed = 0;
    repair.add(std::move(further));
  }
}

}  // namespace

FinishReport finish_matching(CompleteMatching& matching, const PointCloud& cloud, HostScalar scalar,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report;
  RepairReport& repair = report.repair;
  const auto repair_mesh = [&](CompleteMatching& to_repair) {
    return repair_self_intersections(to_repair.mesh, options, progress, to_repair.opening_faces,
                                     to_repair.spanning_faces);
  };
  repair = repair_mesh(matching);
  if (matching.spanning_faces.empty()) return report;
  if (extra_vertices_kept(matching.mesh, cloud.size(), matching.opening_faces) > 0) {
    report.removed_extra = close_openings(matching, cloud.size(), progress);
    if (repair.faces_after > 0) {
      // Flips may part what is left now, and all faces have other indices.
      repair.add(repair_mesh(matching));
    }
    remove_with_cuts(matching, cloud.size(), repair_mesh, repair, progress);
    report.removed_extra += matching.report.cut_out;
  }
  draw_in_extra_vertices(matching, cloud.size(), cloud.frame, scalar, {}, progress);
  measure_openings(matching, cloud.spacing, openings);
  return report;
}

}  // namespace shrinkwrap
