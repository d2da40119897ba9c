#include "script_figures.h"

#include <gtest/gtest.h>

#include "filter_outcomes.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// Every figure of the table and no other, of its type. Returns how many times of stages there are.
int expect_figures_of(Filter filter, const FilterOutcome& outcome) {
  SCOPED_TRACE(filter_name(filter));
  std::set<std::string> names;
  int times = 0;
  for (const auto& [name, value] : outcome.figures) {
    EXPECT_EQ(std::holds_alternative<double>(value), is_real_figure(name)) << name;
    const bool is_of_stage = name.rfind("seconds_", 0) == 0 && name != "seconds_total";
    times += is_of_stage;
    if (!is_of_stage) names.insert(name);
  }
  EXPECT_EQ(names, script_figures(filter));
  return times;
}

struct FiguresCase {
  std::string name;
  ParameterValues changed;
  int stages;  ///< of the reconstruction
};

class ScriptFigures : public ::testing::TestWithParam<FiguresCase> {};

TEST_P(ScriptFigures, AreThoseOfTheTableForEveryFilter) {
  const ParameterValues& changed = GetParam().changed;
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 1000, 10));
  const FilterOutcome whole = run(Filter::reconstruct, input, changed);
  EXPECT_EQ(expect_figures_of(Filter::reconstruct, whole), GetParam().stages);
  FilterOutcome outcome = run(Filter::initial_mesh, input, changed);
  EXPECT_EQ(expect_figures_of(Filter::initial_mesh, outcome), 0);
  for (const Filter filter : {Filter::control_mesh, Filter::parametric_surface,
                              Filter::complete_matching, Filter::edge_optimisation}) {
    outcome = run(filter, through_layer(input.points, outcome), changed);
    EXPECT_EQ(expect_figures_of(filter, outcome), 0);
  }
  FilterInput measured = through_layer(input.points, outcome);
  for (const Filter filter : {Filter::matching_report, Filter::distance_to_samples})
    EXPECT_EQ(expect_figures_of(filter, run(filter, measured, changed)), 0);
  // Of a mesh that lacks a sample: a stray one, or not.
  measured.points.push_back(Vec3(2, 2, 2));
  expect_figures_of(Filter::matching_report, run(Filter::matching_report, measured, changed));
}

INSTANTIATE_TEST_SUITE_P(
    ScriptFigures, ScriptFigures,
    ::testing::Values(
        FiguresCase{"defaults", {}, 9}, FiguresCase{"with_outliers", {{"ExcludeOutliers", 0}}, 8},
        FiguresCase{"no_intersections", {{"RepairIntersections", 0}, {"CountIntersections", 0}}, 9},
        FiguresCase{"surface", {{"StopAtParametricSurface", 1}, {"SmoothForNoise", 1}}, 7}),
    [](const auto& test) { return test.param.name; });

TEST(ScriptFigures, SayWhatIsKnownOfThisMesh) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::torus, 1000, 10));
  const FilterOutcome outcome = run(Filter::reconstruct, input);
  EXPECT_EQ(std::get<Index>(outcome.figures.at("genus")), 1);
  EXPECT_EQ(std::get<Index>(outcome.figures.at("samples_matched")), 1000);
  EXPECT_EQ(std::get<Index>(outcome.figures.at("self_intersecting_faces")), 0);

  const FilterInput itself = through_layer(input.points, outcome);
  const FilterOutcome report = run(Filter::matching_report, itself);
  EXPECT_EQ(std::get<Index>(report.figures.at("outliers")), 0);
  const FilterOutcome distance = run(Filter::distance_to_samples, itself);
  EXPECT_EQ(std::get<Index>(distance.figures.at("vertices")), 1000);
  EXPECT_EQ(std::get<double>(distance.figures.at("mean_distance")), 0.0);
  EXPECT_EQ(std::get<double>(distance.figures.at("greatest_distance")), 0.0);
}

}  // namespace
