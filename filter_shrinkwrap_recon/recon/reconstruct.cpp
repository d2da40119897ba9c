#include "reconstruct.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "common/attempted.h"
#include "common/freed_memory.h"
#include "common/memory_estimate.h"
#include "complete_matching/finish_matching.h"
#include "complete_matching/near_copy_insertion.h"
#include "detail.h"
#include "geometry/coordinate_matches.h"
#include "initial_mesh/bounding_box_start.h"
#include "mesh/bodies.h"
#include "mesh/self_intersection.h"
#include "report/outliers_on_surface.h"
#include "report/stage_qualities.h"
#include "second_attempt.h"
#include "stage_log.h"
#include "stop_at_surface/membrane_stretching.h"

namespace shrinkwrap {
namespace {

// Whether the surface is fitted to samples that are moved onto the one that they suggest.
bool may_denoise(const ReconstructionOptions& options, double noise) {
  return options.stop_at_parametric_surface && is_robust(options) &&
         noise >= options.denoising.from;
}

bool are_of_single_precision(const std::vector<Vec3>& points) {
  return std::all_of(points.begin(), points.end(),
                     [](const Vec3& p) { return !p.allFinite() || rounded_to_single(p) == p; });
}

// Measures and orients the normals of a noisy cloud anew over wider neighbourhoods, moves its
// samples onto the surface that they scatter about, and enlarges the voxels, the more so the
// noisier the samples are.
DenoisingReport smooth_for_noise(PointCloud& cloud, const NoiseEstimate& noise,
                                 ReconstructionOptions& options, OrientationReport& orientation,
                                 Progress& progress) {
  constexpr double kWider = 1.0, kLargerVoxels = 0.35;
  constexpr double kSharpenedFrom = 0.04;                 // noise that makes samples count as sharp
  constexpr double kAttraction = 0.4, kRelaxation = 0.3;  // from one unit on
  const NoiseOptions& limits = options.noise;
  const double units = std::clamp((noise.upper_fifth - limits.smooth_from) / limits.smooth_unit,
                                  0.0, std::max(limits.most_units, 0.0));
  const int neighbours = options.samples.neighbours;
  if (units > 0.0) {
    const double widening = cloud.conditioning.on_lines ? 0.0 : kWider * units;
    const int wider = static_cast<int>(std::lround(neighbours * (1.0 + widening)));
    OrientationOptions orientation_options = options.orientation;
    orientation_options.plane_neighbours = std::max(orientation_options.plane_neighbours, wider);
    progress.set_part(0.2, 0.3);
    measure_neighbourhoods(cloud, wider, progress);
    progress.set_part(0.3, 0.45);
    orientation = orient_normals(cloud, orientation_options, progress);
  }
  progress.set_part(0.45, 1.0);
  const DenoisingReport report =
      denoise(cloud, noise.median, neighbours, options.denoising, progress);
  options.initial_mesh.voxel_size *= 1.0 + kLargerVoxels * units;
  if (noise.median >= kSharpenedFrom) options.initial_mesh.voxel_ratio_for_detail = 0.0;
  const double part = std::min(units, 1.0);
  const auto towards = [&](double& value, double at_one) { value += part * (at_one - value); };
  towards(options.parametric_surface.attraction, kAttraction);
  towards(options.parametric_surface.relaxation, kRelaxation);
  return report;
}

// From the cloud to the parametric surface.
FittedSurface make_surface(PointCloud& cloud, const ReconstructionOptions& options,
                           Reconstruction& result, StageLog& log, Progress& progress) {
  if (options.initial_mesh.start == InitialMeshOptions::Start::bounding_box)
    log.add_layer("bounding box",
                  [&] { return to_result(box_around(cloud), cloud.frame, progress); });

  InitialMesh initial = make_initial_mesh(cloud, options.initial_mesh, progress);
  result.initial_mesh = initial.report;
  round_to_host(initial.mesh, cloud.frame, options.host_scalar);
  log.add(Stage::initial_mesh, initial.mesh.vertex_count(),
          [&] { return to_result(initial.mesh, cloud.frame, progress); });

  const bool is_needed = may_keep_detail(options);
  ControlMesh control = make_control_mesh(is_needed ? initial.mesh : std::move(initial.mesh),
                                          cloud.size(), options.control_mesh, progress);
  round_to_host(control.mesh, cloud.frame, options.host_scalar);
  log.add(Stage::control_mesh, control.mesh.vertex_count(),
          [&] { return to_result(control.mesh, cloud.frame, progress); });
  result.control_mesh = control.report;

  // Samples too clean to be moved before.
  if (may_denoise(options, result.noise.median) && !cloud.is_denoised()) {
    progress.begin(Stage::parametric_surface);
    progress.set_part(0.0, 0.4);
    result.denoising = denoise(cloud, result.noise.median, options.samples.neighbours,
                               options.denoising, progress);
  }
  FittedSurface fitted = fit_surface(std::move(control.mesh), cloud, options, progress);
  if (is_needed) keep_detail(initial.mesh, cloud, options, fitted, result, log, progress);
  initial.mesh = SurfaceMesh();
  result.parametric_surface = fitted.surface.report;
  log.add(Stage::parametric_surface, fitted.surface.mesh.vertex_count(),
          [&] { return to_result(fitted.surface.mesh, cloud.frame, progress); });
  return fitted;
}

// From the parametric surface to the mesh through every sample.
void match(SurfaceMesh parametric, PointCloud& cloud, const std::vector<Vec3>& points,
           const ReconstructionOptions& options, Reconstruction& result, StageLog& log,
           Progress& progress) {
  const SurfaceMesh surface = options.keep_stages ? parametric : SurfaceMesh();
  CompleteMatching matching =
      match_cloud(std::move(parametric), cloud, result.outliers, points, options, progress);
  result.complete_matching = matching.report;
  result.spacing = cloud.frame.to_input_length(cloud.spacing);
  const auto distances = [&](const ResultMesh& stage) {
    return distances_from_surface(stage, surface, cloud.frame, progress);
  };
  log.add(Stage::complete_matching, matching.mesh.vertex_count(), [&] {
    ResultMesh stage = to_result(matching, cloud, points, progress);
    stage.vertex_quality = distances(stage);
    stage.face_quality = spanning_lengths(stage, matching.spanning_faces, result.spacing);
    return stage;
  });

  OptimisedMesh optimised = optimise_matching(matching, cloud, points, options, progress);
  result.mesh = std::move(optimised.mesh);
  result.openings = optimised.openings;
  result.edge_optimisation = optimised.edge_optimisation;
  result.intersection_repair = std::move(optimised.intersection_repair);
  result.complete_matching.extra_vertices = optimised.extra_vertices;
  result.complete_matching.cut_out = matching.report.cut_out;
  log.add(Stage::edge_optimisation, matching.mesh.vertex_count());
  if (options.keep_stages) result.mesh.vertex_quality = distances(result.mesh);
}

// The same again with the backs of sheets as openings, where they may have done harm. Near the
// samples of the front, they run into it; but a thin wall has a back too.
void match_sheets(SurfaceMesh parametric, PointCloud& cloud, const std::vector<Vec3>& points,
                  ReconstructionOptions options, Reconstruction& result, StageLog& log,
                  Progress& progress) {
  if (result.parametric_surface.membrane_vertices == 0 || !options.intersection_repair.enabled ||
      options.complete_matching.method != CompleteMatchingOptions::Method::retile ||
      options.complete_matching.backs_are_openings) {
    match(std::move(parametric), cloud, points, options, result, log, progress);
    return;
  }
  constexpr double kFirst = 0.75;       // of the time of both
  constexpr double kMostAtRims = 1e-3;  // x samples: a wide sheet has no other backs
  const double begin = progress.begin_of(Stage::complete_matching),
               end = progress.begin_of(Stage::report);
  Reconstruction second = without_stages(result);
  {
    const double from = (1.0 - kFirst) * begin;
    const ProgressShare share(progress, from, from + kFirst);
    match(parametric, cloud, points, options, result, log, progress);
  }
  if (result.complete_matching.backs <= kMostAtRims * cloud.size()) return;
  options.complete_matching.backs_are_openings = true;
  options.outliers.foot = 0.0;  // as many samples as the first attempt
  const ProgressShare share(progress, kFirst * end, kFirst * end + 1.0 - kFirst);
  try_again(result, second, &Reconstruction::backs, true, cloud, progress, [&] {
    StageLog second_log(second, options);
    match(std::move(parametric), cloud, points, options, second, second_log, progress);
  });
  log.skip();
}

// The samples matched to a surface that is smoothed for their noise, as a run makes it that stops
// there.
void match_smoothed(PointCloud& cloud, const std::vector<Vec3>& points, const NoiseEstimate& noise,
                    ReconstructionOptions options, Reconstruction& result, Progress& progress) {
  StageLog log(result, options);
  options.stop_at_parametric_surface = true;
  options.outliers.foot = 0.0;  // as many samples as the first attempt
  progress.begin(Stage::orientation);
  smooth_for_noise(cloud, noise, options, result.orientation, progress);
  log.add(Stage::orientation, cloud.size());
  ReconstructionOptions to_match = options;  // whatever then becomes of the openings
  to_match.complete_matching.openings = CompleteMatchingOptions::Openings::close;
  FittedSurface fitted = make_surface(cloud, to_match, result, log, progress);
  undo_denoising(cloud, points, options.samples.neighbours, options.orientation.plane_neighbours,
                 progress);
  match_sheets(std::move(fitted.surface.mesh), cloud, points, options, result, log, progress);
}

// Noise gives the surface handles and folds, and so does detail that planes cannot tell: where that
// did harm, it is smoothed.
void match_twice(PointCloud& cloud, const std::vector<Vec3>& points, const NoiseEstimate& noise,
                 const ReconstructionOptions& options, Reconstruction& result, Progress& progress) {
  Reconstruction second = without_stages(result);
  const bool is_noisy = noise.median > options.noise.high;
  const double of_first = is_noisy ? 0.5 : 0.9;  // of the time of both
  {
    const ProgressShare share(progress, 0.0, of_first);
    StageLog log(result, options);
    match_sheets(make_surface(cloud, options, result, log, progress).surface.mesh, cloud, points,
                 options, result, log, progress);
  }
  // Without noise it does little for vertices that are no samples, which close openings.
  if (!is_noisy && !tells_of_wrong_surface(result.intersection_repair,
                                           static_cast<Index>(result.mesh.triangles.size())))
    return;
  const ProgressShare share(progress, of_first, 1.0);
  try_again(result, second, &Reconstruction::smoothing, false, cloud, progress, [&] {
    ReconstructionOptions for_second = options;
    if (result.backs.is_taken) for_second.complete_matching.backs_are_openings = true;
    second.backs = result.backs;
    match_smoothed(cloud, points, noise, for_second, second, progress);
  });
}

Reconstruction run(const std::vector<Vec3>& points, ReconstructionOptions options,
                   Progress& progress) {
  Reconstruction result;
  StageLog log(result, options);

  std::uint64_t size = points.size();
  if (!is_robust(options)) size = std::max(size, vertices_after(options.initial_mesh.levels));
  require_memory_for((options.keep_stages ? 2 : 1) * size, options.memory_limit,
                     options.samples.neighbours);
  options.host_scalar = host_scalar_for(points, options);
  // What is free now: by the time the samples are looked at, they take some of it.
  options.samples.memory_limit =
      options.memory_limit > 0 ? options.memory_limit : available_bytes();
  PointCloud cloud = prepare_samples(points, options.samples, progress);
  result.conditioning = cloud.conditioning;
  log.add(Stage::samples, cloud.size());

  if (options.outliers.exclude) {
    result.outliers = exclude_outliers(cloud, points, options.outliers, progress);
    log.add(Stage::outliers, cloud.size());
  }
  result.spacing = cloud.frame.to_input_length(cloud.spacing);

  const CloudReport samples = orient_and_smooth(cloud, options, progress);
  result.orientation = samples.orientation;
  result.noise = samples.noise;
  result.denoising = samples.denoising;
  log.add(Stage::orientation, cloud.size());

  const bool may_be_smoothed = is_robust(options) && options.intersection_repair.enabled &&
                               samples.noise.median >= options.denoising.from;
  if (may_be_smoothed && !options.stop_at_parametric_surface) {
    match_twice(cloud, points, samples.noise, options, result, progress);
    log.skip();
  } else {
    FittedSurface fitted = make_surface(cloud, options, result, log, progress);
    if (options.stop_at_parametric_surface) {
      result.mesh = stop_at(fitted, cloud, points, result.noise.median, options, progress);
      log.go_on(static_cast<Index>(result.mesh.position.size()));
      result.relaxation = std::move(fitted.relaxation);
      result.openings = fitted.openings;
      result.surface_detail = fitted.detail;
    } else {
      match_sheets(std::move(fitted.surface.mesh), cloud, points, options, result, log, progress);
    }
  }

  progress.begin(Stage::report);
  const std::vector<Vec3> kept = result.outliers.input_index.empty()
                                     ? std::vector<Vec3>()
                                     : points_at(points, cloud.input_indices());
  cloud = PointCloud();
  const bool is_counted =
      !options.stop_at_parametric_surface && options.intersection_repair.enabled;
  result.report = check_promise(result.mesh, kept.empty() ? points : kept,
                                is_counted ? result.intersection_repair.faces_after : kNone,
                                promise_of(options), progress);
  log.add(Stage::report, result.report.vertices);
  return result;
}

}  // namespace

ReconstructionOptions as_in_the_paper() {
  ReconstructionOptions options;
  options.initial_mesh.start = InitialMeshOptions::Start::bounding_box;
  options.control_mesh.area_weighted = false;
  options.parametric_surface.target = ParametricSurfaceOptions::Target::nearest_sample;
  options.parametric_surface.attraction = 0.85;
  options.parametric_surface.relaxation = 0.0;
  options.parametric_surface.fine_enough = 0.0;
  options.complete_matching.method = CompleteMatchingOptions::Method::snap_and_insert;
  options.edge_optimisation.criterion = EdgeOptimisationOptions::Criterion::quadric;
  options.edge_optimisation.crease_angle = 0.0;
  options.edge_optimisation.least_gap = 1.0;
  return options;
}

bool is_robust(const ReconstructionOptions& options) {
  return options.initial_mesh.start == InitialMeshOptions::Start::winding_number;
}

HostScalar host_scalar_for(const std::vector<Vec3>& points, const ReconstructionOptions& options) {
  return are_of_single_precision(points) ? options.host_scalar : HostScalar::double_precision;
}

CloudReport orient_and_smooth(PointCloud& cloud, ReconstructionOptions& options,
                              Progress& progress) {
  CloudReport report;
  options.samples.neighbours = cloud.neighbour_count;  // more, if they would lie on lines
  const bool may_smooth = options.stop_at_parametric_surface && is_robust(options);
  if (may_smooth) {
    progress.begin(Stage::orientation);
    progress.set_part(0.0, 0.15);
  }
  report.orientation = orient_normals(cloud, options.orientation, progress);
  if (may_smooth) progress.set_part(0.15, 0.2);
  report.noise = estimate_noise(cloud, options.noise, progress);
  if (report.noise.median > options.noise.high) {
    options.initial_mesh.dense_spacing = options.initial_mesh.voxel_ratio_for_detail = 0.0;
    if (options.initial_mesh.second_voxel_ratio > 0.0)
      options.initial_mesh.second_voxel_ratio = options.noise.second_voxel_ratio;
  }
  if (may_denoise(options, report.noise.median) &&
      report.noise.median >= options.denoising.before_initial_mesh_from)
    report.denoising = smooth_for_noise(cloud, report.noise, options, report.orientation, progress);
  return report;
}

FittedSurface fit_surface(SurfaceMesh control, const PointCloud& cloud,
                          const ReconstructionOptions& options, Progress& progress) {
  FittedSurface result;
  const bool is_last = options.stop_at_parametric_surface;
  progress.begin(Stage::parametric_surface);
  if (is_last) progress.set_part(0.0, 0.8);
  ParametricSurfaceOptions parametric = options.parametric_surface;
  if (is_last) parametric.fine_enough = 0.0;  // as fine as samples would make it
  result.surface = make_parametric_surface(std::move(control), cloud, parametric, progress);
  SurfaceMesh& mesh = result.surface.mesh;
  if (is_last) {
    progress.set_part(0.8, 0.85);
    result.membranes =
        find_surface_membranes(mesh, mark_membranes(mesh, cloud, parametric, progress), cloud,
                               options.complete_matching, progress);
    stretch_membranes(mesh, result.membranes, progress);
  }
  round_to_host(mesh, cloud.frame, options.host_scalar);
  if (!is_last) return result;
  if (options.intersection_repair.enabled) {
    progress.set_part(0.85, 0.95);
    result.relaxation = relax_self_intersections(mesh, cloud.frame, options.host_scalar,
                                                 options.relaxation, progress);
  }
  progress.set_part(0.95, 1.0);
  measure_distances(result.surface, cloud, options.parametric_surface, progress);
  return result;
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
    RelaxationReport& relaxation = fitted.relaxation;
    RepairReport& repair = optimised.intersection_repair;
    is_better = repair.faces_after <= relaxation.faces_after && optimised.extra_vertices == 0;
    if (!is_better) return;
    relaxation.faces_after = repair.faces_after;
    relaxation.remaining_faces = std::move(repair.remaining_faces);
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
  const bool are_left_open =
      options.complete_matching.openings == CompleteMatchingOptions::Openings::leave_open;
  if (cloud.is_denoised() && options.intersection_repair.enabled &&
      (fitted.membranes.empty() || are_left_open)) {
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
  turn_outward(surface, dropped, progress);
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

CompleteMatching match_cloud(SurfaceMesh parametric, PointCloud& cloud, OutlierReport& outliers,
                             const std::vector<Vec3>& points, const ReconstructionOptions& options,
                             Progress& progress) {
  if (outliers.input_index.empty())
    return match_samples(std::move(parametric), cloud, options.complete_matching, progress);
  progress.begin(Stage::complete_matching);
  progress.set_part(0.0, 0.5);
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
  result.openings = decide_openings(matching, cloud, options.complete_matching, progress);
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
    insert_near_copies(matching, cloud, points, progress);
    if (options.intersection_repair.enabled)
      repair.add(repair_self_intersections(matching.mesh, options.intersection_repair, progress,
                                           matching.opening_faces, &matching.spanning_faces));
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

PromiseOptions promise_of(const ReconstructionOptions& options) {
  PromiseOptions promise;
  promise.may_be_open =
      options.complete_matching.openings != CompleteMatchingOptions::Openings::close;
  promise.matches_samples = !options.stop_at_parametric_surface;
  promise.report = options.report;
  return promise;
}

std::vector<Stage> stages_of(const ReconstructionOptions& options) {
  std::vector<Stage> stages = {Stage::samples};
  if (options.outliers.exclude) stages.push_back(Stage::outliers);
  stages.insert(stages.end(), {Stage::orientation, Stage::initial_mesh, Stage::control_mesh,
                               Stage::parametric_surface});
  if (!options.stop_at_parametric_surface || may_denoise(options, options.denoising.from)) {
    stages.push_back(Stage::complete_matching);
    stages.push_back(Stage::edge_optimisation);
  }
  stages.push_back(Stage::report);
  return stages;
}

Reconstruction reconstruct(const std::vector<Vec3>& points, const ReconstructionOptions& options,
                           Progress& progress) {
  const FreedMemoryIsKept freed_memory_is_kept(points.size());
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  return arena.execute([&] { return run(points, options, progress); });
}

}  // namespace shrinkwrap
