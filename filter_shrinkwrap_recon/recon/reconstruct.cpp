#include "reconstruct.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "common/available_memory.h"
#include "common/freed_memory.h"
#include "common/memory_estimate.h"
#include "detail.h"
#include "fit_surface.h"
#include "initial_mesh/bounding_box_start.h"
#include "match_cloud.h"
#include "orient_and_smooth.h"
#include "report/stage_qualities.h"
#include "second_attempt.h"
#include "stage_log.h"

namespace shrinkwrap {
namespace {

bool are_of_single_precision(const std::vector<Vec3>& points) {
  return std::all_of(points.begin(), points.end(),
                     [](const Vec3& p) { return !p.allFinite() || rounded_to_single(p) == p; });
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
    result.denoising = denoise(cloud, result.noise.of_others(), options.samples.neighbours,
                               options.denoising, progress);
  }
  FittedSurface fitted = fit_surface(std::move(control.mesh), cloud, options, progress);
  if (is_needed) keep_detail(initial.mesh, cloud, options, fitted, result, log, progress);
  initial.mesh = SurfaceMesh();
  finish_surface(fitted, cloud, options, progress);
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
  CompleteMatching matching = match_cloud(std::move(parametric), cloud, result.outliers, points,
                                          result.noise.of_others(), options, progress);
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
  keep_samples(options);
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
  keep_samples(options);
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
    if (result.backs.is_taken) {
      for_second.complete_matching.backs_are_openings = true;
      second.backs = result.backs;
    }
    match_smoothed(cloud, points, noise, for_second, second, progress);
  });
}

Reconstruction run(const std::vector<Vec3>& points, ReconstructionOptions options,
                   Progress& progress) {
  Reconstruction result;
  StageLog log(result, options);

  const std::uint64_t of_box = is_robust(options) ? 0 : vertices_after(options.initial_mesh.levels);
  require_memory_for({points.size(), options.samples.neighbours, options.keep_stages, of_box},
                     options.memory_limit);
  options.host_scalar = host_scalar_for(points, options);
  // What is free now: by the time the samples are looked at, they take some of it.
  options.samples.keeps_stages = options.keep_stages;
  options.samples.memory_limit =
      options.memory_limit > 0 ? options.memory_limit : available_bytes();
  FarStrays far_strays;
  if (options.outliers.exclude)
    far_strays = find_far_strays(points, options.outliers.far_strays, progress);
  PointCloud cloud = prepare_samples(points, options.samples, progress, far_strays);
  result.conditioning = cloud.conditioning;
  log.add(Stage::samples, cloud.size());

  if (options.outliers.exclude) {
    result.outliers = exclude_outliers(cloud, points, options.outliers, progress, far_strays);
    result.conditioning.coordinate_step = cloud.conditioning.coordinate_step;
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
      result.mesh = stop_at(fitted, cloud, points, result.noise.of_others(), options, progress);
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
