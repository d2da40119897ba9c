// Neighbours of samples on lines: more where they see across, no more where that is of no use.
#include "samples/scan_lines.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

#include "common/memory_estimate.h"
#include "expect_mesh.h"
#include "orientation/orientation.h"
#include "reconstruct.h"
#include "samples/outliers.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::icosphere;
using testing::Random;

// Rings around the tube of a torus, so many times as far apart as samples are along them.
std::vector<Vec3> rings_of_torus(int rings, double ratio) {
  constexpr double kTube = 0.4;
  Random random(3);
  std::vector<Vec3> points;
  const double step = 2.0 * kPi / rings;
  const int count = static_cast<int>(2.0 * kPi * kTube * ratio / step);
  for (int i = 0; i < rings; ++i) {
    const double u = i * step, phase = random.in_cube().x();
    for (int k = 0; k < count; ++k) {
      const double v = phase + 2.0 * kPi * k / count, radius = 1.0 + kTube * std::cos(v);
      points.emplace_back(radius * std::cos(u), radius * std::sin(u), kTube * std::sin(v));
    }
  }
  return points;
}

std::vector<Vec3> rod(const Vec3& foot, int rings, int around) {
  std::vector<Vec3> points;
  const double radius = 0.5 * around / kPi;
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * kPi * (k + 0.5 * (i % 2)) / around;
      points.push_back(foot + Vec3(radius * std::cos(angle), radius * std::sin(angle), i));
    }
  return points;
}

int neighbours_of(const std::vector<Vec3>& points, int neighbours = 16) {
  Progress silent;
  return neighbours_across_lines(points, VoxelSearch(points, silent), neighbours, {}, silent);
}

TEST(ScanLines, NeighboursReachTheLinesBeside) {
  EXPECT_EQ(neighbours_of(rings_of_torus(60, 1.0)), 16);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 3.0)), 16);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 6.0)), 32) << "some reach the lines beside, too few";
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 8.0)), 32);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 10.0)), 64);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 14.0)), 64);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 30.0)), 128);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 8.0), 32), 32);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 10.0), 20), 40);
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 42.0)), 128) << "the most, though few reach";
}

TEST(ScanLines, FewNeighboursAreEnoughOnASphere) {
  const std::vector<Vec3> points = icosphere(2).position;
  for (int neighbours = 4; neighbours <= 8; ++neighbours)
    EXPECT_EQ(neighbours_of(points, neighbours), neighbours);
  for (int neighbours = 1; neighbours < 4; ++neighbours)
    EXPECT_GE(neighbours_of(points, neighbours), neighbours) << "two or three are always a line";
}

TEST(ScanLines, NoMoreNeighboursWhereTheyDoNotHelp) {
  EXPECT_EQ(neighbours_of(rings_of_torus(48, 100.0)), 16) << "more than the most";
  EXPECT_EQ(neighbours_of(rod(Vec3::Zero(), 1000, 3)), 16) << "a wire";
  EXPECT_EQ(neighbours_of(icosphere(4).position), 16);
  EXPECT_EQ(neighbours_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 1}}), 16);
}

TEST(ScanLines, WiresSideBySideAreNoSurface) {
  std::vector<Vec3> bundle;
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      for (const Vec3& p : rod(Vec3(2.5 * x, 2.5 * y, 0), 12, 3)) bundle.push_back(p);
  EXPECT_EQ(neighbours_of(bundle), 16);
}

TEST(ScanLines, AreReconstructed) {
  for (const double ratio : {8.0, 20.0}) {
    SCOPED_TRACE(ratio);
    const std::vector<Vec3> points = rings_of_torus(40, ratio);
    const ReconstructionOptions options;
    Progress silent({}, stages_of(options));
    const Reconstruction result = reconstruct(points, options, silent);
    EXPECT_GT(result.conditioning.neighbours_across_lines, 16);
    EXPECT_EQ(result.report.components, 1);
    EXPECT_EQ(result.report.genus, 1);
    EXPECT_EQ(result.report.self_intersecting_faces, 0);
    EXPECT_EQ(result.report.vertices_extra, 0);
  }
}

PointCloud prepared(const std::vector<Vec3>& points) {
  Progress silent;
  return prepare_samples(points, {}, silent);
}

// A line by itself says little of its sides.
TEST(ScanLines, SidesAreComparedFromLineToLine) {
  for (const double ratio : {6.0, 10.0, 20.0})
    for (const int asked_for : {16, 24, 64, 128}) {
      SCOPED_TRACE(ratio);
      SCOPED_TRACE(asked_for);
      SampleOptions options;
      options.neighbours = asked_for;
      Progress silent;
      PointCloud cloud = prepare_samples(rings_of_torus(48, ratio), options, silent);
      EXPECT_TRUE(cloud.conditioning.on_lines);
      EXPECT_GE(cloud.neighbour_count, asked_for);
      EXPECT_EQ(orient_normals(cloud, {}, silent).components, 1);
    }
}

// The line at the tip of a cone is short, and the next one is as far away as all lines are.
TEST(ScanLines, ShortLinesAreNotStray) {
  for (const double ratio : {6.0, 10.0, 14.0, 20.0}) {
    SCOPED_TRACE(ratio);
    constexpr int kAround = 20, kLines = 24;
    constexpr double kTip = 0.5 * kAround / kPi;  // radius of the first line; samples are 1 apart
    const auto ring = [](double radius, double z) {
      std::vector<Vec3> points;
      const int count = static_cast<int>(2.0 * kPi * radius);
      for (int k = 0; k < count; ++k) {
        const double angle = 2.0 * kPi * k / count;
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
      return points;
    };
    std::vector<Vec3> points = ring(kTip, 0.0);
    const std::size_t of_tip = points.size();
    for (int line = 1; line < kLines; ++line)
      for (const Vec3& p : ring(kTip + 0.7 * ratio * line, -0.7 * ratio * line))
        points.push_back(p);
    Progress silent;
    EXPECT_TRUE(find_outliers(prepared(points), {}, silent).empty());

    for (std::size_t i = 0; i < of_tip; ++i) points[i].z() += 6.0 * ratio;
    EXPECT_EQ(find_outliers(prepared(points), {}, silent).size(), of_tip) << "it floats";
  }
}

TEST(ScanLines, SameForAnyNumberOfThreads) {
  const std::vector<Vec3> points = rings_of_torus(48, 10.0);
  const int both = neighbours_of(points);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(neighbours_of(points), both);
}

TEST(ScanLines, MoreNeighboursMustFitIntoMemory) {
  const std::vector<Vec3> points = rings_of_torus(48, 8.0);
  Progress silent;
  SampleOptions options;
  const PointCloud cloud = prepare_samples(points, options, silent);
  ASSERT_GT(cloud.neighbour_count, options.neighbours);
  const auto samples = static_cast<std::uint64_t>(cloud.size());
  options.memory_limit = estimated_peak_bytes(samples, options.neighbours);
  EXPECT_THROW(prepare_samples(points, options, silent), InvalidInput);
  options.memory_limit = estimated_peak_bytes(samples, cloud.neighbour_count);
  EXPECT_NO_THROW(prepare_samples(points, options, silent));
}

}  // namespace
}  // namespace shrinkwrap
