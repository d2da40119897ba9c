#include "filter_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/memory_estimate.h"
#include "filter_outcomes.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

FilterOutcome run_chain(const std::vector<Vec3>& points, const ParameterValues& changed) {
  FilterInput input;
  input.points = points;
  FilterOutcome outcome = run(Filter::initial_mesh, input, changed);
  for (const Filter filter : {Filter::control_mesh, Filter::parametric_surface,
                              Filter::complete_matching, Filter::edge_optimisation})
    outcome = run(filter, through_layer(points, outcome), changed);
  return outcome;
}

void expect_same_bytes(const ResultMesh& a, const ResultMesh& b) {
  ASSERT_EQ(a.position.size(), b.position.size());
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  const std::vector<Vec3> p = in_single_precision(a.position), q = in_single_precision(b.position);
  EXPECT_EQ(0, std::memcmp(p.data(), q.data(), p.size() * sizeof(Vec3)));
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.input_index, b.input_index);
}

struct ChainCase {
  std::string name;
  ShapeKind kind;
  ParameterValues changed;
};

class Chain : public ::testing::TestWithParam<ChainCase> {};

TEST_P(Chain, StageByStageGivesTheBytesOfTheOneShot) {
  std::vector<Vec3> points = in_single_precision(sample_shape(GetParam().kind, 2500, 3));
  for (Vec3& p : points) p = rounded_to_single(100.0 * p + Vec3(1234.5, -77.0, 0.3));
  const Vec3 centre(1234.5, -77.0, 0.3);
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1)})  // stray points
    points.push_back(rounded_to_single(centre + 190.0 * direction));
  points.push_back(points[7]);                              // a duplicate
  points.insert(points.begin(), Vec3(std::nan(""), 0, 0));  // and a point that is none
  FilterInput input;
  input.points = points;
  const FilterOutcome one_shot = run(Filter::reconstruct, input, GetParam().changed);
  const FilterOutcome chain = run_chain(points, GetParam().changed);
  expect_same_bytes(one_shot.mesh, chain.mesh);
  EXPECT_EQ(one_shot.outliers.position.size(), GetParam().changed.count("ExcludeOutliers") ? 0 : 3);

  const FilterOutcome report =
      run(Filter::matching_report, through_layer(points, one_shot), GetParam().changed);
  EXPECT_EQ(std::get<Index>(report.figures.at("samples_missing")), 0);
  EXPECT_EQ(std::get<Index>(report.figures.at("samples")),
            static_cast<double>(2503 - one_shot.outliers.position.size()));
}

INSTANTIATE_TEST_SUITE_P(
    FilterRuns, Chain,
    ::testing::Values(ChainCase{"closed", ShapeKind::torus, {}},
                      ChainCase{"opening_closed", ShapeKind::hemisphere, {}},
                      ChainCase{"opening_left", ShapeKind::hemisphere, {{"Openings", 1}}},
                      ChainCase{"opening_automatic",
                                ShapeKind::hemisphere,
                                {{"Openings", 2}, {"WidestOpening", 10}}},
                      ChainCase{"more_neighbours", ShapeKind::blob, {{"Neighbours", 24}}},
                      ChainCase{"more_neighbours_of_an_opening",
                                ShapeKind::hemisphere,
                                {{"Neighbours", 24}, {"Openings", 1}}},
                      ChainCase{"as_in_the_paper", ShapeKind::sphere, {{"Method", 1}}},
                      ChainCase{"with_outliers", ShapeKind::blob, {{"ExcludeOutliers", 0}}}),
    [](const auto& test) { return test.param.name; });

