#include "filter_log.h"

#include <gtest/gtest.h>

#include <cmath>

#include "filter_outcomes.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

TEST(FilterLog, WhatSuitsAnOpenSheetIsTold) {
  FilterInput strip, torus;
  strip.points = in_single_precision(sample_strip(600, 10, 4));
  torus.points = in_single_precision(sample_shape(ShapeKind::torus, 1000, 3));
  const std::string told = "the cloud is an open sheet";
  EXPECT_TRUE(is_told(run(Filter::reconstruct, strip), told));
  EXPECT_TRUE(is_told(run(Filter::reconstruct, strip, {{"StopAtParametricSurface", 1}}), told));
  EXPECT_FALSE(is_told(run(Filter::reconstruct, strip, {{"Openings", 2}}), told));
  EXPECT_FALSE(is_told(run(Filter::reconstruct, strip, {{"Method", 1}}), told));
  EXPECT_FALSE(is_told(run(Filter::reconstruct, torus), told));
}

TEST(FilterLog, CoordinatesWithFewStepsAreWarnedOf) {
  const std::vector<Vec3> shape = sample_shape(ShapeKind::sphere, 2000, 3);
  const std::string told = "are held in steps of 0.25";
  Progress silent;
  const double step = 0.25, spacing = reconstruct(shape, {}, silent).spacing;
  for (const double part : {0.025, 0.015}) {  // of the spacing
    FilterInput input;
    for (const Vec3& p : shape)
      input.points.push_back(step / (part * spacing) * p + Vec3(500000.0, 4000000.0, 100.0));
    EXPECT_FALSE(is_in(run(Filter::reconstruct, input).warnings, "in steps of")) << "doubles";
    input.points = in_single_precision(input.points);
    for (const Filter filter : {Filter::reconstruct, Filter::initial_mesh})
      EXPECT_EQ(is_in(run(filter, input).warnings, told), part > 0.02) << part;
  }
  // How far away a stray point is does not matter.
  FilterInput with_stray;
  with_stray.points = in_single_precision(sample_shape(ShapeKind::sphere, 8000, 3));
  with_stray.points.emplace_back(9000.0, 0.0, 0.0);
  const FilterOutcome outcome = run(Filter::reconstruct, with_stray);
  EXPECT_EQ(outcome.outliers.position.size(), 1u);
  EXPECT_FALSE(is_in(outcome.warnings, "in steps of"));
  // So few that nothing is left of the surface.
  std::vector<Vec3> small;
  for (const Vec3& p : shape) small.push_back(0.05 * p + Vec3(500000.0, 4000000.0, 100.0));
  try {
    FilterInput input;
    input.points = in_single_precision(small);
    run(Filter::reconstruct, input);
    ADD_FAILURE() << "nothing was refused";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("subtract an offset"), std::string::npos)
        << error.what();
  }
}

TEST(FilterLog, SecondAttemptsTellOnlyOfFaultsThatThereWere) {
  Reconstruction result;
  result.smoothing.is_made = result.smoothing.is_finished = true;
  const auto told = [&](Index faces, Index vertices) {
    result.smoothing.first = {faces, 0, vertices, 0};
    FilterOutcome outcome;
    tell_of_attempts(result, outcome);
    return outcome.log.at(0);
  };
  EXPECT_EQ(told(3, 0).rfind("Matched again because of 3 faces that met", 0), 0u);
  EXPECT_EQ(told(3, 0).find("no sample"), std::string::npos);
  EXPECT_EQ(told(0, 1).rfind("Matched again because of 1 vertex that is no sample", 0), 0u);
  EXPECT_EQ(told(0, 1).find("until annealed"), std::string::npos);
  EXPECT_NE(told(3, 2).find("still do and 2 vertices that are no samples"), std::string::npos);
}

