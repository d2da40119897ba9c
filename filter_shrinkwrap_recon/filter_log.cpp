#include "filter_log.h"

#include <cmath>
#include <cstdio>

namespace shrinkwrap {

std::string count_of(Index count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}
std::string count_of(Index count, const std::string& one, const std::string& several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string table_row(const std::string& stage, Index vertices, double seconds) {
  char text[128];
  std::snprintf(text, sizeof text, "%-20s %10d vertices %10.3f s", stage.c_str(),
                static_cast<int>(vertices), seconds);
  return text;
}

std::string conditioning_line(const ConditioningReport& report, double spacing) {
  return std::to_string(report.given) + " points: " + std::to_string(report.not_finite) +
         " not finite and " + std::to_string(report.duplicates) + " duplicates left out; " +
         std::to_string(report.distinct) + " samples, median spacing " +
         formatted("%.6g", spacing) +
         (report.neighbours_across_lines > 0
              ? "; they lie on lines: " + std::to_string(report.neighbours_across_lines) +
                    " neighbours each, to see across"
              : "") +
         (report.near_copies.empty()
              ? ""
              : "; " + std::to_string(report.near_copies.size()) +
                    " of them lie where others do, but for a little: of all meshes only the one "
                    "through every sample has them");
}

std::string coordinate_step_line(const ConditioningReport& report, double spacing) {
  constexpr double kFine = 0.02;  // of the spacing
  if (!(report.coordinate_step > kFine * spacing)) return "";
  return "Coordinates this far from the origin are held in steps of " +
         formatted("%.3g", report.coordinate_step) + " (single precision), " +
         formatted("%.2g", report.coordinate_step / spacing) +
         " of the median spacing, and the mesh passes through the points as they are held: " +
         advice_for_coarse_steps();
}

namespace {

std::string topology_of(const MeshReport& report) {
  std::string text =
      report.closed() ? "closed" : "open (" + count_of(report.border_loops, "border") + ")";
  if (report.manifold())
    text += " 2-manifold of genus " + std::to_string(report.genus);
  else
    text += ", NOT a 2-manifold";
  text += ", " + count_of(report.components, "component");
  if (report.components_inside_out > 0)
    text += " (" + std::to_string(report.components_inside_out) + " inside out)";
  return text;
}

std::string intersections_of(const MeshReport& report) {
  if (report.self_intersecting_faces < 0) return "";
  return "; " + count_of(report.self_intersecting_faces, "self-intersecting face");
}

}  // namespace

std::string verdict_of(const MeshReport& report) {
  std::string text = topology_of(report) + "; " + std::to_string(report.samples_matched) + " of " +
                     std::to_string(report.samples) + " samples matched";
  if (report.vertices_extra > 0)
    text +=
        ", " + count_of(report.vertices_extra, "extra vertex", "extra vertices") + " beside them";
  return text + intersections_of(report);
}

std::string verdict_on_surface(const MeshReport& report) {
  return topology_of(report) + "; " + count_of(report.vertices, "vertex", "vertices") + " for " +
         count_of(report.samples, "sample") + intersections_of(report);
}

std::string repair_line(const RepairReport& report) {
  return "Self-intersections repaired: " + count_of(report.faces_before, "face") + " met others, " +
         std::to_string(report.faces_after) + " still do, after " +
         count_of(report.flips, "edge flip") +
         (report.relocated > 0 ? ", " + count_of(report.relocated, "relocated sample") : "") +
         (report.annealed > 0
              ? ", and " + count_of(report.annealed, "patch", "patches") + " annealed"
              : "");
}

std::string folds_line(const FoldReport& report) {
  return "Folds removed: " + count_of(report.faces_before, "face") +
         " were bent back onto their neighbours, " + std::to_string(report.faces_after) +
         " still are, after " + count_of(report.flips, "edge flip") +
         (report.annealed > 0
              ? " and " + count_of(report.annealed, "patch", "patches") + " annealed"
              : "");
}

std::string relaxation_line(const RelaxationReport& report) {
  return "Self-intersections smoothed away: " + count_of(report.faces_before, "face") +
         " met others, " + std::to_string(report.faces_after) + " still do, after " +
         count_of(report.moved, "vertex", "vertices") + " moved" +
         (report.flips > 0
              ? " and " + count_of(report.flips, "flip or relocation", "flips and relocations")
              : "");
}

std::string surface_verdict(const char* what, const SurfaceMesh& mesh) {
  return kSucceeded + std::string(what) + ", " + std::to_string(mesh.vertex_count()) +
         " vertices, " + std::to_string(mesh.face_count()) + " faces, Euler characteristic " +
         std::to_string(mesh.euler_characteristic());
}

std::string detail_verdict(const char* what, const ResultMesh& mesh) {
  return kSucceeded + std::string(what) + " with the detail of its samples, " +
         std::to_string(mesh.position.size()) + " vertices, " +
         std::to_string(mesh.triangles.size()) + " faces";
}

void warn_of(const OrientationReport& report, std::vector<std::string>& warnings) {
  const Index undecided = report.undecided_components - (report.ground.isZero() ? 0 : 1);
  if (undecided > 0)
    warnings.push_back(count_of(undecided, "part") +
                       " of the cloud can be seen from either side alike, or from neither, or is "
                       "ground: which side is outside is a guess (upwards, of ground). Where it is "
                       "wrong, turn the mesh (filter \"Invert Faces Orientation\").");
  if (report.ground.isZero()) return;
  std::string front;
  for (int axis = 0; axis < 3; ++axis)  // without -0.00
    front += (axis > 0 ? ", " : "") +
             formatted("%.2f", std::round(report.ground[axis] * 100.0) / 100.0 + 0.0);
  warnings.push_back(
      "A flat open sheet was taken for ground that faces (" + front +
      ") in the coordinates of the layer, and the rest of the cloud to be seen from that side of "
      "it. Where that is its "
      "back, turn the mesh (filter \"Invert Faces Orientation\") or, if much stands on "
      "the ground, the points until it faces +z (their coordinates, by a filter, not the matrix of "
      "the layer), and run again.");
}

std::string advice_for_noise(Filter filter, bool is_robust) {
  const std::string method =
      is_robust ? "" : "Choose the method Robust, since As in the paper smooths nothing. ";
  if (filter == Filter::reconstruct)
    return method +
           "Stop at the parametric surface (StopAtParametricSurface) for a smooth one near them.";
  return method +
         "For a smooth one near them, smooth for noise in this filter and in the others that can "
         "(SmoothForNoise), and leave off after Parametric Surface.";
}

void tell_of_noise(Filter filter, const NoiseEstimate& noise, const DenoisingReport& denoising,
                   const ReconstructionOptions& options, FilterOutcome& outcome) {
  const Layers& layers = noise.layers;
  outcome.figures["noise"] = noise.median;
  outcome.log.push_back("noise of the samples: about " + formatted("%.2f", noise.median) +
                        " spacings");
  const std::string part = count_of(noise.more.samples, "sample") + " (" +
                           formatted("%.1f", 100.0 * noise.more.part) + " %)";
  if (noise.more.samples > 0)
    outcome.log.push_back("around " + part + " there is more: about " +
                          formatted("%.2f", noise.more.median) + " spacings" +
                          (noise.of_others() != noise.median
                               ? ", and " + formatted("%.2f", noise.of_others()) + " elsewhere"
                               : ""));
  if (layers.axis != kNone)
    outcome.log.push_back(
        "the samples lie in " + count_of(layers.count, "layer") + " along " +
        std::string(1, "xyz"[layers.axis]) + ", " + formatted("%.1f", layers.step) +
        " spacings apart: that coordinate seems to have been rounded to such steps, which count as "
        "noise.");
  if (denoising.moved > 0)
    outcome.log.push_back("noise smoothed: " + count_of(denoising.moved, "sample") + " moved by " +
                          formatted("%.2f", denoising.mean_displacement) +
                          " spacings in the mean, " +
                          formatted("%.2f", denoising.max_displacement) + " at most");
  const bool is_noisy = noise.of_others() > options.noise.high;
  const bool is_partly_noisy = noise.more.part > options.denoising.before_initial_mesh_part &&
                               noise.more.median > options.noise.high;
  if (!is_noisy && !is_partly_noisy) return;
  const std::string rough =
      is_noisy ? "The samples are noisy, by about " + formatted("%.2f", noise.median) +
                     " of their spacing: a mesh through every one of them is rough. "
               : part + " are noisy, by about " + formatted("%.2f", noise.more.median) +
                     " of their spacing: a mesh through every one of them is rough there. ";
  if (!options.stop_at_parametric_surface)
    outcome.warnings.push_back(rough + advice_for_noise(filter, is_robust(options)));
  else if (!is_robust(options))
    outcome.warnings.push_back(
        "The samples are noisy, and the method As in the paper smooths nothing: choose Robust for "
        "a surface that is smoothed for the noise.");
}

void tell_of_view(const OrientationReport& report, FilterOutcome& outcome) {
  if (!report.is_view) return;
  outcome.log.push_back(
      "all samples were seen from the origin of the coordinates, as their density tells, by one "
      "camera or scanner: the mesh faces it. Where that is wrong, move the points away from there "
      "(filter \"Transform: Translate, Center, set Origin\").");
}

void tell_of_sheet(const OrientationReport& report, const ReconstructionOptions& options,
                   FilterOutcome& outcome) {
  constexpr double kMostlySheet = 0.5;
  if (report.closedness >= kMostlySheet || !is_robust(options) ||
      options.complete_matching.openings != CompleteMatchingOptions::Openings::close)
    return;
  outcome.log.push_back(
      "the cloud is an open sheet, such as terrain or one view: openings can be left open, or "
      "those alone that are wider than a limit, such as its outline (Openings: Leave open, "
      "Automatic)");
}

std::string dense_parts_line(const InitialMeshReport& report) {
  return count_of(report.refined_parts, "part") +
         " with voxels of half the size, where samples are dense";
}

std::string detail_line(const InitialMeshReport& report) {
  return "voxels of " + formatted("%.2f", report.voxel_size) +
         " spacings, smaller than usual, as " + formatted("%.1f", 100.0 * report.sharp) +
         " % of the samples lie at edges, in thin parts, or where the shape turns within a few "
         "samples";
}

void warn_of(const InitialMeshReport& report, std::vector<std::string>& warnings) {
  if (report.samples_with_solid_behind < 0.999)
    warnings.push_back(formatted("%.2f", 100.0 * (1.0 - report.samples_with_solid_behind)) +
                       " % of the samples have no solid behind them: walls may be thinner than the "
                       "cloud resolves.");
  if (report.voxels_are_larger || report.spacing > 1.25)
    warnings.push_back(
        "Voxels of " + formatted("%.3g", report.voxel_size) +
        " median spacings were taken, larger than asked for: the samples are too "
        "unevenly spread for smaller ones, and close parts of the densest may be lost. Of "
        "parts far from each other, select one and reconstruct it (Selected points "
        "only), and delete points that lie far away.");
  if (report.false_handles > 0)
    warnings.push_back(count_of(report.false_handles, "handle") +
                       " cut that no samples bear out (bridges between close parts, or tunnels "
                       "through thin walls): see Cut false handles (CutFalseHandles).");
  if (report.false_mouths > 0)
    warnings.push_back(count_of(report.false_mouths, "hole") +
                       " closed that no samples bear out, in walls of cavities: see Cut false "
                       "handles (CutFalseHandles).");
  if (report.handles_refuted > 0)
    warnings.push_back(count_of(report.handles_refuted, "handle") +
                       " left out that voxels of another size, or a lower winding number, do "
                       "not show; voxels are of " +
                       formatted("%.2f", report.voxel_size) + " spacings.");
  if (report.bodies_parted > 0)
    warnings.push_back(count_of(report.bodies_parted, "body", "bodies") +
                       " more told apart by voxels of " + formatted("%.2f", report.voxel_size) +
                       " spacings, which were taken.");
  if (report.handles_cut > 0)
    warnings.push_back(count_of(report.handles_cut, "handle") +
                       " cut to keep to the greatest genus asked for.");
  if (report.dropped > 0)
    warnings.push_back(
        count_of(report.dropped, "small body or cavity", "small bodies or cavities") +
        " left out: see Smallest body (MinComponentSamples).");
}

std::string notches_filled(Index count) {
  return count_of(count, "notch", "notches") + " of their borders filled";
}

void tell_of_attempts(const Reconstruction& result, FilterOutcome& outcome) {
  const auto tell = [&](const SecondAttempt& attempt, const std::string& what) {
    if (!attempt.is_made) return;
    const MatchingFaults &first = attempt.first, &second = attempt.second;
    const auto no_samples = [](const MatchingFaults& faults) {
      return faults.extra_vertices + faults.cut_out;
    };
    const std::string across =
        first.across > 0.0 || second.across > 0.0
            ? ", " + formatted("%.2f", 100.0 * second.across) +
                  " % of the area across the planes of the samples in place of " +
                  formatted("%.2f", 100.0 * first.across) + " %"
            : "";
    std::string faults;
    if (first.meeting > 0)
      faults = count_of(first.meeting, "face") + " that met others until annealed, or still do";
    if (no_samples(first) > 0)
      faults +=
          (faults.empty() ? "" : " and ") +
          count_of(no_samples(first), "vertex that is no sample", "vertices that are no samples") +
          " (some may have gone, with cuts)";
    outcome.log.push_back("Matched again because of " + faults + ", " + what + ": " +
                          (attempt.is_finished
                               ? count_of(second.meeting, "face") + " and " +
                                     count_of(no_samples(second), "vertex", "vertices") + " then" +
                                     across + ", and " + (attempt.is_taken ? "taken" : "not taken")
                               : "no mesh came of it"));
  };
  tell(result.backs, "with the backs of sheets, where no sample is, as openings");
  tell(result.smoothing, "with a surface smoothed for the noise, of quadrics in place of planes");
}

void tell_of_detail(const Reconstruction& result, FilterOutcome& outcome) {
  const DetailReport& detail = result.detail;
  const auto percent = [](double part) { return formatted("%.1f", 100.0 * part) + " %"; };
  if (detail.far > ReconstructionOptions().most_samples_far)
    outcome.warnings.push_back(
        percent(detail.far) +
        " of the samples are farther from the parametric surface than their spacing and noise: the "
        "mesh there is a guess. Mostly parts are thinner, or nearer to each other, than two or "
        "three spacings, and more samples would help; or small bodies or stray points have no "
        "surface of their own.");
  if (detail.surfaces < 2) return;
  const std::string at_first = percent(detail.far_at_first) +
                               " of the samples were farther from the parametric surface than "
                               "their spacing";
  outcome.log.push_back(
      detail.far < detail.far_at_first
          ? at_first + ": made again of " + std::to_string(result.control_mesh.target_vertices) +
                " control vertices (ControlVertices), it leaves " + percent(detail.far)
          : at_first + ", and finer control meshes did not help");
}

void tell_of(const SurfaceDetail& detail, FilterOutcome& outcome) {
  if (!detail.is_kept) return;
  outcome.log.push_back("a fifth of the samples are farther from the parametric surface than " +
                        formatted("%.3f", detail.upper_fifth) + " spacings, a twentieth than " +
                        formatted("%.3f", detail.upper_twentieth) +
                        ", more than noise explains: the vertices are the samples, moved onto it "
                        "but for detail, by " +
                        formatted("%.2f", detail.mean_displacement) + " spacings in the mean, " +
                        formatted("%.2f", detail.max_displacement) + " at most");
}

std::string openings_line(const OpeningsReport& report) {
  std::string line = "Openings: ";
  if (report.spanned > 0)
    line += std::to_string(report.spanned) + " spanned" +
            (report.stretched > 0 ? ", " + std::to_string(report.stretched) +
                                        " of them by membranes stretched between their rims"
                                  : "") +
            " (longest edge " + formatted("%.1f", report.longest_edge) +
            " spacings; face quality above 0)";
  if (report.left_open > 0)
    line += (report.spanned > 0 ? ", " : "") + std::to_string(report.left_open) + " left open";
  if (report.notches_filled > 0) line += " (" + notches_filled(report.notches_filled) + ")";
  return line;
}

void warn_of(const CompleteMatchingReport& report, std::vector<std::string>& warnings) {
  if (report.max_foot_distance > 2.0)
    warnings.push_back("A sample lies " + formatted("%.1f", report.max_foot_distance) +
                       " spacings from the parametric surface: look at the mesh there.");
  if (report.extra_vertices > 0)
    warnings.push_back(
        count_of(report.extra_vertices, "vertex", "vertices") +
        " without a sample could not be removed without harm, as happens where large "
        "openings are spanned.");
}

void warn_of_openings(const ReconstructionOptions& options, std::vector<std::string>& warnings) {
  if (options.complete_matching.method == CompleteMatchingOptions::Method::snap_and_insert &&
      options.complete_matching.openings != CompleteMatchingOptions::Openings::close)
    warnings.push_back(
        "\"As in the paper\" closes every opening, whatever is chosen for openings: only "
        "the robust method can leave them open.");
}

void warn_of_subdivision(const ParametricSurfaceReport& report, Index samples,
                         std::vector<std::string>& warnings) {
  if (report.subdivisions == 0)
    warnings.push_back("The mesh has " + std::to_string(report.vertices) + " vertices for " +
                       count_of(samples, "sample") +
                       " already: it was neither subdivided nor fitted, as suits where the whole "
                       "method says that it was made of so many. Otherwise choose a layer that "
                       "Control Mesh made, with fewer vertices.");
}

void warn_of_intersections(Index faces_left, std::vector<std::string>& warnings) {
  if (faces_left > 0)
    warnings.push_back(count_of(faces_left, "face") +
                       " could not be parted from others that they meet: they are selected.");
}

void tell_of(const OutlierReport& report, FilterOutcome& outcome) {
  const Index count = static_cast<Index>(report.input_index.size());
  outcome.figures["outliers"] = count;
  if (count > 0)
    outcome.warnings.push_back(
        count_of(count, "outlier") +
        " left out of the surface: points that lie apart from the rest. Switch Exclude outliers "
        "(ExcludeOutliers) off to keep them.");
  const Index left_in = report.suspected - count - report.on_surface;
  if (left_in > 0)
    outcome.warnings.push_back(
        "what seems stray is left in (" + count_of(left_in, "sample") +
        "): it is too much, or the others lie in a plane. Remove by hand what is no part of the "
        "surface.");
  if (!report.off_surface.empty())
    outcome.log.push_back(count_of(static_cast<Index>(report.off_surface.size()), "outlier") +
                          " told by the surface through the others: alone, and off it.");
  if (report.on_surface > 0)
    outcome.log.push_back(count_of(report.on_surface, "sample") +
                          " apart from the rest lie on the surface that passes through it: no "
                          "outliers.");
}

std::string but_outliers(const OutlierReport& report) {
  if (report.input_index.empty()) return "";
  return "; every sample but the " +
         count_of(static_cast<Index>(report.input_index.size()), "outlier") + " left out";
}

}  // namespace shrinkwrap