TEST(FilterRuns, ChainOfAFinerControlMeshGivesTheBytesOfTheOneShot) {
  for (const bool is_of_all_samples : {false, true}) {
    SCOPED_TRACE(is_of_all_samples);
    const double finer = is_of_all_samples ? 12.0 : 9.0;
    FilterInput input;
    input.points = in_single_precision(sample_spiked_ball(300, finer));
    const FilterOutcome one_shot = run(Filter::reconstruct, input);
    // The log tells with which control mesh.
    std::string vertices;
    for (const std::string& line : one_shot.log) {
      const std::string before = "made again of ";
      const std::size_t at = line.find(before);
      if (at != std::string::npos)
        vertices =
            line.substr(at + before.size(), line.find(" control vertices") - at - before.size());
    }
    ASSERT_FALSE(vertices.empty());
    EXPECT_EQ(std::stod(vertices) > 0.5 * input.points.size(), is_of_all_samples) << vertices;
    expect_same_bytes(one_shot.mesh,
                      run_chain(input.points, {{"ControlVertices", std::stod(vertices)}}).mesh);
  }
}

// Vertices that are no samples go only once the faces around openings are parted.
TEST(FilterRuns, ChainOverScanLinesGivesTheBytesOfTheOneShot) {
  FilterInput input;
  input.points = in_single_precision(sample_sphere_on_scan_lines(2000, 1));
  const FilterOutcome one_shot = run(Filter::reconstruct, input);
  expect_same_bytes(one_shot.mesh, run_chain(input.points, {}).mesh);
  EXPECT_EQ(one_shot.mesh.position.size(), input.points.size());
}

TEST(FilterRuns, ChainOverNearCopiesGivesTheBytesOfTheOneShot) {
  const std::vector<Vec3> alone = sample_shape_blue_noise(ShapeKind::torus, 1500, 1);
  std::vector<Vec3> points = alone;
  Random random(2);
  for (const Vec3& p : alone) points.push_back(p + 1e-4 * random.in_cube());
  FilterInput input;
  input.points = in_single_precision(points);
  const FilterOutcome one_shot = run(Filter::reconstruct, input);
  EXPECT_TRUE(is_told(one_shot, "3000 samples"));
  EXPECT_TRUE(is_told(one_shot, "; 1500 of them lie where others do, but for a little"));
  expect_same_bytes(one_shot.mesh, run_chain(input.points, {}).mesh);
  EXPECT_EQ(one_shot.mesh.position.size(), input.points.size());

  // A finished mesh has them already.
  const FilterInput finished = through_layer(input.points, one_shot);
  const FilterOutcome again = run(Filter::edge_optimisation, finished);
  EXPECT_EQ(std::get<Index>(again.figures.at("samples_matched")), 3000);
  EXPECT_EQ(std::get<Index>(again.figures.at("extra_vertices")), 0);
}

TEST(FilterRuns, ChainToTheSurfaceOfANoisyCloudGivesTheBytesOfTheOneShot) {
  SampleDefects defects;
  defects.noise = 0.6;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 2500, 3, defects));
  const FilterOutcome one_shot = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  const ParameterValues stop = {{"SmoothForNoise", 1}};
  FilterOutcome chain = run(Filter::initial_mesh, input, stop);
  chain = run(Filter::control_mesh, through_layer(input.points, chain));
  const FilterInput control = through_layer(input.points, chain);
  expect_same_bytes(one_shot.mesh, run(Filter::parametric_surface, control, stop).mesh);
  EXPECT_NE(one_shot.mesh.position, run(Filter::parametric_surface, control).mesh.position);
}

// The initial mesh is made of the samples where they are.
TEST(FilterRuns, ChainToTheSurfaceOfACleanCloudGivesTheBytesOfTheOneShot) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::box, 2500, 3));
  const FilterOutcome one_shot = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  const FilterOutcome initial = run(Filter::initial_mesh, input);
  const FilterOutcome control = run(Filter::control_mesh, through_layer(input.points, initial));
  expect_same_bytes(
      one_shot.mesh,
      run(Filter::parametric_surface, through_layer(input.points, control), {{"SmoothForNoise", 1}})
          .mesh);
  const FilterOutcome smoothed = run(Filter::initial_mesh, input, {{"SmoothForNoise", 1}});
  EXPECT_NE(smoothed.mesh.position, initial.mesh.position);
}

