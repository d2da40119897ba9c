#include "filter_parameters.h"

#include <utility>

#include "parameter_names.h"

namespace shrinkwrap {
namespace {

using Kind = Parameter::Kind;

constexpr double kMostElements = 1e9;

Parameter boolean(const char* name, const char* label, bool value, const char* tooltip) {
  Parameter parameter;
  parameter.name = name;
  parameter.label = label;
  parameter.tooltip = tooltip;
  parameter.default_value = value ? 1.0 : 0.0;
  return parameter;
}

Parameter number(Kind kind, const char* name, const char* label, double value, double minimum,
                 double maximum, const char* tooltip) {
  Parameter parameter = boolean(name, label, false, tooltip);
  parameter.kind = kind;
  parameter.default_value = value;
  parameter.minimum = minimum;
  parameter.maximum = maximum;
  return parameter;
}

Parameter choice(const char* name, const char* label, std::vector<std::string> choices,
                 const char* tooltip) {
  Parameter parameter = number(Kind::choice, name, label, 0.0, 0.0,
                               static_cast<double>(choices.size()) - 1.0, tooltip);
  parameter.choices = std::move(choices);
  return parameter;
}

Parameter layer(const char* name, const char* label, const char* tooltip) {
  return number(Kind::layer, name, label, 0.0, 0.0, kMostElements, tooltip);
}

Parameter advanced(Parameter parameter) {
  parameter.advanced = true;
  return parameter;
}

// --- parameters that several filters share ---

Parameter samples_layer() {
  return layer(kSamplesLayer, "Samples",
               "The layer whose points are the samples: the same for all stages of one "
               "reconstruction. It is not changed.");
}

Parameter mesh_layer(const char* tooltip) {
  return layer(kMeshLayer, "Mesh", tooltip);
}

Parameter method() {
  return choice(kMethod, "Method", {"Robust (default)", "As in the paper"},
                "<b>Robust</b> starts from the solid that the samples enclose, so that holes "
                "through the object, deep "
                "cavities and several bodies come out right.<br><b>As in the paper</b> shrinks the "
                "bounding box onto the "
                "samples and uses the paper's own steps and constants: right only for one body "
                "without holes through it "
                "(genus 0) and without deep cavities.");
}

// The filter of a stage takes the steps that the method has there.
Parameter method_of_all_stages() {
  Parameter parameter = method();
  parameter.tooltip += " Choose the same in the filters of all stages.";
  return parameter;
}

Parameter selected_only() {
  return boolean(kSelectedOnly, "Selected points only", false,
                 "Use only the selected points of the layer as samples.");
}

Parameter exclude_outliers() {
  return advanced(
      boolean(kExcludeOutliers, "Exclude outliers", true,
              "Leave stray points out of the surface: points and small clumps of points (fewer "
              "than 30, or more if they are far sparser than the rest and in no surface) that "
              "lie apart from the rest, far from it by the spacing there, and points that jut "
              "out of it, or stand alone off the surface made of it. The log says how many; the "
              "whole method and Initial Mesh make a layer of them, and Complete Matching of "
              "those that it finds, so that none is lost. Off: every point becomes a vertex, "
              "stray or not."));
}

Parameter excuse_outliers() {
  Parameter parameter = exclude_outliers();
  parameter.tooltip =
      "Do not count stray points as missing where the mesh leaves them out: points and small "
      "clumps of points (fewer than 30, or more if they are far sparser than the rest and in "
      "no surface) that lie apart from the rest, far from it by the spacing there, and points "
      "that jut out of it, or stand alone off the mesh. The log says how many. Off: every "
      "distinct point must be a vertex.";
  return parameter;
}

// Of the filters of the stages: so that their chain ends in what the whole method gives.
Parameter smooth_for_noise() {
  return boolean(
      kSmoothForNoise, "Smooth the surface for noise", false,
      "Robust method: move the points onto the quadrics that those around them suggest, by as much "
      "as they are noisy, and fit the surface to these, as the whole method does where it stops at "
      "the parametric surface, and where its log says so. Choose the same in the filters "
      "Initial Mesh, Parametric Surface and Complete Matching; but to stop at the surface of "
      "points "
      "whose noise is below 0.04 spacings, with more around no more than a tenth of them (the log "
      "tells both), leave it off in Initial Mesh.");
}

Parameter backs_are_openings() {
  return advanced(boolean(
      kBacksAreOpenings, "Backs of sheets are openings", false,
      "Robust method: take the back of a sheet, such as a patch of terrain or one view of "
      "a depth camera, for an opening even where it is near the points, as the whole method "
      "does where its log says so."));
}

Parameter choice_of_openings(const char* tooltip) {
  return choice(kOpenings, "Openings in the scan", {"Close", "Leave open", "Automatic"}, tooltip);
}

Parameter openings() {
  return choice_of_openings(
      "Robust method: what becomes of places without samples that are wider than about "
      "eight sample spacings.<br><b>Close</b> spans them with faces between the points around them "
      "(where the run stops at the parametric surface, with a membrane stretched between their "
      "rims), and the mesh is watertight. Their face quality tells these faces from others: "
      "the longest edge in sample spacings, 0 elsewhere.<br><b>Leave open</b> takes "
      "these faces away, and the mesh has a border there, to which one face joins a point in the "
      "middle of the opening.<br><b>Automatic</b> spans "
      "openings up to a width, see below, and leaves wider ones open: of terrain and of "
      "scenes, shadows are closed and the outline is not.");
}

Parameter openings_of_matching() {
  return choice_of_openings(
      "Robust method: what Edge Optimisation is to do with places without samples; choose the same "
      "there. Here the mesh is closed in any case: with <b>Leave open</b> by the faces that the "
      "surface has there, otherwise by faces between the points around. Their face quality tells "
      "them from others.");
}

Parameter widest_opening() {
  return advanced(number(
      Kind::real, kWidestOpening, "Widest opening to span (spacings)", 30.0, 4.0, kMostElements,
      "Robust method, for the automatic choice: openings are spanned if no edge across them "
      "has to be longer (where the run stops at the parametric surface: if no point of the "
      "membrane is farther than half of it from the samples). Raised: wider openings are closed, "
      "by larger flat "
      "faces. Lowered: more of them get a border. Unit: median sample spacing; "
      "range 4 and up; 10 to 100 are useful."));
}

Parameter maximum_genus() {
  return advanced(number(Kind::integer, kMaximumGenus, "Greatest genus (-1: any)", -1, -1,
                         kMostElements,
                         "Robust method: how many handles (holes through the object, like that of "
                         "a cup's ear) the mesh may have. -1: as many as the samples show. 0 "
                         "suits busts, teeth and bones: handles beyond are cut where they are "
                         "thinnest. Unit: handles; -1 and up."));
}

Parameter cut_false_handles() {
  return advanced(boolean(
      kCutFalseHandles, "Cut false handles", true,
      "Robust method: cut handles that no points bear out, which are bridges between close parts "
      "and tunnels through thin walls, and close such tunnels into cavities; the log says how "
      "many. Off: they stay. Of use for objects "
      "whose own limbs, or holes through them, are hardly wider than two sample spacings."));
}

Parameter threads() {
  return advanced(number(Kind::integer, kThreads, "Threads (0: all)", 0, 0, 1024,
                         "Number of threads; 0: as many as the machine has. The result is the same "
                         "for any number: fewer "
                         "only leave more of the machine to other work. Range 0 to 1024."));
}

Parameter neighbours() {
  return advanced(number(Kind::integer, kNeighbours, "Neighbours (samples)", 16, 6, 64,
                         "Nearest samples from which spacing and normal of a sample are taken. "
                         "Raised: steadier on noisy clouds, blurs thin walls and sharp edges. "
                         "Lowered: finer detail, less steady (12 already loses thin walls). Scan "
                         "lines far apart are given more by themselves. Unit: samples; range 6 to "
                         "64."));
}

Parameter repair_intersections() {
  return advanced(boolean(kRepairIntersections, "Repair self-intersections", true,
                          "Look for faces that cut or touch others, exactly, and flip edges around "
                          "them until none is left; those that cannot be parted are selected. "
                          "Faces that are bent back onto their neighbours are unfolded too. Off: "
                          "faster, for trials. Faces that meet are counted and not selected, and "
                          "more vertices that are no samples may stay in openings."));
}

// What else the whole method does only where it knows which faces meet.
Parameter repair_intersections_of_all_stages() {
  Parameter parameter = repair_intersections();
  parameter.tooltip +=
      " Nothing is matched a second time, and where the run stops at the parametric surface no "
      "edges are kept.";
  return parameter;
}

// Of a surface that the samples are still to be matched to, and of one that is the end.
Parameter repair_surface_intersections() {
  Parameter parameter = repair_intersections();
  parameter.tooltip =
      "With Smooth the surface for noise, which makes this the last stage: look for faces that cut "
      "or touch others, exactly, and smooth the surface around them until none is left; those that "
      "cannot be parted are selected. Without it nothing is looked for here: Edge Optimisation "
      "does it. Off: a little faster; none is selected, and edges that many samples show are not "
      "kept.";
  return parameter;
}

Parameter count_intersections() {
  return advanced(boolean(kCountIntersections, "Count self-intersections", true,
                          "Count the faces that cut or touch each other, exactly, for the report. "
                          "Off: a little faster."));
}

// --- advanced parameters of one stage each ---

std::vector<Parameter> solid_parameters() {
  return {
      neighbours(),
      advanced(
          number(Kind::real, kVoxelSize, "Voxel size (spacings)", 1.75, 0.75, 4.0,
                 "Robust method: edge of the voxels of the first solid; of all of them 0.7 "
                 "times as much if samples are few for the shape, and less where bodies come "
                 "close to each other, more in large clouds of very uneven density, as the log "
                 "says then. Lowered (1.0): parts that come "
                 "close to each other are kept apart, at the price of false holes in sparse "
                 "places. Raised (2 to 3): closes gaps of uneven clouds, may glue close parts "
                 "together. Unit: median sample spacing; range 0.75 to 4.")),
      advanced(number(Kind::real, kLevel, "Inside level (0 to 1)", 0.4, 0.05, 0.95,
                      "Robust method: what counts as inside, 0 far outside to 1 deep inside. "
                      "Lowered (0.3): openings are "
                      "spanned farther out, good for half scans. Raised (0.5): tighter, may tear "
                      "false handles. Open sheets (terrain, one view of an object) have 0.25 at "
                      "most. No unit; "
                      "range 0.05 to 0.95.")),
      advanced(
          number(Kind::integer, kMinComponent, "Smallest body (samples)", 30, 4, kMostElements,
                 "Robust method: bodies and cavities supported by fewer samples than this get "
                 "no surface of their own. In small clouds a hundredth of all samples is enough, "
                 "but at least 4, unless more than 30 is set here; and where all bodies are small, "
                 "those of a quarter of the typical number get one. "
                 "Raised: clumps of stray points do not become bodies. Lowered: small real "
                 "parts are kept. Unit: "
                 "samples; range 4 and up.")),
  };
}

std::vector<Parameter> shrink_parameters() {
  return {
      advanced(number(Kind::integer, kShrinkIterations, "Shrink iterations", 4, 0, 200,
                      "Robust method: steps in which the first mesh moves onto the samples. "
                      "Raised: closer and smoother, slower. Lowered: faster, and the edges of the "
                      "voxels stay visible. Unit: steps; range 0 to 200, 3 to 10 are useful.")),
      advanced(number(Kind::integer, kBoxLevels, "Box subdivisions (-1: automatic)", -1, -1, 10,
                      "As in the paper: how often every face of the bounding box is split into "
                      "four; -1: as often as leaves at least four samples for a vertex. Raised: "
                      "finer, four times the vertices for each one more. Lowered: coarser, detail "
                      "is left to the later stages. Range -1 to 10.")),
      advanced(number(Kind::real, kProjection, "Projection step (0 to 1)", 0.85, 0.05, 1.0,
                      "As in the paper (eq. 5): the part of the way to its nearest sample that a "
                      "vertex goes in one step. Raised towards 1: faster, vertices crowd at "
                      "samples. Lowered: needs more steps, vertices stay evenly spread. No unit; "
                      "range 0.05 to 1.")),
      advanced(number(Kind::real, kBoxRelaxation, "Relaxation step (0 to 0.5)", 0.2, 0.0, 0.5,
                      "As in the paper (eq. 8): how much vertices spread evenly along the surface "
                      "in one step. Raised: more even, less close to the samples. Lowered: closer, "
                      "uneven. No unit; range 0 to 0.5.")),
  };
}

Parameter control_vertices() {
  return advanced(number(
      Kind::integer, kControlVertices, "Control vertices (0: automatic)", 0, 0, kMostElements,
      "Vertices of the control mesh; 0: the number from which two subdivisions come nearest to the "
      "number of samples, and more where the whole method finds that detail would be lost (its log "
      "says how many). Raised: follows finer detail, and noise. Lowered: smoother surface "
      "before the "
      "matching. Unit: vertices; 0, or 4 and up."));
}

Parameter fit_iterations() {
  return advanced(
      number(Kind::integer, kFitIterations, "Fitting iterations", 5, 0, 200,
             "Steps in which the surface moves onto the samples after each "
             "subdivision (half as many after the last). Raised: closer, slower; 4 to "
             "8 are useful. Lowered: smoother, farther from the samples. Unit: steps; range 0 "
             "to 200."));
}

Parameter attraction() {
  return advanced(
      number(Kind::real, kAttraction, "Attraction (0: automatic)", 0.0, 0.0, 1.0,
             "Lambda of eq. 14: the part of the way to the samples that a vertex goes "
             "in one step; 0: what the method has (Robust 0.7, As in the paper 0.85). "
             "Raised: closer and faster, less even. Lowered: smoother, farther from the "
             "samples. No unit; range 0 to 1."));
}

Parameter crease_angle() {
  return advanced(number(
      Kind::real, kCreaseAngle, "Crease angle (degrees; -1: automatic)", -1.0, -1.0, 180.0,
      "Edges are chosen for the shape of their triangles (Delaunay) where no other edges bend by "
      "more than this then, after the method's own choice, which follows the bends of the surface; "
      "edges that bend by more, and where angles would be below 25 degrees, only if they bend by "
      "no more than 1.3 times as much then. 0: nowhere. Raised: better shaped triangles, "
      "fewer edges kept sharp. -1: what the method has (Robust 50, As in the paper 0). Can be "
      "applied to a finished mesh that is closed. Unit: degrees; -1, or 0 to 180."));
}

Parameter least_gap() {
  return advanced(number(
      Kind::real, kLeastGap, "Least gap between diagonals (-1: automatic)", -1.0, -1.0, 1.0,
      "Where the two diagonals of a pair of faces pass each other at a distance of at least this, "
      "and of at least five times the median of all, or at one of the 5 % largest distances (not "
      "if the median is 0.08 or more), the one is taken that is clearly nearer to the surface, as "
      "the planes of the faces around tell it. 0: wherever they differ, which is nearer to a "
      "smooth surface, with narrower triangles. "
      "Raised: only where a wrong choice would show. 1: nowhere. -1: what the method has "
      "(Robust 0.03, As in the paper 1). Can be applied to a finished mesh that is closed. Unit: "
      "mean length of the diagonals; -1, or 0 to 1."));
}

void append(std::vector<Parameter>& list, const std::vector<Parameter>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

// Few enough that the dialog of 2020.09, which shows all of them, fits a laptop's screen: what only
// somebody who studies one stage would change is a parameter of that stage's filter.
std::vector<Parameter> reconstruct_parameters() {
  std::vector<Parameter> list = {
      method(),
      boolean(kStopAtSurface, "Stop at the parametric surface", false,
              "Return the smooth surface near the samples in place of the mesh through every "
              "sample. The better choice when the points are noisy, by more than a fifth of "
              "their spacing as the log tells: the method Robust smooths the noise. Where "
              "the surface would lose edges that many samples show, and no opening is "
              "spanned, its vertices are the samples, moved onto it but for such detail."),
      openings(),
      selected_only(),
      exclude_outliers(),
      advanced(boolean(kKeepStages, "Keep every stage as a layer", false,
                       "Also add the initial mesh (As in the paper: the bounding box before "
                       "it), the control mesh, the parametric surface (unless it is the result) "
                       "and, unless the run stops there, the complete matching before its edges "
                       "are optimised, each as a layer, in this order. In the complete matching "
                       "and in the result through "
                       "every sample the vertex quality is the distance from the parametric "
                       "surface (unless the points bring a quality of their own), and the face "
                       "quality of faces that span an opening their longest edge in sample "
                       "spacings: see them with \"Colorize by vertex Quality\" and \"Colorize by "
                       "face Quality\". Takes about twice the memory.")),
      widest_opening(),
      maximum_genus(),
      cut_false_handles(),
  };
  append(list, solid_parameters());
  list.push_back(repair_intersections_of_all_stages());
  return list;
}

}  // namespace

const char* filter_name(Filter filter) {
  switch (filter) {
    case Filter::reconstruct:
      return "Surface Reconstruction: Shrink Wrap";
    case Filter::initial_mesh:
      return "Shrink Wrap: Initial Mesh";
    case Filter::control_mesh:
      return "Shrink Wrap: Control Mesh";
    case Filter::parametric_surface:
      return "Shrink Wrap: Parametric Surface";
    case Filter::complete_matching:
      return "Shrink Wrap: Complete Matching";
    case Filter::edge_optimisation:
      return "Shrink Wrap: Edge Optimisation";
    case Filter::matching_report:
      return "Shrink Wrap: Matching Report";
    case Filter::distance_to_samples:
      return "Shrink Wrap: Distance to Samples";
  }
  return "";
}

const char* scripting_name(Filter filter) {
  switch (filter) {
    case Filter::reconstruct:
      return "generate_surface_reconstruction_shrink_wrap";
    case Filter::initial_mesh:
      return "generate_shrink_wrap_initial_mesh";
    case Filter::control_mesh:
      return "generate_shrink_wrap_control_mesh";
    case Filter::parametric_surface:
      return "generate_shrink_wrap_parametric_surface";
    case Filter::complete_matching:
      return "generate_shrink_wrap_complete_matching";
    case Filter::edge_optimisation:
      return "generate_shrink_wrap_edge_optimisation";
    case Filter::matching_report:
      return "get_shrink_wrap_matching_report";
    case Filter::distance_to_samples:
      return "compute_scalar_by_distance_to_samples_per_vertex";
  }
  return "";
}

std::vector<Parameter> parameters_of(Filter filter) {
  std::vector<Parameter> list;
  switch (filter) {
    case Filter::reconstruct:
      list = reconstruct_parameters();
      break;
    case Filter::initial_mesh:
      list = {samples_layer(),    selected_only(), exclude_outliers(), method_of_all_stages(),
              smooth_for_noise(), maximum_genus(), cut_false_handles()};
      append(list, solid_parameters());
      append(list, shrink_parameters());
      break;
    case Filter::control_mesh:
      list = {samples_layer(),
              mesh_layer("The initial mesh: a closed 2-manifold. It is not changed."),
              selected_only(),
              exclude_outliers(),
              method_of_all_stages(),
              neighbours(),
              control_vertices()};
      break;
    case Filter::parametric_surface:
      list = {samples_layer(),
              mesh_layer("The control mesh: a closed 2-manifold. It is not changed."),
              selected_only(),
              exclude_outliers(),
              method_of_all_stages(),
              smooth_for_noise(),
              neighbours(),
              fit_iterations(),
              attraction(),
              repair_surface_intersections()};
      break;
    case Filter::complete_matching:
      list = {samples_layer(),
              mesh_layer("The parametric surface: a closed 2-manifold. It is not changed."),
              selected_only(),
              exclude_outliers(),
              method_of_all_stages(),
              smooth_for_noise(),
              backs_are_openings(),
              openings_of_matching(),
              neighbours()};
      break;
    case Filter::edge_optimisation:
      list = {samples_layer(),
              mesh_layer("The complete matching: a closed 2-manifold. It is not changed."),
              selected_only(),
              exclude_outliers(),
              method_of_all_stages(),
              openings(),
              widest_opening(),
              neighbours(),
              crease_angle(),
              least_gap(),
              repair_intersections()};
      break;
    case Filter::matching_report:
      list = {samples_layer(),
              mesh_layer("The mesh to be measured. It is not changed."),
              selected_only(),
              excuse_outliers(),
              boolean(kFailIfIncomplete, "Fail if incomplete", false,
                      "Treat a mesh that is not closed, not 2-manifold or not matched one to one "
                      "as an error, so that a script stops there."),
              neighbours(),
              count_intersections()};
      break;
    case Filter::distance_to_samples:
      list = {samples_layer(), mesh_layer("The layer whose vertex quality becomes the distance."),
              selected_only()};
      break;
  }
  list.push_back(threads());
  return list;
}

ParameterValues default_values(Filter filter) {
  ParameterValues values;
  for (const Parameter& parameter : parameters_of(filter))
    if (parameter.kind != Kind::layer) values[parameter.name] = parameter.default_value;
  return values;
}

}  // namespace shrinkwrap
