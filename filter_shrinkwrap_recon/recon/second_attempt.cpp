#include "second_attempt.h"

#include <algorithm>
#include <new>

namespace shrinkwrap {
namespace {

// Faces that nobody wants in a mesh through the samples, and that tell of a wrong surface: those
// that met others until they were annealed, and those with a corner that is no sample.
Index faults_of(const Reconstruction& result, Index samples) {
  Index count = result.intersection_repair.persistent_faces();
  if (result.complete_matching.extra_vertices == 0) return count;
  const std::vector<Index>& meeting = result.intersection_repair.remaining_faces;
  const std::vector<Triangle>& triangles = result.mesh.triangles;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    if (std::max({t[0], t[1], t[2]}) >= samples &&
        !std::binary_search(meeting.begin(), meeting.end(), static_cast<Index>(f)))
      ++count;
  }
  return count;
}

// Takes the better of two attempts, and reports it as `which`. The table tells the time that both
// took.
void keep_better(Reconstruction& first, Reconstruction& second, const SecondAttempt& attempt,
                 SecondAttempt Reconstruction::*which) {
  for (StageRecord& row : second.stages) {
    const auto same =
        std::find_if(first.stages.begin(), first.stages.end(),
                     [&](const StageRecord& other) { return other.name == row.name; });
    row.seconds += same->seconds;
    if (attempt.is_taken)
      *same = std::move(row);
    else
      same->seconds = row.seconds;
  }
  if (attempt.is_taken) {
    second.stages = std::move(first.stages);
    first = std::move(second);
  }
  first.*which = attempt;
}

}  // namespace

Reconstruction without_stages(Reconstruction& result) {
  std::vector<StageRecord> stages;
  stages.swap(result.stages);
  Reconstruction copy = result;
  result.stages.swap(stages);
  return copy;
}

void try_again(Reconstruction& first, Reconstruction& second, Index samples,
               SecondAttempt Reconstruction::*which, bool is_same_surface, Progress& progress,
               const std::function<void()>& make) {
  SecondAttempt attempt;
  attempt.faults_before = faults_of(first, samples);
  const Index faces = static_cast<Index>(first.mesh.triangles.size());
  if (attempt.faults_before == 0 || attempt.faults_before >= faces / 2) return;
  attempt.is_made = true;
  second.outliers = first.outliers;  // some may be samples by now
  try {
    make();
    const Index faults = faults_of(second, samples);
    const auto left = [](const Reconstruction& r) { return r.intersection_repair.faces_after; };
    if (faults < attempt.faults_before && left(second) <= left(first)) {
      PromiseOptions promise;  // that the samples are matched was seen when they were
      promise.may_be_open = true;
      promise.matches_samples = false;
      promise.report.count_self_intersections = false;
      const MeshReport report =
          check_promise(second.mesh, second.mesh.position, kNone, promise, progress);
      const MeshReport before =
          measure_mesh(first.mesh.position, first.mesh.triangles, {}, promise.report, progress);
      attempt.is_taken = is_same_surface || report.genus <= before.genus;
    }
    attempt.faults = faults;
    attempt.is_finished = true;
  } catch (const ReconstructionFailed&) {
  } catch (const std::bad_alloc&) {
  }
  keep_better(first, second, attempt, which);
}

}  // namespace shrinkwrap