// A fifth of the samples is noisy, or a twelfth, the others are not.
TEST(FilterRuns, ChainToTheSurfaceOfAPartlyNoisyCloudGivesTheBytesOfTheOneShot) {
  for (const double from : {0.4, 0.7}) {
    SCOPED_TRACE(from);
    Random random(4);
    FilterInput input;
    input.points = sample_shape(ShapeKind::blob, 4000, 3);
    for (Vec3& p : input.points)
      if (p.x() > from) p += 0.08 * random.in_cube();
    input.points = in_single_precision(std::move(input.points));
    const ParameterValues stop = {{"StopAtParametricSurface", 1}}, smooth = {{"SmoothForNoise", 1}};
    const FilterOutcome one_shot = run(Filter::reconstruct, input, stop);
    EXPECT_TRUE(is_told(one_shot, from < 0.5 ? " samples (18." : " samples (8."));
    const FilterOutcome initial =
        run(Filter::initial_mesh, input, from < 0.5 ? smooth : ParameterValues());
    const FilterInput control = through_layer(
        input.points, run(Filter::control_mesh, through_layer(input.points, initial)));
    expect_same_bytes(one_shot.mesh, run(Filter::parametric_surface, control, smooth).mesh);
  }
}

TEST(FilterRuns, ChainThatFillsNotchesGivesTheBytesOfTheOneShot) {
  SampleDefects defects;
  defects.noise = 0.4;
  for (const unsigned seed : {1u, 5u}) {
    FilterInput input;
    input.points = in_single_precision(sample_shape(ShapeKind::hemisphere, 1500, seed, defects));
    const ParameterValues open = {{"Openings", 1}};
    expect_same_bytes(run(Filter::reconstruct, input, open).mesh,
                      run_chain(input.points, open).mesh);
  }
}

// The matching makes them samples again, and the stages after it find them among the vertices.
// Samples in the middle of a wide opening, which are joined to its border one to another.
TEST(FilterRuns, ChainThatJoinsIsolatedSamplesGivesTheBytesOfTheOneShot) {
  FilterInput input;
  Random random(5);
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, 3000, 5))
    if (p.z() < 0.3 || random.uniform() < 0.02) input.points.push_back(p);
  input.points = in_single_precision(input.points);
  for (const double openings : {1.0, 2.0}) {
    SCOPED_TRACE(openings);
    const ParameterValues changed = {
        {"Openings", openings}, {"WidestOpening", 8}, {"ExcludeOutliers", 0}};
    const FilterOutcome one_shot = run(Filter::reconstruct, input, changed);
    EXPECT_GE(std::get<Index>(one_shot.figures.at("border_loops")), 1);
    EXPECT_EQ(std::get<Index>(one_shot.figures.at("extra_vertices")), 0);
    expect_same_bytes(one_shot.mesh, run_chain(input.points, changed).mesh);
  }
}

TEST(FilterRuns, ChainThatKeepsOutliersGivesTheBytesOfTheOneShot) {
  const Vec3 stray(0.5, 0.5, 1.25);
  FilterInput input;
  input.points = cube_with_gaps({{0.5, 0.125, 0.0}});
  input.points.push_back(stray);
  const FilterOutcome one_shot = run(Filter::reconstruct, input);
  const Index count = static_cast<Index>(input.points.size()) - 1;
  EXPECT_EQ(one_shot.mesh.position.size(), static_cast<std::size_t>(count));
  EXPECT_TRUE(is_told(one_shot, "1 sample apart from the rest"));
  ASSERT_EQ(one_shot.outliers.position.size(), 1u);
  EXPECT_EQ(one_shot.outliers.position[0], stray);
  const FilterOutcome chain = run_chain(input.points, {});
  expect_same_bytes(one_shot.mesh, chain.mesh);
  EXPECT_EQ(std::get<Index>(chain.figures.at("outliers")), 1);
  for (const FilterOutcome& outcome : {one_shot, chain})
    EXPECT_TRUE(is_in({outcome.log.back()}, "every sample but the 1 outlier left out"));
  const FilterOutcome report = run(Filter::matching_report, through_layer(input.points, one_shot));
  EXPECT_EQ(std::get<Index>(report.figures.at("samples_matched")), count);
  EXPECT_EQ(std::get<Index>(report.figures.at("extra_vertices")), 0);
  EXPECT_EQ(std::get<Index>(report.figures.at("outliers")), 1);
}

