#include "filter_runs.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/available_memory.h"
#include "common/memory_estimate.h"
#include "complete_matching/outliers_off_surface.h"
#include "complete_matching/outliers_on_surface.h"
#include "filter_log.h"
#include "fit_surface.h"
#include "geometry/coordinate_matches.h"
#include "initial_mesh/bounding_box_start.h"
#include "match_cloud.h"
#include "orient_and_smooth.h"
#include "report/carried_data.h"
#include "report/nearest_points.h"
#include "report/stage_qualities.h"

namespace shrinkwrap {
namespace {

Figures figures_of(const MeshReport& report) {
  return {{"vertices", report.vertices},
          {"faces", report.faces},
          {"components", report.components},
          {"genus", report.genus},
          {"border_loops", report.border_loops},
          {"self_intersecting_faces", report.self_intersecting_faces},
          {"samples", report.samples},
          {"samples_matched", report.samples_matched},
          {"samples_missing", report.samples_missing},
          {"extra_vertices", report.vertices_extra}};
}

// The mesh of a layer, which its user may have changed.
SurfaceMesh closed_surface(const ResultMesh& mesh, const Frame& frame) {
  try {
    return to_surface(mesh, frame);
  } catch (const InvalidInput& error) {
    throw InvalidInput(std::string(error.what()) +
                       ". Choose the layer that the stage before made (one whose openings were "
                       "left open is finished), or repair the mesh first (menu Filters, Cleaning "
                       "and Repairing).");
  }
}

ResultMesh outlier_layer(const OutlierReport& report, const std::vector<Vec3>& points) {
  ResultMesh layer;
  layer.input_index = report.input_index;
  layer.position = points_at(points, report.input_index);
  return layer;
}

// --- the samples of a stage that runs on its own ---

PointCloud without_outliers(const FilterInput& input, const ReconstructionOptions& options,
                            OutlierReport& outliers, Progress& progress) {
  if (!options.outliers.exclude) return prepare_samples(input.points, options.samples, progress);
  const FarStrays far_strays = find_far_strays(input.points, options.outliers.far_strays, progress);
  PointCloud cloud = prepare_samples(input.points, options.samples, progress, far_strays);
  outliers = exclude_outliers(cloud, input.points, options.outliers, progress, far_strays);
  return cloud;
}

void tell_of_samples(const ConditioningReport& report, double spacing, FilterOutcome& outcome) {
  outcome.log.push_back(conditioning_line(report, spacing));
  const std::string steps = coordinate_step_line(report, spacing);
  if (!steps.empty()) outcome.warnings.push_back(steps);
}

void tell_of_spacing(const PointCloud& cloud, FilterOutcome& outcome) {
  tell_of_samples(cloud.conditioning, cloud.frame.to_input_length(cloud.spacing), outcome);
}

PointCloud prepare(const FilterInput& input, const ReconstructionOptions& options,
                   Progress& progress, FilterOutcome& outcome) {
  OutlierReport outliers;
  PointCloud cloud = without_outliers(input, options, outliers, progress);
  tell_of(outliers, outcome);
  outcome.outliers = outlier_layer(outliers, input.points);
  tell_of_spacing(cloud, outcome);
  return cloud;
}

// As a surface is made from them; `options` of the later stages are changed to suit.
PointCloud prepare_oriented(Filter filter, const FilterInput& input, ReconstructionOptions& options,
                            CloudReport& samples, Progress& progress, FilterOutcome& outcome) {
  PointCloud cloud = prepare(input, options, progress, outcome);
  samples = orient_and_smooth(cloud, options, progress);
  warn_of(samples.orientation, outcome.warnings);
  tell_of_noise(filter, samples.noise, samples.denoising, options, outcome);
  tell_of_view(samples.orientation, outcome);
  return cloud;
}

// As a parametric surface meets them: where they are, with the normals that it was made with.
PointCloud prepare_to_match(const FilterInput& input, ReconstructionOptions options,
                            OutlierReport& outliers, double& noise, Progress& progress,
                            FilterOutcome& outcome) {
  PointCloud cloud = without_outliers(input, options, outliers, progress);
  tell_of_spacing(cloud, outcome);
  const CloudReport samples = orient_and_smooth(cloud, options, progress);
  warn_of(samples.orientation, outcome.warnings);
  noise = samples.noise.of_others();
  if (cloud.is_denoised())
    undo_denoising(cloud, input.points, options.samples.neighbours,
                   options.orientation.plane_neighbours, progress);
  return cloud;
}

// Whether a near copy is a vertex of the mesh, as in one that is finished.
bool has_near_copies(const FilterInput& input, const PointCloud& cloud) {
  std::vector<Vec3> copies;
  for (const NearCopy& pair : cloud.conditioning.near_copies)
    copies.push_back(input.points[pair.copy]);
  std::sort(copies.begin(), copies.end(), coordinates_less);
  return std::any_of(input.mesh.position.begin(), input.mesh.position.end(), [&](const Vec3& p) {
    return p.allFinite() && std::binary_search(copies.begin(), copies.end(), p, coordinates_less);
  });
}

// As a mesh through them has them: with the outliers that the matching made samples again, without
// those that it found, and with near copies if it has those already.
PointCloud prepare_as_matched(const FilterInput& input, ReconstructionOptions options,
                              OutlierReport& outliers, Progress& progress) {
  PointCloud cloud = without_outliers(input, options, outliers, progress);
  if (has_near_copies(input, cloud)) {
    options.samples.near_copies.enabled = false;
    cloud = without_outliers(input, options, outliers, progress);
  }
  keep_outliers_among(cloud, outliers, input.points, input.mesh.position, progress);
  if (options.outliers.exclude)
    leave_out_samples_off_mesh(cloud, outliers, input.points, input.mesh.position,
                               input.mesh.triangles, options.outliers, progress);
  return cloud;
}

// --- filters ---

FilterOutcome run_reconstruct(const FilterRequest& request, const FilterInput& input,
                              Progress& progress) {
  Reconstruction result = reconstruct(input.points, request.options, progress);

  FilterOutcome outcome;
  outcome.figures = figures_of(result.report);
  tell_of_samples(result.conditioning, result.spacing, outcome);
  tell_of_noise(Filter::reconstruct, result.noise, result.denoising, request.options, outcome);
  tell_of_view(result.orientation, outcome);
  tell_of_sheet(result.orientation, request.options, outcome);
  double total = 0.0;
  for (const StageRecord& stage : result.stages) {
    if (!stage.is_timed) continue;
    outcome.log.push_back(table_row(stage.name, stage.vertices, stage.seconds));
    std::string key = "seconds_" + stage.name;
    std::replace(key.begin(), key.end(), ' ', '_');
    outcome.figures[key] = stage.seconds;
    total += stage.seconds;
  }
  outcome.figures["seconds_total"] = total;
  outcome.log.push_back(table_row("total", static_cast<Index>(result.mesh.position.size()), total));
  for (std::string& line : describe(result.report)) outcome.log.push_back(std::move(line));
  tell_of_detail(result, outcome);
  tell_of_attempts(result, outcome);
  tell_of(result.surface_detail, outcome);
  tell_of(result.outliers, outcome);
  const bool is_surface = request.options.stop_at_parametric_surface;
  outcome.log.push_back(kSucceeded +
                        (is_surface ? verdict_on_surface(result.report)
                                    : verdict_of(result.report) + but_outliers(result.outliers)));
  outcome.outliers = outlier_layer(result.outliers, input.points);
  warn_of(result.orientation, outcome.warnings);
  warn_of(result.initial_mesh, outcome.warnings);
  warn_of(result.complete_matching, outcome.warnings);
  warn_of_openings(request.options, outcome.warnings);
  warn_of_intersections(result.intersection_repair.faces_after, outcome.warnings);
  warn_of_intersections(result.relaxation.faces_after, outcome.warnings);
  if (result.initial_mesh.is_of_detail_size)
    outcome.log.insert(outcome.log.end() - 1, detail_line(result.initial_mesh));
  if (result.initial_mesh.refined_parts > 0)
    outcome.log.insert(outcome.log.end() - 1, dense_parts_line(result.initial_mesh));
  if (result.intersection_repair.faces_before > 0)
    outcome.log.insert(outcome.log.end() - 1, repair_line(result.intersection_repair));
  if (result.intersection_repair.folds.has_done_any())
    outcome.log.insert(outcome.log.end() - 1, folds_line(result.intersection_repair.folds));
  if (result.relaxation.faces_before > 0)
    outcome.log.insert(outcome.log.end() - 1, relaxation_line(result.relaxation));
  if (result.openings.spanned + result.openings.left_open > 0)
    outcome.log.insert(outcome.log.end() - 1, openings_line(result.openings));

  outcome.marked_faces = std::move(is_surface ? result.relaxation.remaining_faces
                                              : result.intersection_repair.remaining_faces);
  outcome.layer_suffix = is_surface ? "shrink wrap parametric surface" : "shrink wrap";
  outcome.mesh = std::move(result.mesh);
  for (StageRecord& stage : result.stages) {
    // The last stage that made a mesh is the result itself, unless the samples were matched to it.
    const bool is_result =
        !result.surface_detail.is_kept && &stage == &result.stages[result.stages.size() - 2];
    if (!is_result && !stage.mesh.triangles.empty()) outcome.stages.push_back(std::move(stage));
  }
  return outcome;
}

FilterOutcome run_initial_mesh(const FilterRequest& request, const FilterInput& input,
                               Progress& progress) {
  FilterOutcome outcome;
  ReconstructionOptions options = request.options;
  CloudReport samples;
  const PointCloud cloud =
      prepare_oriented(Filter::initial_mesh, input, options, samples, progress, outcome);
  const InitialMesh initial = make_initial_mesh(cloud, options.initial_mesh, progress);
  warn_of(initial.report, outcome.warnings);
  if (initial.report.is_of_detail_size) outcome.log.push_back(detail_line(initial.report));
  if (initial.report.refined_parts > 0) outcome.log.push_back(dense_parts_line(initial.report));
  outcome.log.push_back(surface_verdict("initial mesh", initial.mesh));
  outcome.mesh = to_result(initial.mesh, cloud.frame, progress);
  outcome.layer_suffix = "initial mesh";
  return outcome;
}

FilterOutcome run_control_mesh(const FilterRequest& request, const FilterInput& input,
                               Progress& progress) {
  FilterOutcome outcome;
  const PointCloud cloud = prepare(input, request.options, progress, outcome);
  const ControlMesh control =
      make_control_mesh(closed_surface(input.mesh, cloud.frame), cloud.size(),
                        request.options.control_mesh, progress);
  outcome.log.push_back("target " + count_of(control.report.target_vertices, "vertex", "vertices"));
  outcome.log.push_back(surface_verdict("control mesh", control.mesh));
  outcome.mesh = to_result(control.mesh, cloud.frame, progress);
  outcome.layer_suffix = "control mesh";
  return outcome;
}

FilterOutcome run_parametric_surface(const FilterRequest& request, const FilterInput& input,
                                     Progress& progress) {
  FilterOutcome outcome;
  ReconstructionOptions options = request.options;
  options.host_scalar = host_scalar_for(input.points, options);
  CloudReport samples;
  PointCloud cloud =
      prepare_oriented(Filter::parametric_surface, input, options, samples, progress, outcome);
  FittedSurface fitted =
      fit_surface(closed_surface(input.mesh, cloud.frame), cloud, options, progress);
  finish_surface(fitted, cloud, options, progress);
  outcome.mesh = stop_at(fitted, cloud, input.points, samples.noise.of_others(), options, progress);
  tell_of(fitted.detail, outcome);
  RelaxationReport& relaxation = fitted.relaxation;
  const ParametricSurface& surface = fitted.surface;
  if (relaxation.faces_before > 0) outcome.log.push_back(relaxation_line(relaxation));
  warn_of_intersections(relaxation.faces_after, outcome.warnings);
  outcome.marked_faces = std::move(relaxation.remaining_faces);
  if (fitted.openings.spanned + fitted.openings.left_open > 0)
    outcome.log.push_back(openings_line(fitted.openings));
  if (!fitted.detail.is_kept)
    outcome.log.push_back("distance of the vertices from the samples' surface: mean " +
                          formatted("%.3f", surface.report.mean_distance) + ", greatest " +
                          formatted("%.3f", surface.report.max_distance) + " spacings");
  warn_of_subdivision(surface.report, cloud.size(), outcome.warnings);
  outcome.log.push_back(fitted.detail.is_kept
                            ? detail_verdict("parametric surface", outcome.mesh)
                            : surface_verdict("parametric surface", surface.mesh));
  outcome.layer_suffix = "parametric surface";
  return outcome;
}

FilterOutcome run_complete_matching(const FilterRequest& request, const FilterInput& input,
                                    Progress& progress) {
  FilterOutcome outcome;
  OutlierReport outliers;
  double noise = 0.0;
  PointCloud cloud = prepare_to_match(input, request.options, outliers, noise, progress, outcome);
  const SurfaceMesh surface = closed_surface(input.mesh, cloud.frame);
  const OutlierReport known = outliers;  // a stage before made a layer of them
  CompleteMatching matching =
      match_cloud(surface, cloud, outliers, input.points, noise, request.options, progress);
  tell_of(outliers, outcome);
  OutlierReport found;
  std::set_difference(outliers.input_index.begin(), outliers.input_index.end(),
                      known.input_index.begin(), known.input_index.end(),
                      std::back_inserter(found.input_index));
  outcome.outliers = outlier_layer(found, input.points);
  warn_of(matching.report, outcome.warnings);
  warn_of_openings(request.options, outcome.warnings);
  outcome.log.push_back("distance of the samples from the parametric surface: mean " +
                        formatted("%.3f", matching.report.mean_foot_distance) + ", greatest " +
                        formatted("%.3f", matching.report.max_foot_distance) + " spacings; " +
                        count_of(matching.report.membranes, "opening") +
                        (matching.report.notches_filled > 0
                             ? ", " + notches_filled(matching.report.notches_filled)
                             : ""));
  outcome.log.push_back(surface_verdict("complete matching", matching.mesh));
  outcome.mesh = to_result(matching, cloud, input.points, progress);
  outcome.mesh.vertex_quality =
      distances_from_surface(outcome.mesh, surface, cloud.frame, progress);
  outcome.mesh.face_quality = spanning_lengths(outcome.mesh, matching.spanning_faces,
                                               cloud.frame.to_input_length(cloud.spacing));
  outcome.marked_faces = std::move(matching.spanning_faces);
  outcome.layer_suffix = "complete matching";
  return outcome;
}

// The complete matching that a mesh through the samples was made from: vertex i is sample i,
// further vertices follow, faces as they are. Throws InvalidInput if a sample is no vertex of the
// mesh.
CompleteMatching matching_of(const FilterInput& input, const PointCloud& cloud) {
  const auto order_of = [](Index count, const auto& at) {
    std::vector<Index> order;
    for (Index i = 0; i < count; ++i)
      if (at(i).allFinite()) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
      const Vec3 &p = at(a), &q = at(b);
      return p == q ? a < b : coordinates_less(p, q);
    });
    return order;
  };
  const auto sample_at = [&](Index sample) -> const Vec3& {
    return input.points[cloud.input_index[sample]];
  };
  const auto vertex_at = [&](Index vertex) -> const Vec3& { return input.mesh.position[vertex]; };
  const Index vertices = static_cast<Index>(input.mesh.position.size());
  const std::vector<Index> samples = order_of(cloud.size(), sample_at);
  const std::vector<Index> by_position = order_of(vertices, vertex_at);

