#include "match_cloud.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "complete_matching/finish_matching.h"
#include "complete_matching/near_copy_insertion.h"
#include "complete_matching/outliers_off_surface.h"
#include "complete_matching/outliers_on_surface.h"
#include "mesh/bodies.h"
#include "mesh/self_intersection.h"
#include "report/stage_qualities.h"

namespace shrinkwrap {
namespace {

// RepairOptions::tried once what stays of extra vertices has been drawn in: faces at these have
// changed.
std::vector<Triangle> tried_before(const SurfaceMesh& mesh, const RepairReport& repair,
                                   const ExtraVertices& extra) {
  std::vector<Triangle> tried = surroundings(mesh, repair.remaining_faces);
  const auto has_moved = [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](Index v) { return extra.has(v); });
  };
  tried.erase(std::remove_if(tried.begin(), tried.end(), has_moved), tried.end());
  return tried;
}

}  // namespace

void keep_samples(ReconstructionOptions& options) {
  options.outliers.foot = 0.0;
  options.outliers.off_surface = std::numeric_limits<double>::infinity();
}

CompleteMatching match_cloud(SurfaceMesh parametric, PointCloud& cloud, OutlierReport& outliers,
                             const std::vector<Vec3>& points, double noise,
                             const ReconstructionOptions& options, Progress& progress) {
  constexpr double kToSearch = 0.1;  // of the time of the stage
  progress.begin(Stage::complete_matching);
  progress.set_part(0.0, kToSearch);
  if (options.outliers.exclude)
    leave_out_samples_off_surface(cloud, outliers, parametric, noise, options.outliers, progress);
  progress.set_part(kToSearch, 1.0);
  if (outliers.input_index.empty() || !(options.outliers.foot > 0.0))
    return match_samples(std::move(parametric), cloud, options.complete_matching, progress);
  progress.set_part(kToSearch, 0.5);
  CompleteMatching matching = match_samples(parametric, cloud, options.complete_matching, progress);
  if (keep_outliers_on_surface(cloud, outliers, points, matching.mesh, options.outliers,
                               progress) == 0)
    return matching;
  progress.set_part(0.5, 1.0);
  return match_samples(std::move(parametric), cloud, options.complete_matching, progress);
}

OptimisedMesh optimise_matching(CompleteMatching& matching, const PointCloud& cloud,
                                const std::vector<Vec3>& points,
                                const ReconstructionOptions& options, Progress& progress) {
  OptimisedMesh result;
  progress.begin(Stage::edge_optimisation);
  progress.set_part(0.0, 0.05);
  CompleteMatchingOptions matched = options.complete_matching;
  if (matched.method == CompleteMatchingOptions::Method::snap_and_insert)
    matched.openings = CompleteMatchingOptions::Openings::close;  // the method knows of none
  result.openings = decide_openings(matching, cloud, matched, progress);
  progress.set_part(0.05, 0.5);
  result.edge_optimisation =
      optimise_edges(matching.mesh, options.edge_optimisation, progress, matching.spanning_faces);
  progress.set_part(0.5, 0.8);
  RepairReport& repair = result.intersection_repair;
  if (options.intersection_repair.enabled) {
    FinishReport finish = finish_matching(matching, cloud, options.host_scalar,
                                          options.intersection_repair, result.openings, progress);
    repair = std::move(finish.repair);
    result.removed_extra = finish.removed_extra;
  }
  result.extra_vertices = extra_vertices_kept(matching.mesh, cloud.size(), matching.opening_faces);
  if (!cloud.conditioning.near_copies.empty()) {
    const ExtraVertices extra = {cloud.size(), matching.mesh.vertex_slots()};
    RepairOptions with_copies = options.intersection_repair;
    if (!repair.ran_short) with_copies.tried = tried_before(matching.mesh, repair, extra);
    insert_near_copies(matching, cloud, points, progress);
    if (options.intersection_repair.enabled)
      repair.add(repair_self_intersections(matching.mesh, with_copies, progress,
                                           matching.opening_faces, &matching.spanning_faces,
                                           extra));
    if (!matching.spanning_faces.empty())
      measure_openings(matching, cloud.spacing, result.openings);
  }
  progress.set_part(0.8, 0.85);
  const std::vector<Index>& dropped = matching.opening_faces;
  turn_outward(matching.mesh, dropped, progress);
  progress.set_part(0.85, 1.0);
  result.mesh = to_result(matching, cloud, points, progress);
  drop_faces(result.mesh, dropped, progress);
  repair.remaining_faces = indices_after_drop(repair.remaining_faces, dropped);
  result.mesh.face_quality =
      spanning_lengths(result.mesh, indices_after_drop(matching.spanning_faces, dropped),
                       cloud.frame.to_input_length(cloud.spacing));
  // The repair counts in the unit frame. Vertices may have been rounded on their way into it, or,
  // those that are no samples, out of it.
  if (options.intersection_repair.enabled &&
      (result.extra_vertices > 0 || !is_exact_in_unit_frame(cloud, points, progress))) {
    repair.remaining_faces =
        self_intersecting_faces(result.mesh.position, result.mesh.triangles, progress);
    repair.faces_after = static_cast<Index>(repair.remaining_faces.size());
  }
  return result;
}

}  // namespace shrinkwrap