// Stages that left out others would lose each other. The number of neighbours makes no difference.
TEST(FilterRuns, EveryStageLeavesOutTheSameStrays) {
  Random random(21);
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::blob, 2500, 3));
  for (int i = 0; i < 125; ++i) input.points.push_back(rounded_to_single(1.5 * random.in_cube()));
  const auto strays = [](const FilterOutcome& outcome) {
    return std::get<Index>(outcome.figures.at("outliers"));
  };
  const ParameterValues changed = {{"Neighbours", 8}};
  const FilterOutcome one_shot = run(Filter::reconstruct, input, changed);
  ASSERT_GT(strays(one_shot), 100);
  EXPECT_EQ(strays(one_shot), strays(run(Filter::reconstruct, input)));
  FilterOutcome outcome = run(Filter::initial_mesh, input, changed);
  EXPECT_EQ(strays(outcome), strays(one_shot));
  for (const Filter filter :
       {Filter::control_mesh, Filter::parametric_surface, Filter::complete_matching,
        Filter::edge_optimisation, Filter::matching_report}) {
    SCOPED_TRACE(static_cast<int>(filter));
    outcome = run(filter, through_layer(input.points, outcome), changed);
    EXPECT_EQ(strays(outcome), strays(one_shot));
  }
}

// What the log says was taken, the chain is to be told.
TEST(FilterRuns, ChainThroughTheSamplesOfANoisyCloudGivesTheBytesOfTheOneShot) {
  SampleDefects defects;
  defects.noise = 1.0;
  for (const unsigned seed : {1u, 3u}) {
    FilterInput input;
    input.points = in_single_precision(sample_shape(ShapeKind::bowl, 2500, seed, defects));
    const FilterOutcome one_shot = run(Filter::reconstruct, input);
    const auto is_taken = [&](const char* what) {
      return std::any_of(one_shot.log.begin(), one_shot.log.end(), [&](const std::string& line) {
        return is_in({line}, what) && is_in({line}, "and taken");
      });
    };
    ASSERT_TRUE(is_taken("with a surface smoothed for the noise"));
    ParameterValues changed = {{"SmoothForNoise", 1}};
    changed["BacksAreOpenings"] = is_taken("with the backs of sheets") ? 1 : 0;
    expect_same_bytes(one_shot.mesh, run_chain(input.points, changed).mesh);
  }
}

TEST(FilterRuns, ChainOverASheetGivesTheBytesOfTheOneShot) {
  FilterInput input;
  input.points = in_single_precision(sample_strip(600, 5, 4));
  for (const auto openings :
       {CompleteMatchingOptions::Openings::close, CompleteMatchingOptions::Openings::leave_open,
        CompleteMatchingOptions::Openings::automatic}) {
    const auto value = static_cast<double>(openings);
    const FilterOutcome one_shot = run(Filter::reconstruct, input, {{"Openings", value}});
    // What is left open is found along the surface at once.
    const bool is_taken = openings != CompleteMatchingOptions::Openings::leave_open;
    ASSERT_EQ(is_told(one_shot, "and taken"), is_taken);
    const ParameterValues chain = {{"Openings", value}, {"BacksAreOpenings", is_taken ? 1.0 : 0.0}};
    expect_same_bytes(one_shot.mesh, run_chain(input.points, chain).mesh);
  }
}

