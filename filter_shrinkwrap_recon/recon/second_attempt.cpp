#include "second_attempt.h"

#include <algorithm>

#include "common/attempted.h"
#include "report/plane_agreement.h"

namespace shrinkwrap {
namespace {

constexpr Index kFacesPerVertex = 6;
// Where as much of the area stands across the planes of the samples, noise has turned these, or
// there is no surface to tell of.
constexpr double kTellsNothing = 0.1;

MatchingFaults faults_of(const Reconstruction& result) {
  const RepairReport& repair = result.intersection_repair;
  const CompleteMatchingReport& matching = result.complete_matching;
  return {repair.persistent_faces(), repair.faces_after, matching.extra_vertices, matching.cut_out};
}

bool is_better(const MatchingFaults& a, const MatchingFaults& b) {
  if (a.break_promise() != b.break_promise()) return b.break_promise();
  if (!a.break_promise() && a.across != b.across && std::max(a.across, b.across) < kTellsNothing)
    return a.across < b.across;
  return a.weight() < b.weight() && a.still_meeting <= b.still_meeting;
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

bool tells_of_wrong_surface(const RepairReport& repair, Index faces) {
  constexpr double kFew = 1e-4;
  return repair.faces_after > 0 ||
         static_cast<double>(repair.persistent_faces()) > kFew * static_cast<double>(faces);
}

void try_again(Reconstruction& first, Reconstruction& second, SecondAttempt Reconstruction::*which,
               bool is_same_surface, const PointCloud& cloud, Progress& progress,
               const std::function<void()>& make) {
  SecondAttempt attempt;
  attempt.first = faults_of(first);
  const std::size_t faulty_faces =
      static_cast<std::size_t>(attempt.first.meeting) +
      kFacesPerVertex * (attempt.first.extra_vertices + attempt.first.cut_out);
  if (faulty_faces == 0 || faulty_faces >= first.mesh.triangles.size() / 2) return;
  attempt.is_made = true;
  second.outliers = first.outliers;  // some may be samples by now
  const auto genus_of_first = [&] {
    MeshReportOptions options;
    options.count_self_intersections = false;
    return measure_mesh(first.mesh.position, first.mesh.triangles, {}, options, progress).genus;
  };
  attempt.is_finished = attempted([&] {
    std::vector<Vec3f> normals;
    if (!is_same_surface) normals = normals_of_points(cloud);
    make();
    attempt.second = faults_of(second);
    if (!is_same_surface) {
      attempt.first.across = area_across_planes(first.mesh, cloud.frame, normals, progress);
      attempt.second.across = area_across_planes(second.mesh, cloud.frame, normals, progress);
    }
    if (is_better(attempt.second, attempt.first)) {
      PromiseOptions promise;  // that the samples are matched was seen when they were
      promise.may_be_open = true;
      promise.matches_samples = false;
      promise.report.count_self_intersections = false;
      const MeshReport report =
          check_promise(second.mesh, second.mesh.position, kNone, promise, progress);
      attempt.is_taken = is_same_surface || report.genus <= genus_of_first();
    }
  });
  keep_better(first, second, attempt, which);
}

}  // namespace shrinkwrap