TEST(FilterLog, ASurfaceThatLosesManySamplesIsWarnedOf) {
  // Balls in one another, 0.6 spacings apart.
  FilterInput shells, torus;
  std::vector<Vec3> points;
  for (const double radius : {1.0, 0.9, 0.8, 0.7})
    for (const Vec3& p : sample_shape(ShapeKind::sphere, 500, 3)) points.push_back(radius * p);
  shells.points = in_single_precision(points);
  torus.points = in_single_precision(sample_shape(ShapeKind::torus, 1000, 3));
  const auto is_warned_of = [](const FilterInput& input, const ParameterValues& values) {
    return is_in(run(Filter::reconstruct, input, values).warnings,
                 "farther from the parametric surface than their spacing");
  };
  EXPECT_TRUE(is_warned_of(shells, {}));
  EXPECT_TRUE(is_warned_of(shells, {{"StopAtParametricSurface", 1}}));
  EXPECT_FALSE(is_warned_of(torus, {}));

  Reconstruction result;
  result.detail.surfaces = 1;
  for (const double far : {0.029, 0.031}) {
    result.detail.far = result.detail.far_at_first = far;
    FilterOutcome outcome;
    tell_of_detail(result, outcome);
    EXPECT_EQ(outcome.warnings.size(), far > 0.03 ? 1u : 0u) << far;
    EXPECT_TRUE(outcome.log.empty());
  }
}

TEST(FilterLog, NoiseAndWhatWasSmoothedAreTold) {
  SampleDefects defects;
  defects.noise = 0.6;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 2500, 3, defects));
  const ParameterValues stop = {{"StopAtParametricSurface", 1}}, smooth = {{"SmoothForNoise", 1}};
  const FilterOutcome initial = run(Filter::initial_mesh, input, smooth);
  const FilterInput control =
      through_layer(input.points, run(Filter::control_mesh, through_layer(input.points, initial)));
  for (const FilterOutcome& outcome : {run(Filter::reconstruct, input, stop), initial,
                                       run(Filter::parametric_surface, control, smooth)}) {
    EXPECT_GT(std::get<double>(outcome.figures.at("noise")), 0.4);
    EXPECT_TRUE(is_told(outcome, "noise of the samples")) << outcome.layer_suffix;
    EXPECT_TRUE(is_told(outcome, "noise smoothed: 2500 samples moved")) << outcome.layer_suffix;
  }
  EXPECT_FALSE(is_told(run(Filter::reconstruct, input), "noise smoothed"));
}

FilterInput sphere_noisy_from(double x) {
  Random random(4);
  FilterInput input;
  input.points = sample_shape(ShapeKind::sphere, 4000, 3);
  for (Vec3& p : input.points)
    if (p.x() > x) p += 0.05 * random.in_cube();
  input.points = in_single_precision(std::move(input.points));
  return input;
}

TEST(FilterLog, NoiseOfAPartIsTold) {
  const FilterInput input = sphere_noisy_from(0.4);
  const FilterOutcome mesh = run(Filter::reconstruct, input);
  const FilterOutcome surface = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  const std::string offer = " %) are noisy, by about 0.";
  for (const FilterOutcome& outcome : {mesh, surface})
    EXPECT_TRUE(is_told(outcome, " %) there is more: about 0."));
  EXPECT_TRUE(is_in(mesh.warnings, offer));
  EXPECT_FALSE(is_in(surface.warnings, offer));
  EXPECT_FALSE(is_told(mesh, " elsewhere"));
  const FilterOutcome mostly = run(Filter::reconstruct, sphere_noisy_from(-0.4));
  EXPECT_GT(std::get<double>(mostly.figures.at("noise")), NoiseOptions().high);
  EXPECT_TRUE(is_told(mostly, ", and 0.00 elsewhere"));
  EXPECT_TRUE(is_in(mostly.warnings, offer));
}

TEST(FilterLog, LayersAreTold) {
  FilterInput input;
  for (int x = 0; x < 60; ++x)
    for (int y = 0; y < 60; ++y)
      input.points.emplace_back(x, y, 3.0 * std::round(0.15 * x + 0.1 * y));
  const FilterOutcome layered =
      run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}, {"Openings", 1}});
  EXPECT_TRUE(is_told(layered, "the samples lie in 15 layers along z, 2.9 spacings apart"));
  for (Vec3& p : input.points) p.z() = 0.45 * p.x() + 0.3 * p.y() + 1e-3 * p.x() * p.x();
  EXPECT_FALSE(is_told(run(Filter::reconstruct, input, {{"Openings", 1}}), "layers along"));
}