TEST(FilterRuns, ASurfaceThatKeepsDetailIsTold) {
  FilterInput input;
  input.points = in_single_precision(sample_shape_blue_noise(ShapeKind::box, 600, 1));
  const ParameterValues stop = {{"StopAtParametricSurface", 1}, {"KeepStages", 1}};
  const FilterOutcome one_shot = run(Filter::reconstruct, input, stop);
  const std::string told = "the vertices are the samples, moved onto it";
  ASSERT_TRUE(is_told(one_shot, told));
  ASSERT_EQ(one_shot.mesh.position.size(), input.points.size());
  // The surface that it was moved onto is a stage, not the result.
  ASSERT_FALSE(one_shot.stages.empty());
  EXPECT_EQ(one_shot.stages.back().name, "parametric surface");
  EXPECT_NE(one_shot.stages.back().mesh.position, one_shot.mesh.position);
  for (const StageRecord& stage : one_shot.stages)
    if (stage.name == "control mesh") input.mesh = stage.mesh;
  const FilterOutcome alone = run(Filter::parametric_surface, input, {{"SmoothForNoise", 1}});
  EXPECT_TRUE(is_told(alone, told));
  EXPECT_TRUE(is_told(alone, "with the detail of its samples, 600 vertices, 1196 faces"));
}

// Where all its openings are left open nothing is spanned that detail could be lost with.
TEST(FilterRuns, ASurfaceThatIsLeftOpenKeepsDetail) {
  FilterInput input;
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::box, 800, 1))
    if (p.z() < 0.3) input.points.push_back(rounded_to_single(p));
  const ParameterValues stop = {
      {"StopAtParametricSurface", 1}, {"Openings", 2}, {"WidestOpening", 4}};
  const FilterOutcome open = run(Filter::reconstruct, input, stop);
  EXPECT_TRUE(is_told(open, "Openings: 1 left open"));
  EXPECT_TRUE(is_told(open, "the vertices are the samples, moved onto it"));
}

TEST(FilterRuns, OpeningsOfASurfaceAreToldAndTheChainHasThem) {
  SampleDefects defects;
  defects.noise = 0.4;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::hemisphere, 2500, 3, defects));
  const ParameterValues stop = {{"SmoothForNoise", 1}};
  FilterOutcome chain = run(Filter::initial_mesh, input, stop);
  chain = run(Filter::control_mesh, through_layer(input.points, chain));
  chain = run(Filter::parametric_surface, through_layer(input.points, chain), stop);
  const FilterOutcome closed = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  expect_same_bytes(closed.mesh, chain.mesh);
  ASSERT_EQ(closed.mesh.face_quality.size(), closed.mesh.triangles.size());
  EXPECT_EQ(closed.mesh.face_quality, chain.mesh.face_quality);
  for (const FilterOutcome& outcome : {closed, chain})
    EXPECT_TRUE(is_told(outcome, "Openings: 1 spanned, 1 of them by membranes stretched"));
  const FilterOutcome open =
      run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}, {"Openings", 1}});
  EXPECT_TRUE(is_told(open, "Openings: 1 left open"));
  EXPECT_LT(open.mesh.triangles.size(), closed.mesh.triangles.size());
}

TEST(FilterRuns, FalseHandlesAreToldUnlessTheyStay) {
  SampleDefects defects;
  defects.noise = 0.15;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::thin_plate, 1000, 2, defects));
  const ParameterValues stay = {{"CutFalseHandles", 0}};
  for (const Filter filter : {Filter::reconstruct, Filter::initial_mesh}) {
    const FilterOutcome cut = run(filter, input), kept = run(filter, input, stay);
    EXPECT_TRUE(is_in(cut.warnings, "that no samples bear out")) << cut.layer_suffix;
    EXPECT_FALSE(is_in(kept.warnings, "that no samples bear out")) << kept.layer_suffix;
    EXPECT_NE(cut.mesh.triangles, kept.mesh.triangles);
  }
  expect_same_bytes(run(Filter::reconstruct, input).mesh, run_chain(input.points, {}).mesh);
}

TEST(FilterRuns, SmallerVoxelsForEdgesAreTold) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::thin_plate, 700, 2));
  for (const Filter filter : {Filter::reconstruct, Filter::initial_mesh}) {
    const FilterOutcome outcome = run(filter, input);
    EXPECT_TRUE(is_told(outcome, "% of the samples lie at edges")) << outcome.layer_suffix;
  }
}

