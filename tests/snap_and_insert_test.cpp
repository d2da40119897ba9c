#include "complete_matching/snap_and_insert.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "expect_mesh.h"
#include "initial_mesh/bounding_box_start.h"
#include "orientation/orientation.h"

namespace shrinkwrap::testing {
namespace {

// Samples as the stage gets them.
PointCloud prepare(const std::vector<Vec3>& points, bool with_normals = true) {
  Progress silent;
  PointCloud cloud = prepare_samples(points, {}, silent);
  if (with_normals) orient_normals(cloud, {}, silent);
  return cloud;
}

CompleteMatching match(SurfaceMesh surface, const PointCloud& samples) {
  Progress silent;
  return snap_and_insert(std::move(surface), samples, {}, silent);
}

SurfaceMesh box_start(const PointCloud& samples, int levels = -1) {
  Progress silent;
  InitialMeshOptions options;
  options.levels = levels;
  return shrink_bounding_box(samples, options, silent).mesh;
}

void expect_matched(const CompleteMatching& matching, const PointCloud& samples, Index genus) {
  expect_closed_manifold(matching.mesh, 1, genus);
  expect_complete_matching(matching, samples);
  EXPECT_EQ(matching.report.extra_vertices, 0);
  EXPECT_EQ(matching.mesh.vertex_count(), samples.size());
  for (Index v = 0; v < matching.mesh.vertex_count(); ++v)
    ASSERT_EQ(to_index(matching.sample_of_vertex[v]), v);
}

TEST(SnapAndInsert, MatchesASphere) {
  for (unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const PointCloud samples = prepare(sample_shape_blue_noise(ShapeKind::sphere, 2500, seed));
    const CompleteMatching matching = match(in_frame(icosphere(4), samples.frame), samples);
    expect_matched(matching, samples, 0);
    EXPECT_LT(matching.report.max_foot_distance, 0.5);
    EXPECT_GT(normal_consistency(matching.mesh, shape_of(ShapeKind::sphere), samples.frame), 0.99);
  }
}

TEST(SnapAndInsert, MatchesATorus) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::torus, 4000, 4));
  const CompleteMatching matching = match(in_frame(torus_mesh(100, 40), samples.frame), samples);
  expect_matched(matching, samples, 1);
  EXPECT_GT(normal_consistency(matching.mesh, shape_of(ShapeKind::torus), samples.frame), 0.97);
}

// Far fewer or far more vertices than samples: everything is inserted, or nearly all is removed.
TEST(SnapAndInsert, TakesSurfacesOfAnyResolution) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::sphere, 1500, 5));
  for (int subdivisions : {0, 2, 5}) {
    SCOPED_TRACE(subdivisions);
    const CompleteMatching matching =
        match(in_frame(icosphere(subdivisions), samples.frame), samples);
    expect_matched(matching, samples, 0);
    EXPECT_GT(normal_consistency(matching.mesh, shape_of(ShapeKind::sphere), samples.frame), 0.9);
  }
}

// Whatever the shape, a start of genus 0 gives a closed manifold of genus 0 through all samples.
TEST(SnapAndInsert, MatchesEveryShapeFromABox) {
  for (ShapeKind kind : all_shapes()) {
    SCOPED_TRACE(shape_of(kind).name);
    const PointCloud samples = prepare(sample_shape(kind, 1500, 6));
    expect_matched(match(box_start(samples), samples), samples, 0);
  }
}

TEST(SnapAndInsert, NeedsNoNormals) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::blob, 1500, 7), false);
  expect_matched(match(box_start(samples, 4), samples), samples, 0);
}

// Random noise and outliers, on a random shape; the guarantee does not depend on the cloud.
TEST(SnapAndInsert, HoldsItsPromiseOnBadClouds) {
  for (unsigned seed = 100; seed < 112; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SampleDefects defects;
    defects.noise = random.uniform(0.0, 1.0);
    defects.outliers = random.uniform(0.0, 0.05);
    const ShapeKind kind = all_shapes()[random.below(static_cast<Index>(all_shapes().size()))];
    const PointCloud samples = prepare(sample_shape(kind, 4 + random.below(800), seed, defects));
    expect_matched(match(box_start(samples, random.below(5)), samples), samples, 0);
  }
}

// Many samples whose nearest face is one and the same, round after round.
TEST(SnapAndInsert, TakesCrowds) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 200, 8);
  Random random(8);
  for (int i = 0; i < 3000; ++i) points.push_back(Vec3(0.6, 0.5, 0.6) + 1e-4 * random.in_cube());
  for (int i = 0; i < 500; ++i) points.push_back(Vec3(0.0, 0.0, 1.0 + 0.001 * i));
  const PointCloud samples = prepare(points);
  expect_matched(match(box_start(samples, 3), samples), samples, 0);
}

// Distinct in the input, but at one place of the unit frame.
TEST(SnapAndInsert, TakesSamplesThatCoincideAfterRounding) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 300, 9);
  for (int i = 0; i < 40; ++i) {
    points.push_back({1e-30 * i, 0.0, 1.0});
    points.push_back(points[i]);
    for (double& x : points.back()) x = std::nextafter(x, 2.0);
  }
  const PointCloud samples = prepare(points);
  expect_matched(match(box_start(samples, 3), samples), samples, 0);
}

TEST(SnapAndInsert, TakesTheFewestSamples) {
  const PointCloud samples = prepare({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  for (int levels = 0; levels <= 4; ++levels) {
    SCOPED_TRACE(levels);
    expect_matched(match(box_start(samples, levels), samples), samples, 0);
  }
}

// A torus needs seven vertices: with fewer samples some that are no sample have to stay.
TEST(SnapAndInsert, KeepsVerticesThatTheTopologyNeeds) {
  const PointCloud samples = prepare({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 0.25}});
  const CompleteMatching matching = match(in_frame(torus_mesh(12, 8), samples.frame), samples);
  expect_closed_manifold(matching.mesh, 1, 1);
  expect_complete_matching(matching, samples);
  EXPECT_GE(matching.report.extra_vertices, 2);
}

// A sphere far inside the samples wins none of them.
TEST(SnapAndInsert, DropsComponentsWithoutSamples) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::sphere, 400, 10));
  const SurfaceMesh both = joined({icosphere(3), placed(icosphere(1), 0.3, Vec3::Zero())});
  expect_matched(match(in_frame(both, samples.frame), samples), samples, 0);
}

TEST(SnapAndInsert, IsTheSameForAnyNumberOfThreads) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::torus, 12000, 11));
  const SurfaceMesh surface = in_frame(torus_mesh(180, 70), samples.frame);
  const auto run_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return match(surface, samples).mesh;
  };
  expect_same_mesh(run_with(1), run_with(2));
}

TEST(SnapAndInsert, CanBeCancelled) {
  const PointCloud samples = prepare(sample_shape(ShapeKind::sphere, 3000, 12));
  const SurfaceMesh surface = in_frame(icosphere(4), samples.frame);
  Progress refused([](double, const char*) { return false; }, {Stage::complete_matching});
  EXPECT_THROW(
      {
        refused.begin(Stage::complete_matching);
        snap_and_insert(surface, samples, {}, refused);
      },
      Cancelled);
}

}  // namespace
}  // namespace shrinkwrap::testing
