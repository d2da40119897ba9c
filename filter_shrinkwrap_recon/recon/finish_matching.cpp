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
  std::vector<Triangle> known;
  for (const Index f : faces_before) known.push_back(ascending_corners(before.mesh, f));
  std::sort(known.begin(), known.end());
  std::vector<Index> nearest;
  for (const Index f : faces_after) {
    const Triangle t = ascending_corners(after.mesh, f);
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

class Finish {
 public:
  Finish(CompleteMatching& matching, Index samples, const RepairOptions& options,
         Progress& progress)
      : matching_(matching), samples_(samples), options_(options), progress_(progress) {}

  FinishReport run() {
    report_.repair = repair(matching_, options_);
    if (has_extra_vertices()) remove_extra_vertices();
    return std::move(report_);
  }

 private:
  bool has_extra_vertices() const {
    return !matching_.spanning_faces.empty() &&
           extra_vertices_kept(matching_.mesh, samples_, matching_.opening_faces) > 0;
  }
  RepairReport repair(CompleteMatching& matching, const RepairOptions& options) {
    return repair_self_intersections(matching.mesh, options, progress_, matching.opening_faces,
                                     matching.spanning_faces);
  }
  // Once more, near what has changed since the surroundings of the faces left were `tried`.
  RepairReport repair_again(std::vector<Triangle> tried) {
    RepairOptions options = options_;
    options.tried = std::move(tried);
    return repair(matching_, options);
  }
  void add_repair_of_cuts(RepairReport further) {
    // What was cut here says nothing of the surface.
    further.faces_before_annealing = further.annealed = 0;
    report_.repair.add(std::move(further));
  }
  // For what there was no time is to be tried again.
  std::vector<Triangle> tried_so_far() const {
    if (report_.repair.ran_short) return {};
    return surroundings(matching_.mesh, report_.repair.remaining_faces);
  }

  void remove_extra_vertices();
  void remove_with_cuts();

  CompleteMatching& matching_;
  Index samples_;
  const RepairOptions& options_;
  Progress& progress_;
  FinishReport report_;
};

void Finish::remove_extra_vertices() {
  RepairReport& repair = report_.repair;
  std::vector<Triangle> tried = tried_so_far();
  report_.removed_extra = static_cast<Index>(close_openings(matching_, samples_, progress_).size());
  // Flips may part what is left now, and all faces have other indices.
  if (repair.faces_after > 0) repair.add(repair_again(std::move(tried)));
  tried = tried_so_far();
  remove_with_cuts();
  if (matching_.report.cut_out == 0) return;
  report_.removed_extra += matching_.report.cut_out;
  add_repair_of_cuts(repair_again(std::move(tried)));
}

// Removes vertices that cannot go without a cut.
void Finish::remove_with_cuts() {
  // Of a heap no trial shows anything.
  if (report_.repair.faces_after > kMostMeeting * matching_.mesh.face_count()) return;
  // In brief and near what has changed, since there are many trials.
  RepairOptions near = options_;
  near.max_annealed_rings = 2;
  near.folds.most_folded = 0.0;
  for (const Index most_cuts : kMostCuts) {
    ClosingOptions options;
    options.most_cuts = most_cuts;
    near.tried = tried_so_far();
    for (int trials = 0; trials < kMostTrials && has_extra_vertices(); ++trials) {
      CompleteMatching trial = matching_;
      const std::vector<Index> removed = close_openings(trial, samples_, progress_, options);
      if (removed.empty()) break;
      RepairReport further = repair(trial, near);
      if (further.faces_after > report_.repair.faces_after) {
        const std::vector<Index> harmful = to_blame(matching_, report_.repair.remaining_faces,
                                                    removed, trial, further.remaining_faces);
        options.held.insert(options.held.end(), harmful.begin(), harmful.end());
        sort_unique(options.held);
        continue;
      }
      matching_ = std::move(trial);
      matching_.report.cut_out += static_cast<Index>(removed.size());
      add_repair_of_cuts(std::move(further));
      break;
    }
  }
}

}  // namespace

FinishReport finish_matching(CompleteMatching& matching, const PointCloud& cloud, HostScalar scalar,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report = Finish(matching, cloud.size(), options, progress).run();
  if (matching.spanning_faces.empty()) return report;
  draw_in_extra_vertices(matching, cloud.size(), cloud.frame, scalar, {}, progress);
  measure_openings(matching, cloud.spacing, openings);
  return report;
}

}  // namespace shrinkwrap