TEST(FilterRuns, KeptStagesAreThoseOfTheChain) {
  const std::vector<Vec3> points = in_single_precision(sample_shape(ShapeKind::blob, 1500, 5));
  FilterInput input;
  input.points = points;
  const FilterOutcome outcome = run(Filter::reconstruct, input, {{"KeepStages", 1}});
  ASSERT_EQ(outcome.stages.size(), 4u);
  EXPECT_EQ(outcome.stages[0].name, "initial mesh");
  EXPECT_EQ(outcome.stages[3].name, "complete matching");
  const FilterOutcome initial = run(Filter::initial_mesh, input);
  expect_same_bytes(outcome.stages[0].mesh, initial.mesh);
  const FilterOutcome control = run(Filter::control_mesh, through_layer(points, initial));
  expect_same_bytes(outcome.stages[1].mesh, control.mesh);
}

TEST(FilterRuns, OutliersAreTold) {
  std::vector<Vec3> points = in_single_precision(sample_shape(ShapeKind::sphere, 1500, 8));
  points.insert(points.begin() + 10, Vec3(2, 2, 2));
  FilterInput input;
  input.points = points;
  const FilterOutcome outcome = run(Filter::reconstruct, input);
  ASSERT_EQ(outcome.outliers.position.size(), 1u);
  EXPECT_EQ(outcome.outliers.input_index, std::vector<Index>{10});
  EXPECT_EQ(outcome.outliers.position[0], Vec3(2, 2, 2));
  EXPECT_EQ(std::get<Index>(outcome.figures.at("outliers")), 1);
  EXPECT_NE(outcome.log.back().find("1500 of 1500 samples matched"), std::string::npos)
      << outcome.log.back();
  EXPECT_NE(outcome.log.back().find("every sample but the 1 outlier left out"), std::string::npos)
      << outcome.log.back();
  const FilterOutcome all = run(Filter::reconstruct, input, {{"ExcludeOutliers", 0}});
  EXPECT_TRUE(all.outliers.position.empty());
  EXPECT_NE(all.log.back().find("1501 of 1501 samples matched"), std::string::npos)
      << all.log.back();
}

TEST(FilterRuns, ReportTellsCompleteFromIncomplete) {
  const std::vector<Vec3> points = in_single_precision(sample_shape(ShapeKind::sphere, 800, 7));
  FilterInput input;
  input.points = points;
  FilterInput measured = through_layer(points, run(Filter::reconstruct, input));
  EXPECT_NO_THROW(run(Filter::matching_report, measured, {{"FailIfIncomplete", 1}}));
  measured.mesh.triangles.pop_back();
  EXPECT_THROW(run(Filter::matching_report, measured, {{"FailIfIncomplete", 1}}),
               ReconstructionFailed);
  const FilterOutcome outcome = run(Filter::matching_report, measured);
  EXPECT_NE(outcome.log.back().find("NOT complete"), std::string::npos);
}

TEST(FilterRuns, DistanceIsExactAndInTheUnitsOfTheLayer) {
  FilterInput input;
  input.points = {{1000, 0, 0}, {1003, 4, 0}, {std::nan(""), 0, 0}};
  input.mesh.position = {{1000, 0, 0}, {1003, 0, 0}, {1000, 0, -12}, {std::nan(""), 0, 0}};
  const FilterOutcome outcome = run(Filter::distance_to_samples, input);
  ASSERT_EQ(outcome.distance.size(), 4u);
  EXPECT_EQ(outcome.distance[0], 0.0);
  EXPECT_EQ(outcome.distance[1], 3.0);
  EXPECT_EQ(outcome.distance[2], 12.0);
  EXPECT_EQ(outcome.distance[3], 0.0);
  EXPECT_EQ(outcome.warnings.size(), 1u);
  EXPECT_EQ(std::get<double>(outcome.figures.at("mean_distance")), 5.0);
  EXPECT_TRUE(is_told(outcome, "distance of 3 vertices from 2 points"));
}

