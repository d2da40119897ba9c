#include "fit_surface.h"

#include <algorithm>
#include <utility>

#include "common/attempted.h"
#include "geometry/coordinate_matches.h"
#include "match_cloud.h"
#include "mesh/bodies.h"
#include "mesh/self_intersection.h"
#include "report/stage_qualities.h"
#include "stop_at_surface/membrane_stretching.h"

namespace shrinkwrap {
namespace {

constexpr double kFitting = 0.8;  // of the time of a surface that is finished too

}  // namespace

FittedSurface fit_surface(SurfaceMesh control, const PointCloud& cloud,
                          const ReconstructionOptions& options, Progress& progress) {
  const bool is_last = options.stop_at_parametric_surface;
  progress.begin(Stage::parametric_surface);
  if (is_last) progress.set_part(0.0, kFitting);
  ParametricSurfaceOptions parametric = options.parametric_surface;
  if (is_last) parametric.fine_enough = 0.0;  // as fine as samples would make it
  FittedSurface fitted;
  fitted.surface = make_parametric_surface(std::move(control), cloud, parametric, progress);
  if (!is_last) round_to_host(fitted.surface.mesh, cloud.frame, options.host_scalar);
  return fitted;
}

void finish_surface(FittedSurface& fitted, const PointCloud& cloud,
                    const ReconstructionOptions& options, Progress& progress) {
  if (!options.stop_at_parametric_surface) return;
  SurfaceMesh& mesh = fitted.surface.mesh;
  progress.begin(Stage::parametric_surface);
  progress.set_part(kFitting, 0.85);
  fitted.membranes = find_surface_membranes(
      mesh, mark_membranes(mesh, cloud, options.parametric_surface, progress), cloud,
      options.complete_matching, progress);
  stretch_membranes(mesh, fitted.membranes, progress);
  round_to_host(mesh, cloud.frame, options.host_scalar);
  if (options.intersection_repair.enabled) {
    progress.set_part(0.85, 0.95);
    fitted.relaxation = relax_self_intersections(mesh, cloud.frame, options.host_scalar,
                                                 options.relaxation, progress);
  }
  progress.set_part(0.95, 1.0);
  measure_distances(fitted.surface, cloud, options.parametric_surface, progress);
}

namespace {

// All the points, the samples among them where the host has them once they have moved.
std::vector<Vec3> points_on_surface(const SamplesOnSurface& samples, const PointCloud& cloud,
                                    const std::vector<Vec3>& points, HostScalar scalar) {
  std::vector<Vec3> moved = points;
  for (Index i = 0; i < cloud.size(); ++i) {
    Vec3& p = moved[cloud.input_index[i]];
    p = cloud.frame.to_input(samples.position[i]);
    if (scalar == HostScalar::single_precision) p = rounded_to_single(p);
  }
  return moved;
}

SurfaceDetail displacements(const PointCloud& cloud, const std::vector<Vec3>& points,
                            const std::vector<Vec3>& moved) {
  SurfaceDetail detail;
  for (const Index i : cloud.input_index) {
    const double displacement =
        (cloud.frame.to_unit(moved[i]) - cloud.frame.to_unit(points[i])).norm() / cloud.spacing;
    detail.mean_displacement += displacement / static_cast<double>(cloud.size());
    detail.max_displacement = std::max(detail.max_displacement, displacement);
  }
  return detail;
}

// Fills in `mesh` and the reports of `fitted` if the surface misses detail, and if the mesh of the
// samples is no worse.
bool match_on_surface(FittedSurface& fitted, PointCloud& cloud, const std::vector<Vec3>& points,
                      double noise, const ReconstructionOptions& options, ResultMesh& mesh,
                      Progress& progress) {
  progress.begin(Stage::complete_matching);
  progress.set_part(0.0, 0.3);
  const SamplesOnSurface samples =
      move_onto_surface(fitted.surface.mesh, cloud, noise, options.samples_on_surface, progress);
  fitted.detail.upper_fifth = samples.upper_fifth;
  fitted.detail.upper_twentieth = samples.upper_twentieth;
  if (shows_its_samples(samples, noise, options.samples_on_surface)) return false;
  const std::vector<Vec3> moved = points_on_surface(samples, cloud, points, options.host_scalar);
  const std::vector<Vec3> kept = points_at(moved, cloud.input_index);
  if (match_coordinates(kept, {}, progress).samples < cloud.size()) return false;

  SurfaceDetail detail = displacements(cloud, points, moved);
  detail.upper_fifth = samples.upper_fifth;
  detail.upper_twentieth = samples.upper_twentieth;
  undo_denoising(cloud, moved, options.samples.neighbours, options.orientation.plane_neighbours,
                 progress);
  std::vector<NearCopy> not_moved;
  not_moved.swap(cloud.conditioning.near_copies);
  bool is_better = false;
  attempted([&] {  // there is the surface
    progress.set_part(0.3, 1.0);
    CompleteMatching matching =
        match_samples(fitted.surface.mesh, cloud, options.complete_matching, progress);
    OptimisedMesh optimised = optimise_matching(matching, cloud, moved, options, progress);
    RepairReport& repair = optimised.intersection_repair;
    is_better =
        repair.faces_after <= fitted.relaxation.faces_after && optimised.extra_vertices == 0;
    if (!is_better) return;
    fitted.relaxation = RelaxationReport();  // of the surface
    fitted.relaxation.faces_after = repair.faces_after;
    fitted.relaxation.remaining_faces = std::move(repair.remaining_faces);
    fitted.openings = optimised.openings;
    mesh = std::move(optimised.mesh);
  });
  not_moved.swap(cloud.conditioning.near_copies);
  if (!is_better) return false;
  fitted.detail = detail;
  fitted.detail.is_kept = true;
  return true;
}

}  // namespace

ResultMesh stop_at(FittedSurface& fitted, PointCloud& cloud, const std::vector<Vec3>& points,
                   double noise, const ReconstructionOptions& options, Progress& progress) {
  // Membranes that stay were stretched for what is here. Without repair nobody would know whether
  // faces of the matching meet.
  const bool are_left_open = std::all_of(fitted.membranes.begin(), fitted.membranes.end(),
                                         [](const SurfaceMembrane& m) { return m.is_left_open; });
  if (cloud.is_denoised() && options.intersection_repair.enabled && are_left_open) {
    ResultMesh matched;
    if (match_on_surface(fitted, cloud, points, noise, options, matched, progress)) return matched;
  }
  progress.begin(Stage::parametric_surface);
  progress.set_part(1.0, 1.0);
  SurfaceMesh& surface = fitted.surface.mesh;
  const SurfaceOpenings openings = cut_surface_openings(surface, fitted.membranes, progress);
  const std::vector<Index>& dropped = openings.opening_faces;
  if (static_cast<Index>(dropped.size()) == surface.face_count())
    throw ReconstructionFailed(
        "nothing but openings: no part of the surface has samples on its outer side. Close the "
        "openings in place of leaving them open.");
  if (!dropped.empty()) round_to_host(surface, cloud.frame, options.host_scalar);
  // What is to be matched has to face as it was fitted.
  if (options.stop_at_parametric_surface) turn_outward(surface, dropped, progress);
  ResultMesh mesh = to_result(surface, cloud.frame, progress);
  drop_faces(mesh, dropped, progress);
  mesh.face_quality = spanning_lengths(mesh, indices_after_drop(openings.spanning_faces, dropped),
                                       cloud.frame.to_input_length(cloud.spacing));
  fitted.openings = openings.report;
  for (const float length : mesh.face_quality)
    fitted.openings.longest_edge =
        std::max(fitted.openings.longest_edge, static_cast<double>(length));
  if (!dropped.empty() && options.intersection_repair.enabled) {
    RelaxationReport& relaxation = fitted.relaxation;
    relaxation.remaining_faces = self_intersecting_faces(mesh.position, mesh.triangles, progress);
    relaxation.faces_after = static_cast<Index>(relaxation.remaining_faces.size());
  }
  return mesh;
}

}  // namespace shrinkwrap
