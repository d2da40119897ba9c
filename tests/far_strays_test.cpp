// Points beside which the others would fall together.
#include "samples/far_strays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "filter_outcomes.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

std::vector<Vec3> with(std::vector<Vec3> points, const std::vector<Vec3>& more) {
  points.insert(points.begin() + 17, more.begin(), more.end());
  return points;
}

FarStrays strays_of(const std::vector<Vec3>& points) {
  Progress silent;
  return find_far_strays(points, {}, silent);
}

std::vector<Vec3> sphere_at(const Vec3& centre, Index count) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, count, 3);
  for (Vec3& p : points) p += centre;
  return points;
}

TEST(FarStrays, AreFoundWhereverTheyAreAndHoweverOften) {
  const std::vector<Vec3> sphere = sphere_at({5.0, 0.0, 0.0}, 3000);
  EXPECT_TRUE(strays_of(sphere).all.empty());
  EXPECT_TRUE(strays_of(with(sphere, {{1e3, 0, 0}})).all.empty()) << "for the search of outliers";
  for (const double far : {1e6, 1e10, 1e38, 1e308}) {
    const Vec3 sentinel(far, far, -far);
    const FarStrays strays =
        strays_of(with(sphere, {sentinel, {0, std::nan(""), 0}, {0, far, 0}, sentinel, sentinel}));
    EXPECT_EQ(strays.all, (std::vector<Index>{17, 19, 20, 21})) << far;
    EXPECT_EQ(strays.distinct, (std::vector<Index>{17, 19})) << far;
  }
  const std::vector<Vec3> many(4000, Vec3(-1e10, -1e10, -1e10));
  EXPECT_EQ(strays_of(with(sphere, many)).all.size(), 4000u);
}

TEST(FarStrays, AFarBodyIsNone) {
  std::vector<Vec3> bodies = sphere_at({0.0, 0.0, 0.0}, 3000);
  EXPECT_TRUE(strays_of(with(bodies, sphere_at({1e6, 0.0, 0.0}, 40))).all.empty());
  EXPECT_EQ(strays_of(with(bodies, sphere_at({1e6, 0.0, 0.0}, 20))).all.size(), 20u);
  EXPECT_TRUE(strays_of(with(sphere_at({0, 0, 0}, 50), {{1e6, 0, 0}})).all.empty()) << "too few";
  EXPECT_TRUE(strays_of({}).all.empty());
}

// The cloud is what it would be without them, and they are told like all outliers.
TEST(FarStrays, AreLeftOutOfTheSurface) {
  const std::vector<Vec3> blob = in_single_precision(sample_shape(ShapeKind::blob, 3000, 5));
  const std::vector<Vec3> strays =
      in_single_precision({{1e7, 0, 0}, {1e10, 1e10, 1e10}, {1e10, 1e10, 1e10}});
  Progress silent;
  const Reconstruction alone = reconstruct(blob, {}, silent);
  const Reconstruction result = reconstruct(with(blob, strays), {}, silent);
  EXPECT_EQ(result.outliers.input_index, (std::vector<Index>{17, 18}));
  EXPECT_EQ(result.conditioning.distinct, 3002u);
  EXPECT_EQ(result.conditioning.duplicates, 1u);
  EXPECT_EQ(result.report.samples_matched, 3000);
  EXPECT_EQ(result.mesh.position, alone.mesh.position);
  EXPECT_EQ(result.mesh.triangles, alone.mesh.triangles);
}

// Files may hold little else.
TEST(FarStrays, AreFoundAmongManyCopiesAndPointsThatAreNone) {
  std::vector<Vec3> points(200000, Vec3::Constant(std::nan("")));
  for (std::size_t i = 0; i < points.size(); i += 2) points[i] = Vec3::Constant(1e12);
  const std::vector<Vec3> sphere = sphere_at({0, 0, 0}, 400);
  points.insert(points.end(), sphere.begin(), sphere.end());
  EXPECT_EQ(strays_of(points).all.size(), 100000u);
  EXPECT_EQ(strays_of(points).distinct, (std::vector<Index>{0}));
}

// Where such a point was kept it stays a sample, as all outliers do that are vertices.
TEST(FarStrays, WhatIsAVertexOfTheMeshIsASample) {
  FilterInput input;
  input.points = with(in_single_precision(sample_shape(ShapeKind::sphere, 1500, 6)),
                      in_single_precision({{4e4, 0, 0}}));
  EXPECT_EQ(run(Filter::initial_mesh, input).outliers.input_index, (std::vector<Index>{17}));
  const FilterInput mesh =
      through_layer(input.points, run(Filter::reconstruct, input, {{"ExcludeOutliers", 0}}));
  const FilterOutcome edges = run(Filter::edge_optimisation, mesh);
  EXPECT_EQ(std::get<Index>(edges.figures.at("samples_matched")), 1501);
}

// A haze that is too much to be left out is told beside them.
TEST(FarStrays, SuspectsThatStayAreTold) {
  FilterInput input;
  input.points = in_single_precision(sample_shape(ShapeKind::sphere, 4000, 15));
  Random random(16);
  for (int i = 0; i < 1500; ++i) input.points.push_back(rounded_to_single(6.0 * random.in_cube()));
  const FilterOutcome haze = run(Filter::initial_mesh, input);
  ASSERT_TRUE(is_in(haze.warnings, "what seems stray is left in"));
  input.points.push_back({1e9, 0, 0});
  const FilterOutcome both = run(Filter::initial_mesh, input);
  EXPECT_TRUE(is_in(both.warnings, "what seems stray is left in"));
  EXPECT_TRUE(is_in(both.warnings, "1 outlier left out"));
  EXPECT_FALSE(
      is_in(run(Filter::initial_mesh, {sphere_at({0, 0, 0}, 1500), {}}).warnings, "stray"));
}

TEST(FarStrays, EveryFilterLeavesThemOutUnlessTheyAreToStay) {
  FilterInput input;
  input.points = with(in_single_precision(sample_shape(ShapeKind::sphere, 1500, 6)),
                      in_single_precision({{0, -1e9, 0}}));
  const FilterOutcome initial = run(Filter::initial_mesh, input);
  EXPECT_EQ(initial.outliers.input_index, (std::vector<Index>{17}));
  const FilterInput mesh = through_layer(input.points, run(Filter::reconstruct, input));
  const FilterOutcome report = run(Filter::matching_report, mesh, {{"FailIfIncomplete", 1}});
  EXPECT_EQ(std::get<Index>(report.figures.at("samples_matched")), 1500);
  try {
    run(Filter::reconstruct, input, {{"ExcludeOutliers", 0}});
    FAIL() << "no surface could be told";
  } catch (const InvalidInput& error) {
    EXPECT_TRUE(is_in({error.what()}, "told with 1 of them ten thousand times")) << error.what();
  }
  std::vector<Vec3> flat = input.points;
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (i != 17) flat[i].z() = 0.0;
  try {
    run(Filter::reconstruct, {flat, {}});
    FAIL() << "they are flat";
  } catch (const InvalidInput& error) {
    EXPECT_TRUE(is_in({error.what()},
                      " but 1 (ten thousand times as far away as the others reach, left out)"))
        << error.what();
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
