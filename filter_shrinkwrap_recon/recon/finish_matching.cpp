#include "finish_matching.h"

#include <algorithm>
#include <limits>

#include "close_openings.h"
#include "draw_in.h"
#include "sort_unique.h"
#include "triangle_geometry.h"

namespace shrinkwrap {
namespace {

// Pairs of faces that the removal of a vertex may make meet, for flips to part them again: the few
// first, since where they do not, all is as it was.
constexpr Index kMostCuts[] = {8, 64, 512};
// So often it is tried with so many cuts, each time without the vertices that did harm.
constexpr int kMostTrials = 8;

// Of the vertices removed from `before`, the one that was nearest to each of the faces that meet
// others in `after` and did not in `before`.
std::vector<Index> to_blame(const CompleteMatching& before, const std::vector<Index>& faces_before,
                            const std::vector<Index>& removed, const CompleteMatching& after,
                            const std::vector<Index>& faces_after) {
  const auto corners = [](const SurfaceMesh& mesh, Index f) {
    Triangle t = mesh.triangle(f);
    std::sort(t.begin(), t.end());
    return t;
  };
  std::vector<Triangle> known;
  for (const Index f : faces_before) known.push_back(corners(before.mesh, f));
  std::sort(known.begin(), known.end());
  std::vector<Index> nearest;
  for (const Index f : faces_after) {
    const Triangle t = corners(after.mesh, f);
    if (std::binary_search(known.begin(), known.end(), t)) continue;
    double least = std::numeric_limits<double>::infinity();
    Index best = removed.front();
    for (const Index v : removed) {
      const double distance = foot_on_triangle(before.mesh.position[v], after.mesh.position[t[0]],
                                               after.mesh.position[t[1]], after.mesh.position[t[2]])
                                  .squared_distance;
      if (distance >= least) continue;
      least = distance;
      best = v;
    }
    nearest.push_back(best);
  }
  sort_unique(nearest);
  return nearest;
}

// Removes vertices that cannot go without a cut.
template <class Repair>
void remove_with_cuts(CompleteMatching& matching, Index samples, const Repair& repair_mesh,
                      RepairReport& repair, Progress& progress) {
  for (const Index most_cuts : kMostCuts) {
    ClosingOptions options;
    options.most_cuts = most_cuts;
    for (int trials = 0; trials < kMostTrials; ++trials) {
      if (extra_vertices_kept(matching.mesh, samples, matching.opening_faces) == 0) return;
      CompleteMatching trial = matching;
      const std::vector<Index> removed = close_openings(trial, samples, progress, options);
      if (removed.empty()) break;
      RepairReport further = repair_mesh(trial);
      if (further.faces_after > repair.faces_after) {
        const std::vector<Index> harmful =
            to_blame(matching, repair.remaining_faces, removed, trial, further.remaining_faces);
        options.held.insert(options.held.end(), harmful.begin(), harmful.end());
        sort_unique(options.held);
        continue;
      }
      matching = std::move(trial);
      matching.report.cut_out += static_cast<Index>(removed.size());
      // What was cut here says nothing of the surface.
      further.faces_before_annealing = further.annealed = 0;
      repair.add(std::move(further));
      break;
    }
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
    report.removed_extra =
        static_cast<Index>(close_openings(matching, cloud.size(), progress).size());
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
