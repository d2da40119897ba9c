// Coordinates rounded to wide steps: told from slices, faces and sheets, and counted as noise.
#include "samples/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "oriented_cloud.h"
#include "reconstruct.h"
#include "samples/noise.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

constexpr double kRadius = 100.0;

double rounded(double x, double step) {
  return step > 0.0 ? step * std::round(x / step) : x;
}

// A part of a ball as a camera sees it, on a grid of cells of width 1 that is a little askew, which
// makes no two of its lines one. Depth in such steps; 0: as it is.
std::vector<Vec3> sample_front(double step, double width = 0.7 * kRadius) {
  std::vector<Vec3> points;
  for (double x = -width; x <= width; ++x)
    for (double y = -width; y <= width; ++y) {
      const double square = kRadius * kRadius - x * x - y * y;
      if (x * x + y * y <= width * width)
        points.emplace_back(x + 1e-4 * y, y + 1e-4 * x, rounded(std::sqrt(square), step));
    }
  return points;
}

// Squares of 21 by 21 samples, so far apart.
std::vector<Vec3> sample_stack(int count, double distance) {
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k)
    for (int x = 0; x <= 20; ++x)
      for (int y = 0; y <= 20; ++y) points.emplace_back(x, y, distance * k);
  return points;
}

// Around a cylinder, or a cone, so far apart, each of so many samples that are 1 apart.
std::vector<Vec3> sample_rings(int around, double distance, double growth = 0.0) {
  std::vector<Vec3> points;
  for (int k = 0; k < 12; ++k)
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * kPi * (i + 0.37 * k) / around;
      const double radius = 0.5 * around / kPi + growth * k;
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), distance * k);
    }
  return points;
}

// A plate of 50 by 50 by 10 cells of a grid, whose vertices on its faces are the samples.
std::vector<Vec3> sample_plate(double height_of_cell) {
  constexpr int kCells = 50, kLayers = 10;
  std::vector<Vec3> points;
  for (int x = 0; x <= kCells; ++x)
    for (int y = 0; y <= kCells; ++y)
      for (int z = 0; z <= kLayers; ++z)
        if (x % kCells == 0 || y % kCells == 0 || z % kLayers == 0)
          points.emplace_back(x, y, z * height_of_cell);
  return points;
}

Layers layers_of(const std::vector<Vec3>& points, const LayerOptions& options = {}) {
  Progress silent;
  return find_layers(prepared_cloud(points), options, silent);
}

NoiseEstimate noise_of(const std::vector<Vec3>& points) {
  Progress silent;
  return estimate_noise(oriented_cloud(points), {}, silent);
}

TEST(Layers, AreFoundAlongEveryAxis) {
  const std::vector<Vec3> front = sample_front(3.0);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3> turned;
    for (const Vec3& p : front) {
      Vec3& q = turned.emplace_back();
      for (int k = 0; k < 3; ++k) q[(axis + 1 + k) % 3] = 1e5 * p[k];
    }
    const Layers layers = layers_of(turned);
    EXPECT_EQ(layers.axis, axis);
    EXPECT_EQ(layers.count, 10);  // from 72 to 99
    EXPECT_NEAR(layers.step, 3.0, 0.1);
    EXPECT_NEAR(layers.upper_fifth, 3.0, 0.1);
  }
}

TEST(Layers, CloseFarAndFewOnesAreNone) {
  EXPECT_EQ(layers_of(sample_front(0.0)).axis, kNone);
  EXPECT_EQ(layers_of(sample_front(1.0)).axis, kNone) << "steps of one spacing do no harm";
  EXPECT_EQ(layers_of(sample_stack(10, 4.0)).axis, 2);
  EXPECT_EQ(layers_of(sample_stack(10, 20.0)).axis, kNone) << "these are sheets";
  EXPECT_EQ(layers_of(sample_stack(5, 4.0)).axis, kNone) << "these may be faces";
}

TEST(Layers, AreAsFarApartAsTheNearest) {
  std::vector<Vec3> pairs;
  for (const Vec3& p : sample_stack(20, 1.0)) {
    const int layer = static_cast<int>(p.z());
    pairs.emplace_back(p.x(), p.y(), 4.0 * (layer / 2) + layer % 2);
  }
  LayerOptions options;
  options.least_part = 0.1;
  EXPECT_EQ(layers_of(pairs, options).axis, kNone);
}

TEST(Layers, StepsMayDiffer) {
  std::vector<Vec3> points;
  for (const Vec3& p : sample_stack(20, 1.0))
    points.emplace_back(p.x(), p.y(), 3.0 * (p.z() + std::max(p.z() - 11.0, 0.0)));
  const Layers layers = layers_of(points);
  EXPECT_EQ(layers.count, 20);
  EXPECT_NEAR(layers.step, 3.0, 0.1);
  EXPECT_NEAR(layers.upper_fifth, 6.0, 0.2);
}