  std::vector<Index> new_index(static_cast<std::size_t>(vertices), kNone);
  Index matched = 0;
  for (const Index vertex : by_position)
    if (matched < cloud.size() && vertex_at(vertex) == sample_at(samples[matched]))
      new_index[vertex] = samples[matched++];
  if (matched < cloud.size())
    throw InvalidInput(
        "the mesh does not pass through every sample: choose the layer that Complete Matching made "
        "from "
        "these samples, with the same selection");
  Index extra = cloud.size();
  for (Index& index : new_index)
    if (index == kNone) index = extra++;

  ResultMesh renumbered;
  renumbered.position.resize(input.mesh.position.size());
  for (Index v = 0; v < vertices; ++v) renumbered.position[new_index[v]] = vertex_at(v);
  renumbered.triangles = input.mesh.triangles;
  for (Triangle& triangle : renumbered.triangles)
    for (Index& v : triangle) v = new_index[v];

  CompleteMatching matching;
  matching.mesh = closed_surface(renumbered, cloud.frame);
  matching.sample_of_vertex.assign(static_cast<std::size_t>(vertices), SampleId::none);
  for (Index sample = 0; sample < cloud.size(); ++sample)
    matching.sample_of_vertex[sample] = to_sample(sample);
  return matching;
}

FilterOutcome run_edge_optimisation(const FilterRequest& request, const FilterInput& input,
                                    Progress& progress) {
  FilterOutcome outcome;
  OutlierReport outliers;
  const PointCloud cloud = prepare_as_matched(input, request.options, outliers, progress);
  tell_of(outliers, outcome);
  tell_of_spacing(cloud, outcome);
  warn_of_openings(request.options, outcome.warnings);
  CompleteMatching matching = matching_of(input, cloud);
  matching.spanning_faces = spanning_faces(input.mesh, cloud.frame.to_input_length(cloud.spacing));
  OptimisedMesh optimised =
      optimise_matching(matching, cloud, input.points, request.options, progress);
  outcome.mesh = std::move(optimised.mesh);
  outcome.layer_suffix = "shrink wrap";

  outcome.log.push_back(count_of(optimised.edge_optimisation.flips, "edge flip"));
  if (optimised.removed_extra > 0)
    outcome.log.push_back(
        count_of(optimised.removed_extra, "vertex", "vertices") +
        " without a sample could be removed after all, and openings are spanned there.");
  RepairReport& repair = optimised.intersection_repair;
  if (repair.faces_before > 0) outcome.log.push_back(repair_line(repair));
  if (repair.folds.has_done_any()) outcome.log.push_back(folds_line(repair.folds));
  warn_of_intersections(repair.faces_after, outcome.warnings);
  outcome.marked_faces = std::move(repair.remaining_faces);
  const OpeningsReport& openings = optimised.openings;
  if (openings.spanned + openings.left_open > 0) outcome.log.push_back(openings_line(openings));

  progress.begin(Stage::report);
  const bool is_counted = request.options.intersection_repair.enabled;
  const MeshReport checked =
      check_promise(outcome.mesh, points_at(input.points, cloud.input_indices()),
                    is_counted ? repair.faces_after : kNone, promise_of(request.options), progress);
  for (const auto& [name, value] : figures_of(checked)) outcome.figures[name] = value;
  outcome.log.push_back(kSucceeded + verdict_of(checked) + but_outliers(outliers));
  return outcome;
}

