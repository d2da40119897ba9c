#include "samples/noise.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "oriented_cloud.h"
#include "reconstruct.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

double noise_of(const std::vector<Vec3>& points) {
  Progress silent;
  return estimate_noise(oriented_cloud(points), {}, silent).median;
}

TEST(Noise, IsAboutRightUpToHalfASpacing) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::blob, ShapeKind::double_torus})
    for (const double noise : {0.1, 0.25, 0.5}) {
      SCOPED_TRACE(shape_of(kind).name + " " + std::to_string(noise));
      EXPECT_NEAR(noise_of(sample_noisy_shape(kind, 5000, 1, noise)), noise, 0.15 * noise);
    }
}

TEST(Noise, GrowsBeyondThat) {
  const double half = noise_of(sample_noisy_shape(ShapeKind::torus, 5000, 2, 0.5));
  const double one = noise_of(sample_noisy_shape(ShapeKind::torus, 5000, 2, 1.0));
  EXPECT_GT(one, half + 0.2);
  EXPECT_GT(one, 0.75) << "neighbourhoods of 16 alone give 0.65";
}

TEST(Noise, CleanCloudsAreNotCalledNoisy) {
  for (const ShapeKind kind : all_shapes()) {
    SCOPED_TRACE(shape_of(kind).name);
    EXPECT_LT(noise_of(sample_shape(kind, 4000, 3)), 0.25 * NoiseOptions().high);
    EXPECT_LT(noise_of(sample_shape_blue_noise(kind, 2000, 4)), 0.5 * NoiseOptions().high);
  }
}

TEST(Noise, FewNeighboursTellOfItToo) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::sphere, 5000, 5, 0.25);
  for (const int neighbours : {6, 8, 9, 10, 11, 13, 14, 16}) {
    SCOPED_TRACE(neighbours);
    Progress silent;
    SampleOptions options;
    options.neighbours = neighbours;
    PointCloud cloud = prepare_samples(points, options, silent);
    orient_normals(cloud, {}, silent);
    EXPECT_NEAR(estimate_noise(cloud, {}, silent).median, 0.25, 0.1);
  }
}

// A quadric misses the more of a surface the fewer samples show it.
TEST(Noise, CurvatureIsNotNoise) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    EXPECT_LT(noise_of(sample_shape_blue_noise(ShapeKind::sphere, 100, seed)), 0.02);
    EXPECT_LT(noise_of(sample_shape_blue_noise(ShapeKind::double_torus, 500, seed)), 0.02);
    SampleDefects defects;
    defects.noise = 0.1;
    EXPECT_NEAR(noise_of(sample_shape(ShapeKind::sphere, 1000, seed, defects)), 0.1, 0.02);
  }
}

// Taken for noisy they were moved, and grew together.
TEST(Noise, SurfacesOfSmallBallsStayApart) {
  std::vector<Vec3> points;
  for (int i = 0; i < 48; ++i) {
    const Vec3 centre = 4.0 * Vec3(i % 4, i / 4 % 4, i / 16);
    for (const Vec3& p : sample_shape(ShapeKind::sphere, 43, 1 + static_cast<unsigned>(i)))
      points.push_back(centre + p);
  }
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  Progress silent;
  const Reconstruction result = reconstruct(points, options, silent);
  EXPECT_LT(result.noise.median, options.denoising.before_initial_mesh_from);
  EXPECT_EQ(result.report.components, 48);
  EXPECT_EQ(result.report.genus, 0);
}

TEST(Noise, TwoSidesOfAThinWallAreNotNoise) {
  Random random(5);
  std::vector<Vec3> points;
  const double spacing = std::sqrt(2.0 * 4.0 / 10000);
  for (int i = 0; i < 10000; ++i)
    points.push_back(
        {random.uniform(-1, 1), random.uniform(-1, 1), (i % 2 == 0 ? 1.3 : -1.3) * spacing});
  EXPECT_LT(noise_of(points), 0.05);
}

TEST(Noise, ScaleAndThreadsDoNotMatter) {
  std::vector<Vec3> points = sample_noisy_shape(ShapeKind::blob, 6000, 6, 0.3);
  const PointCloud cloud = oriented_cloud(points);
  const auto with_threads = [&](int threads) {
    return tbb::task_arena(threads).execute([&] {
      Progress silent;
      return estimate_noise(cloud, {}, silent).median;
    });
  };
  EXPECT_EQ(with_threads(1), with_threads(2));
  for (Vec3& p : points) p *= 1024.0;
  EXPECT_EQ(noise_of(points), with_threads(1));
}

// What only smooths over is not asked of it: the surface must also be nearer to the truth.
TEST(Noise, TheParametricSurfaceOfANoisyCloudIsSmoothedForIt) {
  const ShapeKind kind = ShapeKind::torus;
  const std::vector<Vec3> points = sample_noisy_shape(kind, 5000, 7, 1.0);
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  const auto surface_with = [&](const ReconstructionOptions& chosen) {
    Progress silent;
    return reconstruct(points, chosen, silent);
  };
  const auto mean_error = [&](const Reconstruction& result) {
    double sum = 0.0;
    for (const Vec3& p : result.mesh.position) sum += std::abs(shape_of(kind).implicit(p));
    return sum / static_cast<double>(result.mesh.position.size());
  };
  const Reconstruction smooth = surface_with(options);
  EXPECT_GT(smooth.noise.median, options.noise.high);
  EXPECT_EQ(smooth.report.genus, shape_of(kind).genus);
  EXPECT_EQ(smooth.report.self_intersecting_faces, 0);
  options.noise.most_units = 0.0;
  options.denoising.from = 1e6;
  const Reconstruction rough = surface_with(options);
  EXPECT_LT(mean_error(smooth), 0.6 * mean_error(rough));
}

// The mesh through every sample is rough, but it has the handles of the object and none of the
// noise, and its faces do not meet.
TEST(Noise, TheMatchingOfANoisyCloudHasTheTopologyOfTheObject) {
  const auto matched = [](ShapeKind kind, unsigned seed, bool may_be_smoothed) {
    ReconstructionOptions options;
    if (!may_be_smoothed) {
      options.noise.high = options.denoising.from = 1e6;
      options.initial_mesh.false_handles.enabled = false;
    }
    Progress silent;
    return reconstruct(sample_noisy_shape(kind, 5000, seed, 1.0), options, silent).report;
  };
  int wrong = 0;
  for (const ShapeKind kind : {ShapeKind::torus, ShapeKind::double_torus, ShapeKind::blob}) {
    const Shape shape = shape_of(kind);
    SCOPED_TRACE(shape.name);
    const MeshReport smoothed = matched(kind, 8, true), rough = matched(kind, 8, false);
    EXPECT_EQ(smoothed.genus, shape.genus);
    EXPECT_EQ(smoothed.components, 1);
    EXPECT_TRUE(smoothed.complete_matching());
    wrong += rough.genus != shape.genus;
    EXPECT_EQ(smoothed.self_intersecting_faces, 0);
  }
  EXPECT_GT(wrong, 0) << "the cases are too easy";
}

TEST(Noise, FewSamplesTellNothing) {
  EXPECT_EQ(noise_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}), 0.0);
}

}  // namespace
