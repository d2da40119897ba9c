#include "initial_mesh/bounding_box_start.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "expect_mesh.h"
#include "oriented_cloud.h"

namespace shrinkwrap::testing {
namespace {

InitialMesh shrink(const PointCloud& samples, const InitialMeshOptions& options = {}) {
  Progress silent;
  return shrink_bounding_box(samples, options, silent);
}

TEST(LevelsFor, FollowsTheTables) {
  const auto vertices_at = [](int levels) {
    Index vertices = 8;
    for (int i = 0; i < levels; ++i) vertices = subdivided_vertices(vertices);
    return vertices;
  };
  EXPECT_EQ(vertices_at(levels_for(12321)), 1538);
  EXPECT_EQ(vertices_at(levels_for(34267)), 6146);
  EXPECT_EQ(levels_for(4), 0);
  EXPECT_EQ(levels_for(103), 0);
  EXPECT_EQ(levels_for(104), 1);
  EXPECT_EQ(levels_for(4 * 24578), 6);
  EXPECT_EQ(levels_for(4 * 24578 - 1), 5);
  EXPECT_LE(levels_for(2147483647), 12);
}

TEST(BoxMesh, IsABox) {
  const SurfaceMesh box = box_mesh({-1.0, 0.0, 2.0}, {1.0, 3.0, 6.0});
  EXPECT_EQ(box.vertex_count(), 8);
  EXPECT_EQ(box.face_count(), 12);
  expect_closed_manifold(box, 1, 0);
  EXPECT_NEAR(signed_volume(box), 24.0, 1e-12);
}

TEST(MidpointSubdivide, SplitsEveryFaceIntoFour) {
  Progress silent;
  const SurfaceMesh torus = torus_mesh(7, 5);
  const SurfaceMesh finer = midpoint_subdivide(torus, silent);
  EXPECT_EQ(finer.vertex_count(), torus.vertex_count() + torus.face_count() * 3 / 2);
  EXPECT_EQ(finer.face_count(), 4 * torus.face_count());
  expect_closed_manifold(finer, 1, 1);
  EXPECT_NEAR(signed_volume(finer), signed_volume(torus), 1e-12);
  for (Index v = 0; v < torus.vertex_count(); ++v) EXPECT_EQ(finer.position[v], torus.position[v]);
  for (const Triangle& t : finer.triangles()) {
    const Vec3 &a = finer.position[t[0]], &b = finer.position[t[1]], &c = finer.position[t[2]];
    EXPECT_GT((b - a).cross(c - a).norm(), 0.0);
  }
}

TEST(ShrinkBoundingBox, WrapsEveryShape) {
  for (ShapeKind kind : all_shapes()) {
    const Shape shape = shape_of(kind);
    SCOPED_TRACE(shape.name);
    const PointCloud samples = prepared_cloud(sample_shape(kind, 2000, 11));
    const InitialMesh initial = shrink(samples);
    EXPECT_EQ(initial.report.levels, 3);
    EXPECT_EQ(initial.mesh.vertex_count(), 386);
    EXPECT_EQ(initial.report.components, 1);
    expect_closed_manifold(initial.mesh, 1, 0);
    EXPECT_GT(signed_volume(initial.mesh), 0.0);
    // The canonical form: the triangles alone give the same mesh.
    expect_same_mesh(initial.mesh,
                     SurfaceMesh::from_triangles(initial.mesh.position, initial.mesh.triangles()));
  }
}

TEST(ShrinkBoundingBox, ComesNearTheSphere) {
  const PointCloud samples = prepared_cloud(sample_shape_blue_noise(ShapeKind::sphere, 3000, 12));
  const InitialMesh initial = shrink(samples);
  const Frame& frame = samples.frame;
  for (const Vec3& p : initial.mesh.position) EXPECT_NEAR(frame.to_input(p).norm(), 1.0, 0.03);
  EXPECT_GT(normal_consistency(initial.mesh, shape_of(ShapeKind::sphere), frame), 0.99);
}

// Eq. 5 with xi = 1 and no relaxation moves every vertex exactly onto a sample.
TEST(ShrinkBoundingBox, ProjectsOntoSamples) {
  const PointCloud samples = prepared_cloud(sample_shape(ShapeKind::blob, 1000, 13));
  InitialMeshOptions options;
  options.projection = 1.0;
  options.box_relaxation = 0.0;
  options.iterations_per_level = 1;
  for (const Vec3& p : shrink(samples, options).mesh.position)
    EXPECT_LT(samples.search.nearest(p).squared_distance, 1e-30);
}

// Eq. 8 moves vertices along the surface only: without projection a box stays its box.
TEST(ShrinkBoundingBox, RelaxesAlongTheSurface) {
  const PointCloud samples = prepared_cloud(sample_shape(ShapeKind::box, 1000, 14));
  InitialMeshOptions options;
  options.levels = 3;
  options.projection = 0.0;
  options.box_relaxation = 0.0;
  options.iterations_per_level = 1;
  const SurfaceMesh box = shrink(samples, options).mesh;
  options.box_relaxation = 0.2;
  const SurfaceMesh relaxed = shrink(samples, options).mesh;
  EXPECT_NE(relaxed.position, box.position);
  EXPECT_NEAR(signed_volume(relaxed), signed_volume(box), 0.05 * signed_volume(box));
}

TEST(ShrinkBoundingBox, ObeysTheLevel) {
  const PointCloud samples = prepared_cloud(sample_shape(ShapeKind::sphere, 500, 15));
  InitialMeshOptions options;
  options.levels = 0;
  EXPECT_EQ(shrink(samples, options).mesh.vertex_count(), 8);
  options.levels = 5;
  const InitialMesh fine = shrink(samples, options);
  EXPECT_EQ(fine.mesh.vertex_count(), 6146);
  expect_closed_manifold(fine.mesh, 1, 0);
  options.levels = 13;
  EXPECT_THROW(shrink(samples, options), InvalidInput);
}

TEST(ShrinkBoundingBox, TakesTheFewestSamples) {
  const PointCloud samples = prepared_cloud({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-3}});
  for (int levels = -1; levels <= 4; ++levels) {
    InitialMeshOptions options;
    options.levels = levels;
    expect_closed_manifold(shrink(samples, options).mesh, 1, 0);
  }
}

TEST(ShrinkBoundingBox, IsTheSameForAnyNumberOfThreads) {
  const PointCloud samples = prepared_cloud(sample_shape(ShapeKind::torus, 30000, 16));
  const auto run_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return shrink(samples).mesh;
  };
  expect_same_mesh(run_with(1), run_with(2));
}

TEST(ShrinkBoundingBox, ReportsRisingProgressAndCanBeCancelled) {
  const PointCloud samples = prepared_cloud(sample_shape(ShapeKind::torus, 3000, 17));
  double last = 0.0;
  bool rising = true;
  Progress watched(
      [&](double fraction, const char*) {
        rising = rising && fraction >= last && fraction <= 1.0;
        last = fraction;
        return true;
      },
      {Stage::initial_mesh});
  watched.begin(Stage::initial_mesh);
  shrink_bounding_box(samples, {}, watched);
  EXPECT_TRUE(rising);

  Progress refused([](double, const char*) { return false; }, {Stage::initial_mesh});
  EXPECT_THROW(
      {
        refused.begin(Stage::initial_mesh);
        shrink_bounding_box(samples, {}, refused);
      },
      Cancelled);
}

}  // namespace
}  // namespace shrinkwrap::testing
