// Outliers that the surface shows, through the filters of the stages.
#include <gtest/gtest.h>

#include <algorithm>

#include "filter_outcomes.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

Index figure(const FilterOutcome& outcome, const char* name) {
  return std::get<Index>(outcome.figures.at(name));
}

TEST(FilterOutliers, AChainFindsThoseOffTheSurfaceAsTheOneShotDoes) {
  FilterInput input;
  input.points = in_single_precision(cube_with_strays_beside_edges(900, 5));
  const FilterOutcome one_shot = run(Filter::reconstruct, input);
  ASSERT_TRUE(is_told(one_shot, "told by the surface"));
  const Index all = figure(one_shot, "outliers");
  EXPECT_EQ(one_shot.outliers.position.size(), static_cast<std::size_t>(all));

  FilterOutcome outcome = run(Filter::initial_mesh, input);
  const Index at_first = figure(outcome, "outliers");
  ASSERT_LT(at_first, all);
  std::vector<Index> in_layers = outcome.outliers.input_index;
  for (const Filter filter : {Filter::control_mesh, Filter::parametric_surface}) {
    outcome = run(filter, through_layer(input.points, outcome));
    EXPECT_EQ(figure(outcome, "outliers"), at_first);
    EXPECT_TRUE(outcome.outliers.position.empty());
  }
  outcome = run(Filter::complete_matching, through_layer(input.points, outcome));
  EXPECT_EQ(figure(outcome, "outliers"), all);
  EXPECT_TRUE(is_told(outcome, "told by the surface"));
  const std::vector<Index>& found = outcome.outliers.input_index;
  in_layers.insert(in_layers.end(), found.begin(), found.end());
  std::sort(in_layers.begin(), in_layers.end());
  EXPECT_EQ(in_layers, one_shot.outliers.input_index);

  outcome = run(Filter::edge_optimisation, through_layer(input.points, outcome));
  EXPECT_EQ(figure(outcome, "outliers"), all);
  EXPECT_TRUE(outcome.outliers.position.empty());
  EXPECT_EQ(in_single_precision(outcome.mesh.position),
            in_single_precision(one_shot.mesh.position));
  EXPECT_EQ(outcome.mesh.triangles, one_shot.mesh.triangles);

  const FilterOutcome report = run(Filter::matching_report, through_layer(input.points, outcome));
  EXPECT_EQ(figure(report, "outliers"), all);
  EXPECT_EQ(figure(report, "samples_matched"), figure(report, "samples"));
  EXPECT_TRUE(is_in({report.log.back()}, "complete: "));
  const FilterOutcome strict =
      run(Filter::matching_report, through_layer(input.points, outcome), {{"ExcludeOutliers", 0}});
  EXPECT_EQ(figure(strict, "samples") - figure(strict, "samples_matched"), all);
}

}  // namespace
