#include "parametric_surface/parametric_surface.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "initial_mesh/initial_mesh.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

TEST(LoopWeights, KnownValues) {
  EXPECT_DOUBLE_EQ(loop_beta(3), 3.0 / 16.0);
  EXPECT_NEAR(loop_beta(6), 1.0 / 16.0, 1e-15);
  // The limit weight is that at which another subdivision leaves the limit position where it is:
  // 1 / (3 / (8 beta) + K).
  for (Index valence = 3; valence < 20; ++valence)
    EXPECT_NEAR(loop_limit_weight(valence), 1.0 / (3.0 / (8.0 * loop_beta(valence)) + valence),
                1e-14);
}

TEST(LoopSubdivide, CountsAndTopology) {
  const SurfaceMesh torus = torus_mesh(9, 5);
  const SurfaceMesh finer = loop_subdivide(torus);
  expect_closed_manifold(finer, 1, 1);
  EXPECT_EQ(finer.vertex_count(), torus.vertex_count() + torus.face_count() * 3 / 2);
  EXPECT_EQ(finer.face_count(), 4 * torus.face_count());
}

TEST(LoopSubdivide, LimitPositionsStayWhereTheyAre) {
  // A vertex and its offspring have the same limit position, whatever the valence.
  SurfaceMesh mesh = icosphere(1);
  Random random(11);
  for (Vec3& p : mesh.position) p += 0.1 * random.in_cube();
  const auto limit_position = [](const SurfaceMesh& m, Index v) {
    Vec3 sum = Vec3::Zero();
    m.for_each_outgoing(v, [&](Index h) { sum += m.position[m.target(h)] - m.position[v]; });
    return Vec3(m.position[v] + loop_limit_weight(m.valence(v)) * sum);
  };
  const SurfaceMesh finer = loop_subdivide(mesh);
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const Vec3 before = limit_position(mesh, v);
    double nearest = 1e300;
    for (Index w = 0; w < finer.vertex_slots(); ++w)
      nearest = std::min(nearest, (limit_position(finer, w) - before).norm());
    EXPECT_LT(nearest, 1e-14) << "vertex " << v;
  }
}

TEST(LoopSubdivide, KeepsAPlaneAndPrecision) {
  // An octahedron squashed into a plane stays there.
  SurfaceMesh mesh = icosphere(2);
  for (Vec3& p : mesh.position) p.z() = 0.5;
  for (const Vec3& p : loop_subdivide(mesh).position) EXPECT_NEAR(p.z(), 0.5, 1e-15);
}

TEST(ParametricSurface, LiesOnTheSampledSurface) {
  const PointCloud samples = oriented_cloud(sample_shape_blue_noise(ShapeKind::torus, 6000, 4));
  SurfaceMesh control = torus_mesh(24, 12);
  ParametricSurfaceOptions options;
  options.fine_enough = 0.0;
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(control, samples.frame), samples, options, silent);
  expect_closed_manifold(surface.mesh, 1, 1);
  EXPECT_EQ(surface.report.subdivisions, 2);
  EXPECT_EQ(surface.mesh.vertex_count(), 16 * control.vertex_count());
  EXPECT_EQ(surface.report.membrane_vertices, 0);
  EXPECT_LT(surface.report.mean_distance, 0.05);
  const Shape torus = shape_of(ShapeKind::torus);
  double sum = 0.0;
  for (const Vec3& p : surface.mesh.position)
    sum += std::abs(torus.implicit(samples.frame.to_input(p)));
  const double spacing = samples.frame.to_input_length(samples.spacing);
  EXPECT_LT(sum / surface.mesh.vertex_count(), 0.06 * spacing);
  EXPECT_GT(normal_consistency(surface.mesh, torus, samples.frame), 0.995);
}

TEST(ParametricSurface, LeavesTheLastSubdivisionOutWhereItIsFineEnough) {
  const PointCloud smooth = oriented_cloud(sample_shape_blue_noise(ShapeKind::sphere, 4500, 14));
  // A cube of few samples has edges that a coarse surface cuts off.
  const PointCloud sharp = oriented_cloud(sample_shape_blue_noise(ShapeKind::box, 1500, 14));
  const auto subdivisions_of = [](const PointCloud& samples, double fine_enough) {
    ParametricSurfaceOptions options;
    options.fine_enough = fine_enough;
    options.fine_enough_from = 1000;
    Progress silent;
    const ParametricSurface surface =
        make_parametric_surface(in_frame(icosphere(2), samples.frame), samples, options, silent);
    expect_closed_manifold(surface.mesh, 1, 0);
    return surface.report.subdivisions;
  };
  EXPECT_EQ(subdivisions_of(smooth, 0.5), 1);
  EXPECT_EQ(subdivisions_of(smooth, 0.0), 2);
  EXPECT_EQ(subdivisions_of(sharp, 0.5), 2);
}

