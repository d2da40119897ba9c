#include "orientation/denoising.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <string>

#include "orient_and_smooth.h"
#include "orientation/orientation.h"
#include "reconstruct.h"
#include "samples/noise.h"
#include "samples/tangent_target.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

PointCloud oriented(const std::vector<Vec3>& points, int neighbours = 16) {
  Progress silent;
  SampleOptions samples;
  samples.neighbours = neighbours;
  PointCloud cloud = prepare_samples(points, samples, silent);
  orient_normals(cloud, {}, silent);
  return cloud;
}

PointCloud denoised(const std::vector<Vec3>& points, const DenoisingOptions& options = {}) {
  Progress silent;
  PointCloud cloud = oriented(points);
  denoise(cloud, estimate_noise(cloud, {}, silent).median, 16, options, silent);
  return cloud;
}

struct Errors {
  double size = 0.0;     // mean absolute distance from the shape, x spacing of the samples
  double outward = 0.0;  // mean signed distance
  double cosine = 0.0;   // mean, of the angle between the normals and the shape's
};

Errors errors_of(const PointCloud& cloud, const Shape& shape, double spacing) {
  Errors errors;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    const double distance = shape.implicit(p) / spacing;
    errors.size += std::abs(distance) / cloud.size();
    errors.outward += distance / cloud.size();
    errors.cosine += cloud.normal[i].cast<double>().dot(shape.normal(p)) / cloud.size();
  }
  return errors;
}

// Quadrics over discs of 16 samples would leave half of it.
TEST(Denoising, MovesSamplesOntoTheSurface) {
  for (const ShapeKind kind : {ShapeKind::torus, ShapeKind::blob})
    for (const double noise : {0.1, 0.5}) {
      const Shape shape = shape_of(kind);
      SCOPED_TRACE(shape.name + " " + std::to_string(noise));
      const std::vector<Vec3> points = sample_noisy_shape(kind, 6000, 1, noise);
      const PointCloud before = oriented(points), after = denoised(points);
      const double spacing = before.frame.to_input_length(before.spacing);
      const Errors was = errors_of(before, shape, spacing), is = errors_of(after, shape, spacing);
      EXPECT_LT(is.size, 0.48 * was.size);
      EXPECT_LT(std::abs(is.outward), 0.1 * was.size) << "neither shrunk nor grown";
      EXPECT_GT(is.cosine, was.cosine - 0.001);
      EXPECT_GT(is.cosine, 0.98);
    }
}

// Small spheres, on which samples have moved along the surface too.
TEST(Denoising, WhatNoiseBlursIsMadeUpFor) {
  const Shape sphere = shape_of(ShapeKind::sphere);
  const auto outward = [&](double tangential_noise) {
    DenoisingOptions options;
    options.tangential_noise = tangential_noise;
    constexpr int kClouds = 8;
    double sum = 0.0;
    for (int seed = 1; seed <= kClouds; ++seed) {
      const PointCloud after =
          denoised(sample_noisy_shape(ShapeKind::sphere, 600, seed, 0.7), options);
      sum += errors_of(after, sphere, after.frame.to_input_length(after.spacing)).outward;
    }
    return sum / kClouds;
  };
  const double blurred = outward(0.0);
  EXPECT_LT(blurred, -0.04);
  EXPECT_LT(std::abs(outward(1.0)), 0.4 * std::abs(blurred));
}

// Of a sphere a fifth is clean.
TEST(Denoising, WhatIsCleanIsNotMadeUpFor) {
  const std::vector<Vec3> clean = sample_shape(ShapeKind::sphere, 2000, 4),
                          noisy = sample_noisy_shape(ShapeKind::sphere, 2000, 4, 0.6);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < clean.size(); ++i)
    points.push_back(clean[i].z() > 0.6 ? clean[i] : noisy[i]);
  const PointCloud after = denoised(points);
  double outward = 0.0;
  Index count = 0;
  for (Index i = 0; i < after.size(); ++i) {
    if (clean[after.input_index[i]].z() < 0.75) continue;
    outward += after.frame.to_input(after.position[i]).norm() - 1.0;
    ++count;
  }
  const double spacing = after.frame.to_input_length(after.spacing);
  EXPECT_LT(std::abs(outward / count), 0.01 * spacing);
}

