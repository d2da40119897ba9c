#include "samples/more_noise.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "orient_and_smooth.h"
#include "orientation/wide_normals.h"
#include "oriented_cloud.h"
#include "reconstruct.h"
#include "samples/noise.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// Along x: a third of the unit sphere, and two thirds.
constexpr double kNoisyFrom = 0.3, kMostlyNoisyFrom = -0.3;

bool is_noisy(const Vec3& p, double from = kNoisyFrom) {
  return p.x() > from;
}

// Noise of `of_cloud` spacings, and of `there` where x is more than `from`.
std::vector<Vec3> noisy_in_part(ShapeKind kind, Index count, double there, double of_cloud = 0.0,
                                double from = kNoisyFrom) {
  std::vector<Vec3> points = sample_shape(kind, count, 7);
  const PointCloud clean = prepared_cloud(points);
  const double spacing = clean.frame.to_input_length(clean.spacing);
  Random random(8);
  for (Vec3& p : points) {
    const double noise = (is_noisy(p, from) ? there : of_cloud) * spacing;
    for (int axis = 0; axis < 3; ++axis) p[axis] += noise * random.gaussian();
  }
  return points;
}

MoreNoise measure(PointCloud& cloud, const MoreNoiseOptions& options = {}) {
  Progress silent;
  return measure_more_noise(cloud, estimate_noise(cloud, {}, silent).median, options, silent);
}

Vec3 place(const PointCloud& cloud, Index i) {
  return cloud.frame.to_input(cloud.position[i]);
}

TEST(MoreNoise, IsFoundWhereItIs) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::blob, ShapeKind::torus})
    for (const double of_cloud : {0.0, 0.1}) {
      SCOPED_TRACE(shape_of(kind).name + " " + std::to_string(of_cloud));
      PointCloud cloud = oriented_cloud(noisy_in_part(kind, 8000, 0.4, of_cloud));
      const MoreNoise more = measure(cloud);
      Index noisy = 0, found = 0, wrong = 0;
      for (Index i = 0; i < cloud.size(); ++i) {
        const bool is_told = cloud.more_noise[i] > 0.0f;
        noisy += is_noisy(place(cloud, i));
        found += is_noisy(place(cloud, i)) && is_told;
        wrong += place(cloud, i).x() < kNoisyFrom - 0.2 && is_told;
      }
      EXPECT_GT(found, 0.9 * noisy);
      EXPECT_EQ(wrong, 0);
      EXPECT_NEAR(more.median, 0.38, 0.06);
      EXPECT_EQ(more.samples, std::count_if(cloud.more_noise.begin(), cloud.more_noise.end(),
                                            [](float n) { return n > 0.0f; }));
      EXPECT_DOUBLE_EQ(more.part, more.samples / 8000.0);
    }
}

// The noise of the cloud is then none of either part.
TEST(MoreNoise, IsFoundWhereMostOfTheCloudHasIt) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::torus})
    for (const double there : {0.2, 0.4, 0.8}) {
      SCOPED_TRACE(shape_of(kind).name + " " + std::to_string(there));
      const std::vector<Vec3> points = noisy_in_part(kind, 8000, there, 0.0, kMostlyNoisyFrom);
      const auto noisy = std::count_if(points.begin(), points.end(),
                                       [](const Vec3& p) { return is_noisy(p, kMostlyNoisyFrom); });
      PointCloud cloud = oriented_cloud(points);
      MoreNoiseOptions careless;
      careless.calm_times = 0.0;
      EXPECT_LT(measure(cloud, careless).part, 0.5);
      const MoreNoise more = measure(cloud);
      EXPECT_NEAR(more.part, noisy / 8000.0, 0.05);
      EXPECT_NEAR(more.median, 0.95 * there, 0.2 * there);
      EXPECT_LT(more.others, 0.03);
      Progress silent;
      NoiseEstimate noise = estimate_noise(cloud, {}, silent);
      EXPECT_EQ(noise.of_others(), noise.median);
      noise.more = more;
      EXPECT_EQ(noise.of_others(), more.others);
    }
}

TEST(MoreNoise, TheNoiseOfTheOthersIsTheCloudsUnlessItHasCalmParts) {
  Progress silent;
  PointCloud cloud = oriented_cloud(noisy_in_part(ShapeKind::sphere, 8000, 0.4, 0.1));
  const double noise = estimate_noise(cloud, {}, silent).median;
  EXPECT_GT(noise, 0.08);
  const MoreNoise more = measure(cloud);
  EXPECT_GT(more.part, 0.3);
  EXPECT_EQ(more.others, noise);
}