TEST(FilterRuns, RefusesWhatItCannotUse) {
  FilterInput input;
  for (const Filter filter :
       {Filter::reconstruct, Filter::initial_mesh, Filter::control_mesh, Filter::parametric_surface,
        Filter::complete_matching, Filter::edge_optimisation, Filter::matching_report,
        Filter::distance_to_samples})
    EXPECT_THROW(run(filter, input), InvalidInput) << filter_name(filter);

  const std::vector<Vec3> points = in_single_precision(sample_shape(ShapeKind::sphere, 500, 8));
  input.points = points;
  FilterInput mesh = through_layer(points, run(Filter::initial_mesh, input));
  EXPECT_THROW(run(Filter::edge_optimisation, mesh), InvalidInput) << "its vertices are no samples";
  mesh.mesh.triangles.pop_back();
  EXPECT_THROW(run(Filter::control_mesh, mesh), InvalidInput) << "it has a border";
}

// Faces that span an opening are known by their quality: the mesh may come from anywhere, and other
// faces may be selected or have a quality of another kind.
TEST(FilterRuns, EdgeOptimisationTakesMeshesOfAnyStageAndKeepsThePromise) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::hemisphere, 1500, 11));
  const ParameterValues open = {{"Openings", 1}, {"KeepStages", 1}};
  const FilterOutcome one_shot = run(Filter::reconstruct, input, open);
  ASSERT_EQ(one_shot.stages.back().name, "complete matching");
  FilterInput kept = input;
  kept.mesh = one_shot.stages.back().mesh;
  kept.mesh.position = in_single_precision(kept.mesh.position);
  const FilterOutcome again = run(Filter::edge_optimisation, kept, open);
  expect_same_bytes(again.mesh, one_shot.mesh);
  EXPECT_NE(again.log.back().find("open (1 border) 2-manifold of genus 0"), std::string::npos)
      << again.log.back();

  // A closed mesh: its spanning faces can be dropped later.
  FilterInput closed = through_layer(input.points, run(Filter::reconstruct, input));
  const auto border_loops = [&] {
    const FilterOutcome outcome = run(Filter::edge_optimisation, closed, open);
    EXPECT_EQ(std::get<Index>(outcome.figures.at("samples_missing")), 0);
    return std::get<Index>(outcome.figures.at("border_loops"));
  };
  EXPECT_EQ(border_loops(), 1);

  // The quality of a face far from the rim: its length says that it spans, anything else does not.
  const std::vector<Triangle>& faces = closed.mesh.triangles;
  std::vector<float>& quality = closed.mesh.face_quality;
  const auto length_of = [&](std::size_t f) {
    double longest = 0.0;
    for (int i = 0; i < 3; ++i)
      longest = std::max(
          longest,
          (closed.mesh.position[faces[f][i]] - closed.mesh.position[faces[f][(i + 1) % 3]]).norm());
    return longest;
  };
  const auto height_of = [&](const Triangle& t) {
    double height = 0.0;
    for (const Index v : t) height += closed.mesh.position[v].z();
    return height;
  };
  const auto first_spanning =
      std::find_if(quality.begin(), quality.end(), [](float q) { return q > 0.0f; });
  const auto spanning = static_cast<std::size_t>(first_spanning - quality.begin());
  const double spacing = length_of(spanning) / quality[spanning];
  const auto highest = std::max_element(
      faces.begin(), faces.end(),
      [&](const Triangle& a, const Triangle& b) { return height_of(a) < height_of(b); });
  const auto top = static_cast<std::size_t>(highest - faces.begin());
  quality[top] = static_cast<float>(0.9 * length_of(top) / spacing);
  EXPECT_EQ(border_loops(), 1);
  quality[top] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(border_loops(), 1);
  quality[top] = static_cast<float>(length_of(top) / spacing);
  EXPECT_EQ(border_loops(), 2);

  // Of a sample that has none but such faces one stays, or it would be lost.
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (std::count(faces[f].begin(), faces[f].end(), faces[top][0]) > 0)
      quality[f] = static_cast<float>(length_of(f) / spacing);
  EXPECT_EQ(border_loops(), 2);

  for (float& q : quality) q = 0.7f;
  EXPECT_EQ(border_loops(), 0);
}