TEST(Denoising, LeavesDetailWhereItIs) {
  const Shape box = shape_of(ShapeKind::box);
  const std::vector<Vec3> points = sample_shape(ShapeKind::box, 6000, 2);
  const PointCloud before = oriented(points), after = denoised(points);
  const double spacing = before.frame.to_input_length(before.spacing);
  EXPECT_LT(errors_of(after, box, spacing).size, 0.001) << "edges are not rounded without noise";

  const std::vector<Vec3> rough = sample_noisy_shape(ShapeKind::box, 6000, 2, 0.25);
  DenoisingOptions careless;
  careless.misfit = 1e6;
  careless.alike = 1.0;
  careless.least_cosine = 0.0;
  const double careful_error = errors_of(denoised(rough), box, spacing).size;
  EXPECT_LT(careful_error, 0.75 * errors_of(denoised(rough, careless), box, spacing).size);
}

TEST(Denoising, TellsWhoseTheSamplesAre) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::sphere, 3000, 3, 0.5);
  const PointCloud cloud = denoised(points);
  ASSERT_TRUE(cloud.is_denoised());
  std::vector<Index> sorted = cloud.input_index, all(points.size());
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all);
  const double spacing = cloud.frame.to_input_length(cloud.spacing);
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 moved = cloud.frame.to_input(cloud.position[i]) - points[cloud.input_index[i]];
    EXPECT_LT(moved.norm(), 3.5 * spacing);
    EXPECT_EQ(cloud.neighbours_of(i)[0], i);
    EXPECT_EQ(cloud.normal[i], cloud.plane[i].normal);
  }
}

TEST(Denoising, IsUndone) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::torus, 3000, 8, 0.5);
  const PointCloud before = oriented(points), moved = denoised(points);
  PointCloud cloud = moved;
  Progress silent;
  undo_denoising(cloud, points, 16, 14, silent);
  EXPECT_FALSE(cloud.is_denoised());
  EXPECT_EQ(cloud.position, before.position);
  EXPECT_EQ(cloud.input_index, before.input_index);
  EXPECT_EQ(cloud.neighbour, before.neighbour);
  EXPECT_EQ(cloud.local_spacing, before.local_spacing);
  EXPECT_EQ(cloud.spacing, before.spacing);
  EXPECT_EQ(cloud.search.nearest(cloud.position[5]).squared_distance, 0.0);
  std::map<Index, Vec3f> normal_of;
  for (Index i = 0; i < moved.size(); ++i) normal_of[moved.input_index[i]] = moved.normal[i];
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(cloud.normal[i], normal_of[cloud.input_index[i]]);
  // Each sample's plane is that of its own neighbours.
  ASSERT_EQ(cloud.plane.size(), cloud.position.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((cloud.plane[i].point.cast<double>() - cloud.position[i]).norm(),
              3.0 * cloud.spacing_at(i));
    EXPECT_GT(cloud.plane[i].normal.dot(cloud.normal[i]), 0.5f);
  }
}

TEST(Denoising, ASheetStaysASheet) {
  const std::vector<Vec3> points = sample_strip(3600, 60, 4);
  Progress silent;
  PointCloud cloud = oriented(points);
  const double closedness = cloud.closedness;
  ASSERT_LT(closedness, 0.5);
  denoise(cloud, 0.1, 16, {}, silent);
  EXPECT_EQ(cloud.closedness, closedness);
}

TEST(Denoising, TellsHowFarTheSamplesWent) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::sphere, 3000, 3, 0.5);
  Progress silent;
  PointCloud cloud = oriented(points);
  const double spacing = cloud.frame.to_input_length(cloud.spacing);
  const DenoisingReport report = denoise(cloud, 0.5, 16, {}, silent);
  Index moved = 0;
  double sum = 0.0, greatest = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 step = cloud.frame.to_input(cloud.position[i]) - points[cloud.input_index[i]];
    const double distance = step.norm() / spacing;
    moved += distance > 1e-9 ? 1 : 0;
    sum += distance;
    greatest = std::max(greatest, distance);
  }
  EXPECT_EQ(report.moved, moved);
  EXPECT_NEAR(report.mean_displacement, sum / cloud.size(), 1e-6);
  EXPECT_NEAR(report.max_displacement, greatest, 1e-6);
  EXPECT_NEAR(report.mean_displacement, 0.8 * 0.5, 0.1) << "what gaussian noise has in the mean";
}