// The samples that a mesh is to pass through; all of them where no cloud can be made of them.
std::vector<Vec3> samples_to_match(const FilterInput& input, const ReconstructionOptions& options,
                                   OutlierReport& outliers, Progress& progress) {
  try {
    const PointCloud cloud = prepare_as_matched(input, options, outliers, progress);
    return points_at(input.points, cloud.input_indices());
  } catch (const InvalidInput&) {
    return input.points;
  }
}

FilterOutcome run_matching_report(const FilterRequest& request, const FilterInput& input,
                                  Progress& progress) {
  progress.begin(Stage::report);
  FilterOutcome outcome;
  MeshReport report = measure_mesh(input.mesh.position, input.mesh.triangles, input.points,
                                   request.options.report, progress);
  OutlierReport outliers;
  // Only if samples are missing does it matter which of them are outliers: of a mesh through all of
  // them none is left out.
  if (report.samples_missing > 0 && request.options.outliers.exclude) {
    const std::vector<Vec3> kept = samples_to_match(input, request.options, outliers, progress);
    if (!outliers.input_index.empty()) {
      MeshReportOptions again = request.options.report;
      again.count_self_intersections = false;
      const Index self_intersecting_faces = report.self_intersecting_faces;
      report = measure_mesh(input.mesh.position, input.mesh.triangles, kept, again, progress);
      report.self_intersecting_faces = self_intersecting_faces;
    }
  }
  tell_of(outliers, outcome);
  const bool is_complete = report.closed() && report.manifold() && report.complete_matching();
  for (const auto& [name, value] : figures_of(report)) outcome.figures[name] = value;
  for (std::string& line : describe(report)) outcome.log.push_back(std::move(line));
  const std::string verdict = std::string(is_complete ? "complete: " : "NOT complete: ") +
                              verdict_of(report) + but_outliers(outliers);
  if (!is_complete && request.fail_if_incomplete) throw ReconstructionFailed(verdict);
  outcome.log.push_back(kSucceeded + verdict);
  return outcome;
}