TEST(FilterRuns, EdgesOfAFinishedMeshAreChosenAnew) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::double_torus, 3000, 12));
  const FilterInput finished = through_layer(input.points, run(Filter::reconstruct, input));
  const ParameterValues bending_alone = {{"CreaseAngle", 0}, {"LeastGap", 1}};
  const FilterOutcome bent = run(Filter::edge_optimisation, finished, bending_alone);
  EXPECT_NE(bent.mesh.triangles, finished.mesh.triangles);
  EXPECT_EQ(std::get<Index>(bent.figures.at("samples_matched")), 3000);
  const auto is_as_bent = [&, as_bent = through_layer(input.points, bent)](const auto& changed) {
    return run(Filter::edge_optimisation, as_bent, changed).mesh.triangles == bent.mesh.triangles;
  };
  EXPECT_TRUE(is_as_bent(bending_alone));
  for (const auto& one : bending_alone) EXPECT_FALSE(is_as_bent(ParameterValues{one}));
}

// The box that the paper starts from is kept with the stages, and takes no time.
TEST(FilterRuns, TheBoundingBoxIsNoStage) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::sphere, 800, 13));
  const FilterOutcome outcome = run(Filter::reconstruct, input, {{"Method", 1}, {"KeepStages", 1}});
  EXPECT_EQ(outcome.stages.front().name, "bounding box");
  EXPECT_EQ(outcome.figures.count("seconds_bounding_box"), 0u);
  EXPECT_EQ(outcome.figures.count("seconds_initial_mesh"), 1u);
}

TEST(FilterRuns, StagesRefuseWhatDoesNotFitOrIsNotFinite) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::sphere, 2000, 14));
  FilterInput initial = through_layer(input.points, run(Filter::initial_mesh, input));
  FilterRequest request = request_of(Filter::control_mesh, default_values(Filter::control_mesh));
  request.options.memory_limit = 1 << 20;
  Progress silent;
  EXPECT_THROW(run_filter(Filter::control_mesh, request, initial, silent), InvalidInput);
  ParameterValues large_box = default_values(Filter::initial_mesh);
  large_box["Method"] = 1;
  large_box["BoxLevels"] = 8;  // 393,218 vertices
  request = request_of(Filter::initial_mesh, large_box);
  request.options.memory_limit = estimated_peak_bytes(100000);
  EXPECT_THROW(run_filter(Filter::initial_mesh, request, input, silent), InvalidInput);

  // As the wrong layer would have it: a mesh that is fine already.
  const FilterInput finished = through_layer(input.points, run(Filter::reconstruct, input));
  const FilterOutcome as_it_is = run(Filter::parametric_surface, finished);
  EXPECT_EQ(as_it_is.mesh.triangles.size(), finished.mesh.triangles.size());
  ASSERT_FALSE(as_it_is.warnings.empty());
  EXPECT_NE(as_it_is.warnings.back().find("neither subdivided nor fitted"), std::string::npos);

  initial.mesh.position[3].y() = std::nan("");
  for (const Filter filter : {Filter::control_mesh, Filter::parametric_surface}) {
    std::string message;
    try {
      run(filter, initial);
    } catch (const InvalidInput& error) {
      message = error.what();
    }
    EXPECT_NE(message.find("not finite"), std::string::npos) << message;
  }
}

TEST(FilterRuns, StagesDeclaredAreStagesPassed) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::sphere, 500, 9));
  const FilterRequest request =
      request_of(Filter::reconstruct, default_values(Filter::reconstruct));
  std::vector<std::string> passed;
  double last = 0.0;
  Progress progress(
      [&](double fraction, const char* stage) {
        EXPECT_GE(fraction, last);
        last = fraction;
        if (passed.empty() || passed.back() != stage) passed.push_back(stage);
        return true;
      },
      stages_of(Filter::reconstruct, request));
  run_filter(Filter::reconstruct, request, input, progress);
  std::vector<std::string> declared;
  for (const Stage stage : stages_of(Filter::reconstruct, request))
    declared.push_back(stage_name(stage));
  EXPECT_EQ(passed, declared);
}

}  // namespace