TEST(FilterLog, EveryRunEndsWithAVerdict) {
  const std::vector<Vec3> points = in_single_precision(sample_shape(ShapeKind::sphere, 800, 6));
  FilterInput input;
  input.points = points;
  const FilterOutcome surface = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  const FilterOutcome mesh = run(Filter::reconstruct, input);
  for (const FilterOutcome& outcome :
       {surface, mesh, run(Filter::matching_report, through_layer(points, mesh)),
        run(Filter::distance_to_samples, through_layer(points, mesh))}) {
    ASSERT_FALSE(outcome.log.empty());
    EXPECT_EQ(outcome.log.back().rfind(kSucceeded, 0), 0u) << outcome.log.back();
  }
  EXPECT_NE(mesh.log.back().find("800 of 800 samples matched"), std::string::npos)
      << mesh.log.back();
}

// A surface near the samples passes through hardly any of them, and is not meant to.
TEST(FilterLog, TheVerdictOnASurfaceIsNotAboutMatching) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 1000, 10));
  input.points.push_back(Vec3(2, 2, 2));
  const FilterOutcome outcome = run(Filter::reconstruct, input, {{"StopAtParametricSurface", 1}});
  const std::string& verdict = outcome.log.back();
  ASSERT_EQ(outcome.outliers.position.size(), 1u);
  for (const char* word : {"match", "extra", "every sample"})
    EXPECT_EQ(verdict.find(word), std::string::npos) << verdict;
  const std::string vertices = std::to_string(outcome.mesh.position.size());
  EXPECT_NE(verdict.find("closed 2-manifold of genus 1, 1 component; " + vertices +
                         " vertices for 1000 samples; 0 self-intersecting faces"),
            std::string::npos)
      << verdict;
}

// What a warning advises is a parameter of the filter that gives it.
TEST(FilterLog, AdviceForNoiseIsWhatTheFilterCanDo) {
  SampleDefects defects;
  defects.noise = 0.6;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 1500, 3, defects));
  const FilterOutcome initial = run(Filter::initial_mesh, input);
  const FilterInput control =
      through_layer(input.points, run(Filter::control_mesh, through_layer(input.points, initial)));
  const auto expect_advice = [](const FilterOutcome& outcome, const char* other,
                                const char* parameter) {
    EXPECT_TRUE(is_in(outcome.warnings, parameter)) << outcome.layer_suffix;
    EXPECT_FALSE(is_in(outcome.warnings, other)) << outcome.layer_suffix;
  };
  expect_advice(run(Filter::reconstruct, input), "SmoothForNoise", "StopAtParametricSurface");
  expect_advice(initial, "StopAtParametricSurface", "SmoothForNoise");
  expect_advice(run(Filter::parametric_surface, control), "StopAtParametricSurface",
                "SmoothForNoise");
  // Who follows it is not told again.
  EXPECT_FALSE(is_in(run(Filter::initial_mesh, input, {{"SmoothForNoise", 1}}).warnings, "noisy"));
  // The paper's method cannot, whatever is chosen beside it.
  const auto is_told_to_change = [&](Filter filter, double method, double stop) {
    const FilterOutcome outcome =
        run(filter, input,
            {{"Method", method}, {"StopAtParametricSurface", stop}, {"SmoothForNoise", stop}});
    return is_in(outcome.warnings, "smooths nothing");
  };
  for (const Filter filter : {Filter::reconstruct, Filter::initial_mesh})
    for (const double stop : {0.0, 1.0}) {
      EXPECT_TRUE(is_told_to_change(filter, 1.0, stop));
      EXPECT_FALSE(is_told_to_change(filter, 0.0, stop));
    }
}

TEST(FilterLog, ThePaperClosesEveryOpeningAndSaysSo) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::hemisphere, 800, 13));
  const auto warned = [](const FilterOutcome& outcome) {
    return is_in(outcome.warnings, "closes every opening");
  };
  const ParameterValues both = {{"Method", 1}, {"Openings", 1}};
  EXPECT_TRUE(warned(run(Filter::reconstruct, input, both)));
  EXPECT_FALSE(warned(run(Filter::reconstruct, input, {{"Method", 1}})));
  EXPECT_FALSE(warned(run(Filter::reconstruct, input, {{"Openings", 1}})));
  const FilterInput closed = through_layer(input.points, run(Filter::reconstruct, input));
  const FilterOutcome edges = run(Filter::edge_optimisation, closed, both);
  EXPECT_TRUE(warned(edges));
  EXPECT_EQ(std::get<Index>(edges.figures.at("border_loops")), 0);
}

}  // namespace