TEST(Denoising, CancelledLeavesTheCloudAsItWas) {
  const PointCloud before = oriented(sample_noisy_shape(ShapeKind::blob, 12000, 8, 0.3));
  int cancelled = 0;
  for (const double from : {0.0, 0.3, 0.6, 0.8, 0.9}) {
    PointCloud cloud = before;
    bool is_armed = false;
    Progress progress([&](double fraction, const char*) { return !is_armed || fraction < from; },
                      {Stage::orientation});
    progress.begin(Stage::orientation);
    is_armed = true;
    try {
      denoise(cloud, 0.3, 16, {}, progress);
    } catch (const Cancelled&) {
      ++cancelled;
      EXPECT_FALSE(cloud.is_denoised());
      EXPECT_EQ(cloud.position, before.position);
      EXPECT_EQ(cloud.normal, before.normal);
      EXPECT_EQ(cloud.neighbour, before.neighbour);
      EXPECT_EQ(cloud.input_index, before.input_index);
    }
  }
  EXPECT_GE(cancelled, 1);
}

TEST(Denoising, HasAShareOfItsOwnInTheProgress) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::torus, 8000, 9, 0.6);
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  std::vector<double> fractions;
  Progress progress(
      [&](double fraction, const char* stage) {
        if (stage == std::string("orientation")) fractions.push_back(fraction);
        return true;
      },
      {Stage::orientation});
  PointCloud cloud = oriented(points);
  EXPECT_GT(orient_and_smooth(cloud, options, progress).denoising.moved, 7000);
  ASSERT_GE(fractions.size(), 2u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  const auto within_the_second_half = [](double f) { return f >= 0.45 && f < 0.99; };
  EXPECT_TRUE(std::any_of(fractions.begin(), fractions.end(), within_the_second_half));
}

TEST(Denoising, ThreadsDoNotMatter) {
  const std::vector<Vec3> points = sample_noisy_shape(ShapeKind::double_torus, 5000, 4, 0.4);
  const auto with_threads = [&](int threads) {
    return tbb::task_arena(threads).execute([&] { return denoised(points); });
  };
  const PointCloud one = with_threads(1), two = with_threads(2);
  ASSERT_EQ(one.position.size(), two.position.size());
  EXPECT_EQ(
      0, std::memcmp(one.position.data(), two.position.data(), one.position.size() * sizeof(Vec3)));
  EXPECT_EQ(one.input_index, two.input_index);
  EXPECT_EQ(one.normal, two.normal);
  EXPECT_EQ(one.neighbour, two.neighbour);
  for (Index i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one.plane[i].point, two.plane[i].point);
    ASSERT_EQ(one.plane[i].normal, two.plane[i].normal);
  }
}

// What the smallest neighbourhoods leave of the noise on a plane, and what wide ones would lose of
// waves beside it.
TEST(Denoising, KeepsDetailThatIsMoreThanNoise) {
  std::vector<Vec3> points;
  Random random(10);
  constexpr int kSide = 80;  // of a slab with waves on one half of its top
  const double noise = 0.25, wave = 10.0, height = 0.5;
  const auto top = [&](double x) {
    return x < kSide / 2.0 ? 0.0 : height * std::sin(2.0 * 3.14159265358979 * x / wave);
  };
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = kSide * random.uniform(), y = kSide * random.uniform();
    points.emplace_back(x, y, top(x) + noise * random.gaussian());
    points.emplace_back(kSide * random.uniform(), kSide * random.uniform(),
                        -20.0 + noise * random.gaussian());
  }
  const auto errors = [&](const PointCloud& cloud) {
    std::array<double, 2> sum{}, count{};  // on the plane, on the waves
    for (Index i = 0; i < cloud.size(); ++i) {
      const Vec3 p = cloud.frame.to_input(cloud.position[i]);
      const auto margin = [](double from_border) { return from_border < 8.0; };
      if (p.z() < -10.0 || margin(p.y()) || margin(kSide - p.y()) || margin(p.x()) ||
          margin(kSide - p.x()) || margin(std::abs(p.x() - kSide / 2.0)))
        continue;
      const std::size_t half = p.x() < kSide / 2.0 ? 0 : 1;
      sum[half] += std::abs(p.z() - top(p.x()));
      count[half] += 1.0;
    }
    return std::array<double, 2>{sum[0] / count[0], sum[1] / count[1]};
  };
  DenoisingOptions smallest;
  smallest.sizes = 1;
  const auto is = errors(denoised(points)), rough = errors(denoised(points, smallest));
  EXPECT_LT(is[0], 0.5 * rough[0]) << "on the plane";
  EXPECT_LT(is[1], 0.9 * rough[1]) << "on the waves";
}