// With one subdivision more than usual that is the last, and not the one before it too.
TEST(ParametricSurface, OnlyTheLastOfThreeSubdivisionsIsLeftOut) {
  const PointCloud samples = oriented_cloud(sample_shape_blue_noise(ShapeKind::sphere, 6000, 14));
  ParametricSurfaceOptions options;
  options.fine_enough_from = 1000;
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(icosphere(1), samples.frame), samples, options, silent);
  EXPECT_EQ(surface.report.subdivisions, 2);
}

TEST(ParametricSurface, NearestSampleFittingComesCloseToo) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::sphere, 3000, 5));
  ParametricSurfaceOptions options;
  options.target = ParametricSurfaceOptions::Target::nearest_sample;
  options.attraction = 0.85;
  options.relaxation = 0.0;
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(icosphere(2), samples.frame), samples, options, silent);
  expect_closed_manifold(surface.mesh, 1, 0);
  for (const Vec3& p : surface.mesh.position)
    EXPECT_NEAR(samples.frame.to_input(p).norm(), 1.0, 0.05);
}

TEST(ParametricSurface, SubdividesAgainWhereTheControlMeshIsCoarse) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::sphere, 4000, 6));
  ParametricSurfaceOptions options;
  options.fine_enough = 0.0;
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(icosphere(1), samples.frame), samples, options, silent);
  EXPECT_EQ(surface.report.subdivisions, 3);
  EXPECT_EQ(surface.mesh.vertex_count(), 2562);
}

TEST(ParametricSurface, AMembraneIsNotPulledOntoTheSamples) {
  // The far half of the sphere has no samples: it is smoothed, and does not collapse onto the rim.
  const PointCloud samples =
      oriented_cloud(sample_shape_blue_noise(ShapeKind::hemisphere, 3000, 7));
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(icosphere(3), samples.frame), samples, {}, silent);
  expect_closed_manifold(surface.mesh, 1, 0);
  EXPECT_GT(surface.report.membrane_vertices, surface.mesh.vertex_count() / 10);
  EXPECT_LT(surface.report.mean_distance, 0.2);
}

// Where two sides are close to each other, a search must not begin where another one ended.
TEST(ParametricSurface, DistancesAreMeasuredToTheSideThatAVertexIsOn) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::thin_plate, 2000, 9));
  ParametricSurface surface;
  Progress silent;
  surface.mesh = make_initial_mesh(samples, {}, silent).mesh;
  for (Vec3& p : surface.mesh.position) p *= 1.05;
  measure_distances(surface, samples, {}, silent);
  const std::vector<char> is_membrane = mark_membranes(surface.mesh, samples, {}, silent);
  EXPECT_GT(surface.report.membrane_vertices, 0);
  EXPECT_EQ(surface.report.membrane_vertices,
            std::count(is_membrane.begin(), is_membrane.end(), 1));
}

TEST(ParametricSurface, DistancesAreMeasuredWithoutFittingToo) {
  const PointCloud samples = oriented_cloud(sample_shape_blue_noise(ShapeKind::sphere, 3000, 9));
  SurfaceMesh control = icosphere(2);
  for (Vec3& p : control.position) p *= 1.1;
  ParametricSurfaceOptions options;
  options.iterations = 0;
  Progress silent;
  const ParametricSurface surface =
      make_parametric_surface(in_frame(control, samples.frame), samples, options, silent);
  EXPECT_GT(surface.report.subdivisions, 0);
  EXPECT_GT(surface.report.mean_distance, 0.5);
  EXPECT_GE(surface.report.max_distance, surface.report.mean_distance);
}

TEST(ParametricSurface, IsTheSameForAnyNumberOfThreads) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::blob, 20000, 8));
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Progress silent;
    return make_parametric_surface(in_frame(icosphere(3), samples.frame), samples, {}, silent).mesh;
  };
  expect_same_mesh(with_threads(1), with_threads(2));
}

// A sphere two spacings inside its samples: noise of one spacing would explain that.
TEST(PartOfSamplesFar, IsOfThoseThatTheNoiseAroundThemDoesNotExplain) {
  PointCloud cloud = oriented_cloud(sample_shape_blue_noise(ShapeKind::sphere, 3000, 1));
  const double inside = 1.0 - 2.0 * cloud.frame.to_input_length(cloud.spacing);
  const SurfaceMesh surface = in_frame(placed(icosphere(5), inside, Vec3::Zero()), cloud.frame);
  Progress silent;
  EXPECT_EQ(part_of_samples_far(surface, cloud, 0.0, silent), 1.0);
  EXPECT_EQ(part_of_samples_far(surface, cloud, 1.0, silent), 0.0);
  cloud.more_noise.resize(cloud.position.size());
  for (std::size_t i = 0; i < cloud.more_noise.size(); i += 3) cloud.more_noise[i] = 1.0f;
  EXPECT_NEAR(part_of_samples_far(surface, cloud, 0.0, silent), 2.0 / 3.0, 1e-3);
}

}  // namespace
}  // namespace shrinkwrap::testing
