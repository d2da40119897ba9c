#include "complete_matching/finish_matching.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "common/sort_unique.h"
#include "complete_matching/close_openings.h"
#include "complete_matching/draw_in.h"
#include "complete_matching/settle_spanning_faces.h"
#include "mesh/removed_vertices.h"

namespace shrinkwrap {
namespace {

// Pairs of faces that the removal of a vertex may make meet, for flips to part them again: the few
// first, since where they do not, all is as it was.
constexpr Index kMostCuts[] = {8, 64, 512};
// So often it is tried with so many cuts, each time without the vertices that did harm.
constexpr int kMostTrials = 8;
// No trial is begun once all have tested so many pairs of faces, and so many for each face of the
// mesh: where much meets in a small one, or lies in planes, each takes a second. To copy the mesh
// and to look for pairs in it at first takes as long as so many more for each face.
constexpr std::int64_t kTestsOfTrials = 3000000, kTestsPerFace = 600, kTestsToBegin = 10;

class Finish {
 public:
  Finish(CompleteMatching& matching, Index samples, const RepairOptions& options,
         Progress& progress)
      : matching_(matching),
        samples_(samples),
        options_(options),
        in_brief_(options),
        progress_(progress) {
    in_brief_.insists = false;
  }

  FinishReport run() {
    if (has_extra_vertices()) {
      report_.repair = repair(matching_, in_brief_);
      remove_extra_vertices();
      if (options_.insists && report_.repair.faces_after > 0) insist();
    } else {
      report_.repair = repair(matching_, options_);
    }
    return std::move(report_);
  }

 private:
  bool has_extra_vertices() const {
    return !matching_.spanning_faces.empty() &&
           extra_vertices_kept(matching_.mesh, samples_, matching_.opening_faces) > 0;
  }
  RepairReport repair(CompleteMatching& matching, const RepairOptions& options) {
    return repair_self_intersections(matching.mesh, options, progress_, matching.opening_faces,
                                     &matching.spanning_faces, {samples_});
  }
  // Once more, near what has changed since `tried_` was filled in.
  RepairReport repair_again() {
    RepairOptions options = in_brief_;
    options.tried = tried_;
    return repair(matching_, options);
  }
  // Once all that changes the mesh is done.
  void insist() {
    RepairOptions options = options_;
    options.tried = tried_by_last_repair();
    report_.repair.add(repair(matching_, options));
  }
  void add_repair_of_cuts(RepairReport further) {
    // What was cut here says nothing of the surface.
    further.faces_before_annealing = further.annealed = 0;
    report_.repair.add(std::move(further));
  }
  // The surroundings of the faces left, unless there was no time to try them all.
  std::vector<Triangle> tried_by_last_repair() const {
    if (report_.repair.ran_short) return {};
    return surroundings(matching_.mesh, report_.repair.remaining_faces);
  }

  void remove_extra_vertices();
  void remove_with_cuts();

  CompleteMatching& matching_;
  Index samples_;
  const RepairOptions& options_;
  RepairOptions in_brief_;  // of what goes on to change
  Progress& progress_;
  FinishReport report_;
  std::vector<Triangle> tried_;  // by repairs of all kinds of moves: see RepairOptions
};

void Finish::remove_extra_vertices() {
  RepairReport& repair = report_.repair;
  tried_ = tried_by_last_repair();
  const std::vector<Index> removed = close_openings(matching_, samples_, progress_).removed;
  report_.removed_extra = static_cast<Index>(removed.size());
  tried_ = without_vertices(std::move(tried_), removed);
  // Flips may part what is left now, and all faces have other indices.
  if (repair.faces_after > 0) repair.add(repair_again());
  tried_ = tried_by_last_repair();
  remove_with_cuts();
  if (matching_.report.cut_out == 0) return;
  report_.removed_extra += matching_.report.cut_out;
  add_repair_of_cuts(repair_again());
}

// Removes vertices that cannot go without a cut.
void Finish::remove_with_cuts() {
  // Of a heap no trial shows anything.
  if (report_.repair.faces_after > kMostMeeting * matching_.mesh.face_count()) return;
  // In brief and near what has changed, since there are many trials.
  RepairOptions near = in_brief_;
  near.max_annealed_rings = 2;
  near.folds.most_folded = 0.0;
  std::int64_t tests_left = kTestsOfTrials + kTestsPerFace * matching_.mesh.face_count();
  for (const Index most_cuts : kMostCuts) {
    ClosingOptions options;
    options.most_cuts = most_cuts;
    const std::vector<Triangle> tried = tried_by_last_repair();
    for (int trials = 0; trials < kMostTrials && tests_left > 0 && has_extra_vertices(); ++trials) {
      CompleteMatching trial = matching_;
      const ClosingOfMatching closing = close_openings(trial, samples_, progress_, options);
      const std::vector<Index>& removed = closing.removed;
      tests_left -= closing.tests + kTestsToBegin * trial.mesh.face_count();
      if (removed.empty()) break;
      near.tried = without_vertices(tried, removed);
      RepairReport further = repair(trial, near);
      tests_left -= further.tests;
      if (further.faces_after > report_.repair.faces_after) {
        const std::vector<Index> harmful =
            removed_nearest_to(matching_.mesh, report_.repair.remaining_faces, removed, trial.mesh,
                               further.remaining_faces, progress_);
        options.held.insert(options.held.end(), harmful.begin(), harmful.end());
        sort_unique(options.held);
        continue;
      }
      matching_ = std::move(trial);
      tried_ = without_vertices(std::move(tried_), removed);
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
  settle_spanning_faces(matching, report.repair.remaining_faces, {}, progress);
  draw_in_extra_vertices(matching, cloud.size(), cloud.frame, scalar, {}, progress);
  measure_openings(matching, cloud.spacing, openings);
  return report;
}

}  // namespace shrinkwrap