// The targets of vertices between denoised samples are on the sphere too: tangent planes are not.
TEST(Denoising, TargetsBetweenSamplesFollowTheCurvature) {
  PointCloud cloud = oriented(sample_shape_blue_noise(ShapeKind::sphere, 500, 5));
  const double spacing = cloud.frame.to_input_length(cloud.spacing);
  const auto mean_error = [&] {
    const TangentTarget targets(cloud);
    Random random(6);
    double sum = 0.0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 normal = random.direction();
      const Vec3 query = cloud.frame.to_unit(normal);
      const Vec3 point = targets.find(query, normal, query, kNone).point;
      sum += std::abs(cloud.frame.to_input(point).norm() - 1.0) / (300.0 * spacing);
    }
    return sum;
  };
  const double of_planes = mean_error();
  Progress silent;
  denoise(cloud, 0.0, 16, {}, silent);
  EXPECT_LT(mean_error(), 0.01);
  EXPECT_GT(of_planes, 0.015);
}

TEST(Denoising, FewSamplesStayWhereTheyAre) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1.5}};
  PointCloud cloud = oriented(points);
  Progress silent;
  denoise(cloud, 1.0, 16, {}, silent);
  ASSERT_EQ(cloud.size(), 5);
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_NEAR((cloud.frame.to_input(cloud.position[i]) - points[cloud.input_index[i]]).norm(),
                0.0, 1e-6);
}

// Their spacing is zero in single precision.
TEST(Denoising, SamplesMayBeAsNearAsDoublesCanBe) {
  std::vector<Vec3> points = sample_noisy_shape(ShapeKind::sphere, 500, 11, 0.3);
  for (int i = 0; i < 400; ++i) points.emplace_back(i * 1e-70, (i % 7) * 1e-70, (i % 3) * 1e-70);
  const PointCloud cloud = denoised(points);
  for (const Vec3& p : cloud.position) EXPECT_TRUE(p.allFinite());
}

Reconstruction reconstruct_with(const std::vector<Vec3>& points,
                                const ReconstructionOptions& options) {
  Progress silent;
  return reconstruct(points, options, silent);
}

double mean_distance(const Reconstruction& result, const Shape& shape) {
  double sum = 0.0;
  for (const Vec3& p : result.mesh.position) sum += std::abs(shape.implicit(p));
  return sum / static_cast<double>(result.mesh.position.size());
}

TEST(Denoising, IsForSurfacesAtWhichRunsStop) {
  for (const ShapeKind kind : {ShapeKind::torus, ShapeKind::box})
    for (const double noise : {0.0, 0.12}) {
      const Shape shape = shape_of(kind);
      SCOPED_TRACE(shape.name + " " + std::to_string(noise));
      const std::vector<Vec3> points = sample_noisy_shape(kind, 3000, 7, noise);
      ReconstructionOptions surface, never;
      never.denoising.from = 1e6;
      EXPECT_EQ(reconstruct_with(points, surface).mesh.triangles,
                reconstruct_with(points, never).mesh.triangles)
          << "a mesh through the samples needs it only where it has faults";
      surface.stop_at_parametric_surface = never.stop_at_parametric_surface = true;
      const double distance = mean_distance(reconstruct_with(points, surface), shape),
                   of_planes = mean_distance(reconstruct_with(points, never), shape);
      EXPECT_LT(distance, (noise > 0.0 ? 0.85 : 0.5) * of_planes);
    }
}

// Few samples on both sides of a plate: planes mix them up where quadrics do not.
TEST(Denoising, ParallelSheetsOfFewSamplesArePartedInASecondAttempt) {
  int taken = 0, with_extra = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Vec3> points = sample_shape(ShapeKind::thin_plate, 120, seed);
    const Reconstruction result = reconstruct_with(points, {});
    taken += result.smoothing.is_taken;
    EXPECT_EQ(result.report.self_intersecting_faces, 0);
    EXPECT_EQ(result.report.genus, 0);
    EXPECT_EQ(result.report.samples_matched, 120);
    with_extra += result.report.vertices_extra > 0;
  }
  EXPECT_GE(taken, 4);
  EXPECT_LE(with_extra, 4) << "whose sides face the same way, as those of an open sheet";
}

}  // namespace