// The noise of the cloud alone would be too much to tell more.
TEST(MoreNoise, IsFoundWhereOnlyAFifthHasNone) {
  PointCloud cloud = oriented_cloud(noisy_in_part(ShapeKind::sphere, 8000, 0.8, 0.0, -0.5));
  Progress silent;
  EXPECT_GT(estimate_noise(cloud, {}, silent).median, 0.5);
  const MoreNoise more = measure(cloud);
  EXPECT_NEAR(more.part, 0.75, 0.05);
  EXPECT_LT(more.others, 0.03);
}

TEST(MoreNoise, OptionsOutOfRangeDoNoHarm) {
  PointCloud cloud = oriented_cloud(noisy_in_part(ShapeKind::sphere, 2000, 0.4));
  for (const double part : {-1.0, 0.0, 1.0, 2.0}) {
    MoreNoiseOptions options;
    options.calm_part = part;
    EXPECT_LT(measure(cloud, options).part, 0.5) << part;
  }
  MoreNoiseOptions options;
  options.from = 2.0;
  EXPECT_EQ(measure(cloud, options).samples, 0);
}

TEST(MoreNoise, ThereIsNoneWhereAllIsAlike) {
  for (const ShapeKind kind : all_shapes()) {
    SCOPED_TRACE(shape_of(kind).name);
    PointCloud clean = oriented_cloud(sample_shape(kind, 6000, 3));
    EXPECT_EQ(measure(clean).samples, 0);
    EXPECT_EQ(clean.more_noise, std::vector<float>(clean.more_noise.size(), 0.0f));
    if (kind == ShapeKind::bowl || kind == ShapeKind::thin_plate) continue;  // too thin for noise
    PointCloud noisy = oriented_cloud(sample_noisy_shape(kind, 6000, 4, 0.3));
    EXPECT_EQ(measure(noisy).samples, 0);
  }
}

// A plate with ribs three spacings wide and high: quadrics miss these by as much as noise.
std::vector<Vec3> ribbed_plate() {
  std::vector<Vec3> points;
  Random random(9);
  const auto add = [&](double x, double z) { points.emplace_back(x, 40.0 * random.uniform(), z); };
  for (int n = 0; n < 1600; ++n) add(20.0 * random.uniform() - 20.0, 0.0);  // flat half
  for (int rib = 0; rib < 4; ++rib)
    for (int n = 0; n < 110; ++n) {
      const double x = 5.0 * rib;
      add(x + 2.5 * random.uniform(), 2.5);
      add(x, 2.5 * random.uniform());
      add(x + 2.5, 2.5 * random.uniform());
      add(x + 2.5 + 2.5 * random.uniform(), 0.0);
    }
  return points;
}

TEST(MoreNoise, RibsAreNone) {
  PointCloud cloud = oriented_cloud(ribbed_plate());
  EXPECT_LT(measure(cloud).part, 0.01);
  MoreNoiseOptions careless;
  careless.least_roughness = 0.0;
  EXPECT_GT(measure(cloud, careless).part, 0.1);
}

TEST(MoreNoise, FewOrCoincidentSamplesTellNothing) {
  for (const Index count : {4, 5, 9, 17}) {
    PointCloud cloud = oriented_cloud(sample_noisy_shape(ShapeKind::sphere, count, 1, 0.2));
    EXPECT_EQ(measure(cloud).samples, 0) << count;
    EXPECT_EQ(cloud.more_noise.size(), cloud.position.size());
  }
  std::vector<Vec3> points = {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  for (int n = 1; n < 200; ++n) points.emplace_back(n * 1e-300, n * n * 1e-301, n % 7 * 1e-300);
  PointCloud cloud = oriented_cloud(points);
  EXPECT_EQ(measure(cloud).samples, 0);
}

TEST(MoreNoise, FewNeighboursTellOfItToo) {
  const std::vector<Vec3> points = noisy_in_part(ShapeKind::sphere, 8000, 0.4);
  for (const int neighbours : {6, 7, 10, 32}) {
    Progress silent;
    SampleOptions options;
    options.neighbours = neighbours;
    PointCloud cloud = prepare_samples(points, options, silent);
    orient_normals(cloud, {}, silent);
    const double part = measure(cloud).part;
    EXPECT_GT(part, 0.2) << neighbours;
    EXPECT_LT(part, 0.4) << neighbours;
  }
}

TEST(MoreNoise, ThreadsDoNotMatter) {
  PointCloud cloud = oriented_cloud(noisy_in_part(ShapeKind::blob, 6000, 0.4));
  PointCloud alone = cloud;
  measure(cloud);
  tbb::task_arena arena(1);
  arena.execute([&] { measure(alone); });
  EXPECT_EQ(cloud.more_noise, alone.more_noise);
}

TEST(WideNormals, AreBetterWhereThereIsNoiseAndTheSameElsewhere) {
  const Shape sphere = shape_of(ShapeKind::sphere);
  PointCloud cloud = oriented_cloud(noisy_in_part(ShapeKind::sphere, 8000, 0.5));
  measure(cloud);
  Progress silent;
  const std::vector<Vec3f> wide = wide_normals(cloud, silent);
  double was = 0.0, is = 0.0, count = 0.0, wrong = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    if (cloud.more_noise[i] == 0.0f) {
      EXPECT_EQ(wide[i], cloud.normal[i]);
      continue;
    }
    const Vec3f normal = sphere.normal(place(cloud, i)).cast<float>();
    was += 1.0 - cloud.normal[i].dot(normal);
    is += 1.0 - wide[i].dot(normal);
    wrong += wide[i].dot(normal) < 0.0f;
    count += 1.0;
  }
  EXPECT_GT(count, 2000.0);
  EXPECT_LT(is, 0.2 * was);
  EXPECT_LE(wrong, 0.002 * count) << "sides";
}