FilterOutcome run_distance(const FilterInput& input, Progress& progress) {
  progress.begin(Stage::report);
  const Index samples = static_cast<Index>(std::count_if(
      input.points.begin(), input.points.end(), [](const Vec3& p) { return p.allFinite(); }));
  if (samples == 0) throw InvalidInput("there are no samples with finite coordinates");
  const std::vector<NearestPoint> nearest =
      nearest_points(input.points, input.mesh.position, progress);

  FilterOutcome outcome;
  const Index count = static_cast<Index>(nearest.size());
  outcome.distance.assign(nearest.size(), 0.0);
  Index not_measured = 0;
  for (Index v = 0; v < count; ++v) {
    if (nearest[v].index == kNone)
      ++not_measured;
    else
      outcome.distance[v] = nearest[v].distance;
  }
  if (not_measured > 0)
    outcome.warnings.push_back(count_of(not_measured, "vertex", "vertices") +
                               " not finite, or too far away: their distance is set to 0.");
  const double mean = std::accumulate(outcome.distance.begin(), outcome.distance.end(), 0.0) /
                      std::max(count - not_measured, Index{1});
  const double greatest = *std::max_element(outcome.distance.begin(), outcome.distance.end());
  outcome.figures = {{"vertices", count}, {"mean_distance", mean}, {"greatest_distance", greatest}};
  outcome.log.push_back(kSucceeded + std::string("distance of ") +
                        count_of(count - not_measured, "vertex", "vertices") + " from " +
                        count_of(samples, "point") + ": mean " + formatted("%.6g", mean) +
                        ", greatest " + formatted("%.6g", greatest));
  return outcome;
}