TEST(Layers, OfAPartOfTheSamplesAreNone) {
  std::vector<Vec3> points = sample_front(3.0);
  const std::vector<Vec3> beside = sample_front(0.0, 0.9 * kRadius);
  for (const Vec3& p : beside) points.push_back(p - Vec3(2.5 * kRadius, 0.0, 0.0));
  EXPECT_EQ(layers_of(points).axis, kNone);
  LayerOptions options;
  options.least_part = 0.1;
  options.least_step = 0.0;  // those beside have values in between
  EXPECT_EQ(layers_of(points, options).axis, 2);
}

TEST(Layers, OfAPartOfThePatchesAreNone) {
  std::vector<Vec3> points = sample_front(1.0);
  for (const Vec3& p : sample_stack(7, 4.0)) points.push_back(p + Vec3(0.0, 0.0, 200.0));
  EXPECT_EQ(layers_of(points).axis, kNone);
  LayerOptions options;
  options.least_part = 0.1;
  EXPECT_EQ(layers_of(points, options).axis, 2);
}

TEST(Layers, FacesAcrossAnAxisAndSlicesAreNone) {
  EXPECT_EQ(layers_of(sample_shape(ShapeKind::box, 4000, 1)).axis, kNone);
  EXPECT_EQ(layers_of(sample_shape(ShapeKind::thin_plate, 4000, 1)).axis, kNone);
  EXPECT_EQ(layers_of(cube_with_gaps({})).axis, kNone);
  EXPECT_EQ(layers_of(sample_plate(2.0)).axis, kNone);
  const std::vector<Vec3> slices = sample_rings(188, 5.0, 3.0);
  EXPECT_EQ(layers_of(slices).axis, kNone);
  for (const double distance : {3.0, 6.0, 12.0})
    for (const int around : {8, 16, 24})
      EXPECT_EQ(layers_of(sample_rings(around, distance)).axis, kNone) << around << " " << distance;
  LayerOptions options;
  options.widest_gap = 2.0 * kPi;
  EXPECT_EQ(layers_of(slices, options).axis, 2) << "lines: this test tests nothing";
}

TEST(Layers, RoughProfilesAreNone) {
  for (const double distance : {6.0, 10.0})
    for (const unsigned seed : {1u, 2u, 3u}) {
      Random random(seed);
      std::vector<Vec3> profiles;
      for (int k = 0; k < 20; ++k)
        for (int x = 0; x < 400; ++x)
          profiles.emplace_back(x, distance * k, 1.2 * random.gaussian());
      EXPECT_EQ(layers_of(profiles).axis, kNone) << distance << " " << seed;
    }
}

TEST(Layers, CountAsNoise) {
  for (const double step : {2.0, 3.0}) {
    const std::vector<Vec3> front = sample_front(step);
    const NoiseEstimate noise = noise_of(front);
    EXPECT_NEAR(noise.median, step / std::sqrt(12.0), 0.1);
    EXPECT_NEAR(noise.upper_fifth, step / std::sqrt(12.0), 0.1);
    NoiseOptions without;
    without.layers.least_part = 2.0;
    Progress silent;
    EXPECT_EQ(estimate_noise(oriented_cloud(front), without, silent).median, 0.0);
  }
}

// The noise of samples in layers is not told from their neighbours.
TEST(Layers, AreNoPartWithoutNoise) {
  std::vector<Vec3> points = sample_front(1.6);
  Random random(1);
  for (Vec3& p : points)
    if (p.x() > 0.5 * kRadius) p.z() += 0.5 * random.gaussian();
  Progress silent;
  PointCloud cloud = oriented_cloud(points);
  const double noise = estimate_noise(cloud, {}, silent).median;
  EXPECT_NEAR(noise, 1.6 / std::sqrt(12.0), 0.04);
  EXPECT_EQ(measure_more_noise(cloud, noise, {}, silent).others, noise);
}

TEST(Layers, CountAsNoiseOfOneSpacingAtMost) {
  const NoiseEstimate noise = noise_of(sample_stack(10, 6.0));
  EXPECT_NEAR(noise.layers.step, 6.0, 0.2);
  EXPECT_EQ(noise.median, 1.0);
  EXPECT_EQ(noise.upper_fifth, 1.0);
}

TEST(Layers, AreSmoothedWhereARunStopsAtTheSurface) {
  const std::vector<Vec3> front = sample_front(3.0);
  const auto distance_from_ball = [&](double least_part) {
    ReconstructionOptions options;
    options.stop_at_parametric_surface = true;
    options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
    options.noise.layers.least_part = least_part;
    Progress silent;
    const Reconstruction result = reconstruct(front, options, silent);
    double sum = 0.0;
    for (const Vec3& p : result.mesh.position) sum += std::abs(p.norm() - kRadius);
    return sum / static_cast<double>(result.mesh.position.size());
  };
  EXPECT_LT(distance_from_ball(0.25), 0.25);
  EXPECT_GT(distance_from_ball(2.0), 0.6) << "nothing is to be smoothed: this test tests nothing";
}

}  // namespace
}  // namespace shrinkwrap::testing