// Root mean square distances from the unit sphere, x spacing.
struct Distances {
  double noisy = 0.0, clean = 0.0;
};

Distances distances_of(const std::vector<Vec3>& positions, double spacing, double from) {
  Distances sum, count;
  for (const Vec3& p : positions) {
    if (std::abs(p.x() - from) < 0.1) continue;
    const double squared = std::pow((p.norm() - 1.0) / spacing, 2);
    (is_noisy(p, from) ? sum.noisy : sum.clean) += squared;
    (is_noisy(p, from) ? count.noisy : count.clean) += 1.0;
  }
  return {std::sqrt(sum.noisy / count.noisy), std::sqrt(sum.clean / count.clean)};
}

void expect_smooth_where_noisy(double from, double noisy_part) {
  const std::vector<Vec3> points = noisy_in_part(ShapeKind::sphere, 8000, 0.5, 0.0, from);
  const PointCloud raw = prepared_cloud(points);
  const double spacing = raw.frame.to_input_length(raw.spacing);
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  Progress silent;
  const Reconstruction result = reconstruct(points, options, silent);
  EXPECT_NEAR(result.noise.more.part, noisy_part, 0.03);
  const Distances of_surface = distances_of(result.mesh.position, spacing, from);
  EXPECT_LT(of_surface.noisy, 0.13) << "of a noise of 0.5";
  EXPECT_LT(of_surface.clean, 0.02);
  double folded = 0.0;
  for (const auto& t : result.mesh.triangles) {
    const Vec3 &a = result.mesh.position[t[0]], &b = result.mesh.position[t[1]],
               &c = result.mesh.position[t[2]];
    folded += (b - a).cross(c - a).normalized().dot((a + b + c).normalized()) < 0.8;
  }
  EXPECT_LT(folded / static_cast<double>(result.mesh.triangles.size()), 0.002);
}

TEST(MoreNoise, IsSmoothedAndTheRestStays) {
  expect_smooth_where_noisy(kNoisyFrom, 0.35);
}

TEST(MoreNoise, OfMostOfTheCloudIsSmoothedAndTheRestStays) {
  expect_smooth_where_noisy(kMostlyNoisyFrom, 0.65);
}

// Those samples stay where they are beside which clean ones do, if what these show counts there.
TEST(MoreNoise, IsSmoothedBesideWhatIsClean) {
  const std::vector<Vec3> points = noisy_in_part(ShapeKind::sphere, 8000, 0.5);
  PointCloud cloud = oriented_cloud(points);
  measure(cloud);
  const double spacing = cloud.frame.to_input_length(cloud.spacing);
  Progress silent;
  denoise(cloud, 0.0, 16, {}, silent);
  double sum = 0.0, count = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = place(cloud, i);
    if (!is_noisy(p) || p.x() > kNoisyFrom + 0.2) continue;
    sum += std::pow((p.norm() - 1.0) / spacing, 2);
    count += 1.0;
  }
  EXPECT_GT(count, 400.0);
  EXPECT_LT(std::sqrt(sum / count), 0.25) << "of a noise of 0.5";
}

TEST(MoreNoise, FollowsTheSamplesThroughDenoisingAndBack) {
  const std::vector<Vec3> points = noisy_in_part(ShapeKind::blob, 4000, 0.5);
  PointCloud cloud = oriented_cloud(points);
  measure(cloud);
  std::vector<float> by_point(points.size()), now(points.size());
  for (Index i = 0; i < cloud.size(); ++i) by_point[cloud.input_index[i]] = cloud.more_noise[i];
  Progress silent;
  const auto expect_the_same = [&] {
    ASSERT_EQ(cloud.more_noise.size(), points.size());
    for (Index i = 0; i < cloud.size(); ++i) now[cloud.input_index[i]] = cloud.more_noise[i];
    EXPECT_EQ(now, by_point);
  };
  denoise(cloud, 0.0, 16, {}, silent);
  expect_the_same();
  undo_denoising(cloud, points, 16, 14, silent);
  expect_the_same();
}

}  // namespace