FilterOutcome dispatch(Filter filter, const FilterRequest& request, const FilterInput& input,
                       Progress& progress) {
  switch (filter) {
    case Filter::reconstruct:
      return run_reconstruct(request, input, progress);
    case Filter::initial_mesh:
      return run_initial_mesh(request, input, progress);
    case Filter::control_mesh:
      return run_control_mesh(request, input, progress);
    case Filter::parametric_surface:
      return run_parametric_surface(request, input, progress);
    case Filter::complete_matching:
      return run_complete_matching(request, input, progress);
    case Filter::edge_optimisation:
      return run_edge_optimisation(request, input, progress);
    case Filter::matching_report:
      return run_matching_report(request, input, progress);
    case Filter::distance_to_samples:
      return run_distance(input, progress);
  }
  throw InvalidInput("unknown filter");
}

}  // namespace

std::vector<Stage> stages_of(Filter filter, const FilterRequest& request) {
  std::vector<Stage> stages = {Stage::samples};
  if (request.options.outliers.exclude) stages.push_back(Stage::outliers);
  const auto and_then = [&](std::initializer_list<Stage> more) {
    stages.insert(stages.end(), more);
    return stages;
  };
  switch (filter) {
    case Filter::reconstruct:
      return stages_of(request.options);
    case Filter::initial_mesh:
      return and_then({Stage::orientation, Stage::initial_mesh});
    case Filter::control_mesh:
      return and_then({Stage::control_mesh});
    case Filter::parametric_surface:
      return and_then({Stage::orientation, Stage::parametric_surface});
    case Filter::complete_matching:
      return and_then({Stage::orientation, Stage::complete_matching});
    case Filter::edge_optimisation:
      return and_then({Stage::edge_optimisation, Stage::report});
    case Filter::matching_report:
    case Filter::distance_to_samples:
      return {Stage::report};
  }
  return {};
}

