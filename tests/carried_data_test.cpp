// Where vertices that are no samples have their colours from.
#include "report/carried_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "filter_outcomes.h"
#include "report/nearest_points.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(NearestPoints, AreThoseOfASearchThroughAll) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::blob, 700, 1);
  const std::vector<Vec3> queries = sample_shape(ShapeKind::torus, 300, 2);
  Progress silent;
  const std::vector<NearestPoint> nearest = nearest_points(points, queries, silent);
  ASSERT_EQ(nearest.size(), queries.size());
  for (std::size_t q = 0; q < queries.size(); ++q) {
    Index best = 0;
    for (Index i = 1; i < static_cast<Index>(points.size()); ++i)
      if ((points[i] - queries[q]).norm() < (points[best] - queries[q]).norm()) best = i;
    EXPECT_EQ(nearest[q].index, best);
    EXPECT_NEAR(nearest[q].distance, (points[best] - queries[q]).norm(), 1e-12);
  }
}

TEST(NearestPoints, WhatIsNotFiniteHasNoneAndIsNone) {
  Progress silent;
  const std::vector<Vec3> points = {{0, 0, kNan}, {1, 0, 0}, {0, INFINITY, 0}, {3, 0, 0}};
  const std::vector<NearestPoint> nearest =
      nearest_points(points, {{0, 0, 0}, {kNan, 0, 0}, {2.5, 0, 0}}, silent);
  EXPECT_EQ(nearest[0].index, 1);
  EXPECT_EQ(nearest[1].index, kNone);
  EXPECT_TRUE(std::isinf(nearest[1].distance));
  EXPECT_EQ(nearest[2].index, 3);
  EXPECT_EQ(nearest_points({{kNan, 0, 0}}, {{0, 0, 0}}, silent)[0].index, kNone);
}

TEST(CarriedData, SamplesHaveTheirOwnAndOthersThatOfTheNearestThatIsNotLeftOut) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  ResultMesh mesh;
  mesh.position = {{2, 0, 0}, {0.9, 0, 0}, {2.1, 0, 0}};
  mesh.input_index = {0, kNone, kNone};  // a sample that was moved
  Progress silent;
  carry_data({&mesh}, points, {1}, silent);
  EXPECT_EQ(mesh.data_index, (std::vector<Index>{0, 0, 2}));
}

TEST(CarriedData, CopiesOfWhatIsLeftOutAreLeftOutToo) {
  const Vec3 sentinel = Vec3::Constant(1e300);
  const std::vector<Vec3> points = {sentinel, {1, 0, 0}, sentinel, {2, 0, 0}, sentinel};
  ResultMesh mesh;
  mesh.position = {{1.9, 0, 0}, {1.1, 0, 0}};
  mesh.input_index = {kNone, kNone};
  Progress silent;
  carry_data({&mesh}, points, {0}, silent);
  EXPECT_EQ(mesh.data_index, (std::vector<Index>{3, 1}));
}

TEST(CarriedData, IsNotAskedForWhereEveryVertexIsASample) {
  ResultMesh mesh;
  mesh.position = {{2, 0, 0}};
  mesh.input_index = {0};
  Progress silent;
  carry_data({&mesh}, {{2, 0, 0}}, {}, silent);
  EXPECT_TRUE(mesh.data_index.empty());
}

// All the meshes of a run, and only if it is asked for.
TEST(CarriedData, IsThereForEveryMeshOfARun) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::sphere, 1200, 4));
  FilterRequest request = request_of(Filter::reconstruct, default_values(Filter::reconstruct));
  request.options.stop_at_parametric_surface = true;
  request.options.keep_stages = true;
  Progress silent;
  EXPECT_TRUE(run_filter(Filter::reconstruct, request, input, silent).mesh.data_index.empty());
  request.carries_data = true;
  const FilterOutcome outcome = run_filter(Filter::reconstruct, request, input, silent);
  ASSERT_FALSE(outcome.stages.empty());
  std::vector<const ResultMesh*> meshes = {&outcome.mesh};
  for (const StageRecord& stage : outcome.stages) meshes.push_back(&stage.mesh);
  for (const ResultMesh* mesh : meshes) {
    ASSERT_EQ(mesh->data_index.size(), mesh->position.size());
    const std::vector<NearestPoint> nearest = nearest_points(input.points, mesh->position, silent);
    for (std::size_t v = 0; v < nearest.size(); ++v)
      EXPECT_EQ(mesh->data_index[v], nearest[v].index);
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