FilterOutcome run_filter(Filter filter, const FilterRequest& request, const FilterInput& input,
                         Progress& progress) {
  const bool needs_mesh = filter != Filter::reconstruct && filter != Filter::initial_mesh;
  const bool needs_faces = needs_mesh && filter != Filter::distance_to_samples;
  if (needs_faces && input.mesh.triangles.empty())
    throw InvalidInput(
        "the layer chosen as Mesh has no faces: choose one that a reconstruction filter made "
        "(where stray points were left out, layers of them lie between those of the meshes)");
  if (needs_mesh && input.mesh.position.empty())
    throw InvalidInput("the layer chosen as Mesh has no vertices: choose another");

  // A control mesh becomes up to 64 times as large, but no more than 3 times the samples; the box
  // of the paper's start as large as it is asked to; other stages keep the size of theirs. The
  // whole method looks for itself.
  const std::uint64_t samples = input.points.size(), vertices = input.mesh.position.size();
  const std::uint64_t subdivided = filter == Filter::parametric_surface
                                       ? std::min(64 * vertices, 3 * samples)
                                   : filter == Filter::initial_mesh && !is_robust(request.options)
                                       ? vertices_after(request.options.initial_mesh.levels)
                                       : 0;
  if (filter != Filter::reconstruct && filter != Filter::distance_to_samples)
    require_memory_for(
        {samples, request.options.samples.neighbours, false, std::max(vertices, subdivided)},
        request.options.memory_limit);

  // What is free now: by the time the samples are looked at, they take some of it.
  FilterRequest limited = request;
  const std::uint64_t limit = request.options.memory_limit;
  limited.options.samples.memory_limit = limit > 0 ? limit : available_bytes();
  const int threads = request.options.threads;
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  FilterOutcome outcome = arena.execute([&] {
    FilterOutcome made = dispatch(filter, limited, input, progress);
    if (request.carries_data) {
      std::vector<ResultMesh*> meshes = {&made.mesh};
      for (StageRecord& stage : made.stages) meshes.push_back(&stage.mesh);
      carry_data(meshes, input.points, made.outliers.input_index, progress);
    }
    return made;
  });
  // The first stage made the layer of what was left out; the matching may find more.
  if (needs_mesh && filter != Filter::complete_matching) outcome.outliers = ResultMesh();
  if (!outcome.mesh.triangles.empty()) {
    outcome.figures["vertices"] = static_cast<Index>(outcome.mesh.position.size());
    outcome.figures["faces"] = static_cast<Index>(outcome.mesh.triangles.size());
  }
  return outcome;
}

}  // namespace shrinkwrap
