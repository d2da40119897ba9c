#include "samples/parallel_sheets.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <utility>

#include "samples/point_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// Two squares of random samples, one unit apart in the mean, facing each other at a distance.
std::vector<Vec3> two_sheets(double distance, double noise, unsigned seed) {
  constexpr double kWidth = 40.0;
  Random random(seed);
  std::vector<Vec3> points;
  for (const double z : {0.0, distance})
    for (int i = 0; i < static_cast<int>(kWidth * kWidth); ++i)
      points.emplace_back(random.uniform(0.0, kWidth), random.uniform(0.0, kWidth),
                          z + noise * random.gaussian());
  return points;
}

struct Normals {
  double askew_before = 0.0, askew = 0.0;  // parts of the samples that are 30 degrees off
  double mean_sine = 0.0;                  // of the angle they are off
  double replaced = 0.0;
};

template <class TrueNormal>
Normals normals_of(const std::vector<Vec3>& points, const TrueNormal& true_normal,
                   int neighbours = SampleOptions::kUsualNeighbours) {
  Progress silent;
  SampleOptions options;
  options.neighbours = neighbours;
  const PointCloud cloud = prepare_samples(points, options, silent);
  const auto part_askew = [&](const std::vector<Vec3f>& normals) {
    double count = 0.0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const Vec3 normal = true_normal(cloud.frame.to_input(cloud.position[i]));
      count += std::abs(normal.dot(normals[i].cast<double>())) < 0.866;
    }
    return count / cloud.size();
  };
  Neighbourhoods around =
      find_neighbourhoods(cloud.position, cloud.search, cloud.neighbour_count, silent);
  Normals result;
  result.askew_before = part_askew(around.normal);
  const Index replaced =
      fit_parallel_sheets(cloud.position, around, ParallelSheetsOptions(), silent);
  result.replaced = static_cast<double>(replaced) / cloud.size();
  result.askew = part_askew(around.normal);
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = true_normal(cloud.frame.to_input(cloud.position[i]));
    result.mean_sine += normal.cross(around.normal[i].cast<double>()).norm() / cloud.size();
  }
  EXPECT_TRUE(around.normal == cloud.normal) << "samples are prepared with them";
  return result;
}

Vec3 up(const Vec3&) {
  return Vec3::UnitZ();
}

TEST(ParallelSheets, WallsAsThickAsNeighbourhoodsAreWide) {
  for (const auto& [distance, most] : {std::pair(1.2, 0.03), {1.5, 0.015}, {1.8, 0.008}}) {
    SCOPED_TRACE(distance);
    const Normals normals = normals_of(two_sheets(distance, 0.0, 1), up);
    EXPECT_GT(normals.askew_before, 0.4);
    EXPECT_LT(normals.askew, most);
    EXPECT_GT(normals.replaced, 0.7);
  }
}

// Of more neighbours than are looked at, sheets are as far apart in spacings as of fewer.
TEST(ParallelSheets, AmongManyNeighbours) {
  const Normals normals = normals_of(two_sheets(0.9, 0.0, 1), up, 128);
  EXPECT_GT(normals.replaced, 0.7);
}

TEST(ParallelSheets, WithSomeNoise) {
  const Normals normals = normals_of(two_sheets(1.5, 0.08, 2), up);
  EXPECT_GT(normals.askew_before, 0.5);
  EXPECT_LT(normals.askew, 0.09);
  EXPECT_LT(normals.mean_sine, 0.145);
}

// The fourth sheet of a stack, or a few samples of it, may be among the neighbours.
TEST(ParallelSheets, InStacks) {
  std::vector<Vec3> points = two_sheets(1.6, 0.0, 7);
  for (const Vec3& p : two_sheets(1.6, 0.0, 8)) points.push_back(p + Vec3(0.0, 0.0, 3.2));
  const Normals normals = normals_of(points, up);
  EXPECT_GT(normals.askew_before, 0.4);
  EXPECT_LT(normals.askew, 0.05);
}

TEST(ParallelSheets, NoiseIsNone) {
  SampleDefects defects;
  for (const double noise : {0.1, 0.5, 1.0, 2.0}) {
    defects.noise = noise;
    const std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 20000, 3, defects);
    EXPECT_LT(normals_of(points, up).replaced, 2.5e-3) << noise;
  }
}

// But for some samples near edges, whose neighbours on the other face have a gap between.
TEST(ParallelSheets, BendsAndEdgesAreNone) {
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::double_torus, ShapeKind::blob}) {
    const Shape shape = shape_of(kind);
    const Normals normals =
        normals_of(sample_shape(kind, 4000, 4), [&](const Vec3& p) { return shape.normal(p); });
    EXPECT_LT(normals.replaced, kind == ShapeKind::box ? 0.015 : 2e-3) << shape.name;
    EXPECT_LT(normals.askew, normals.askew_before + 1e-3) << shape.name;
  }
}

// Whether the first of these points, all of which are its neighbours, is of a sheet beside others.
bool has_sheets_beside(const std::vector<Vec3>& points) {
  const auto count = static_cast<Index>(points.size());
  Neighbourhoods around;
  around.k = count;
  around.radius.assign(points.size(), 2.5f);
  around.normal.assign(points.size(), Vec3f::UnitX());
  around.deviation.assign(points.size(), 0.0f);
  around.deviation[0] = 0.9f;  // the others are not looked at
  for (Index point = 0; point < count; ++point)
    for (Index k = 0; k < count; ++k) around.neighbour.push_back(k);
  Progress silent;
  const Index replaced = fit_parallel_sheets(points, around, ParallelSheetsOptions(), silent);
  if (replaced > 0) {
    EXPECT_GT(std::abs(around.normal[0].z()), 0.999f);
  }
  return replaced == 1;
}

bool has_sheets_beside_plane(const std::vector<Vec3>& others) {
  std::vector<Vec3> points = {Vec3(1.0, 2.2, 0.0)};
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 3; ++y)
      if (x != 1 || y != 2) points.emplace_back(x, y + 0.2 * (x % 2), 0.0);
  points.insert(points.end(), others.begin(), others.end());
  return has_sheets_beside(points);
}

TEST(ParallelSheets, AreFlatAndApartAndAboveEachOther) {
  EXPECT_TRUE(has_sheets_beside_plane({{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}}));
  EXPECT_TRUE(has_sheets_beside_plane({{0, 0, 1.5}, {2, 1, 1.5}, {2, 2, -1.5}, {0, 2, -1.5}}))
      << "one between";
  EXPECT_FALSE(has_sheets_beside_plane({{0, 0, 0.7}, {2, 0, 0.7}, {2, 2, 0.7}, {0, 2, 0.7}}))
      << "too near";
  EXPECT_FALSE(has_sheets_beside_plane({{0, 0, 1.2}, {2, 0, 1.8}, {2, 2, 2.6}, {0, 2, 3.2}}))
      << "not flat";
  EXPECT_FALSE(has_sheets_beside_plane({{4, 0, 1.5}, {4, 1, 1.5}, {4, 2, 1.5}, {4, 3, 1.5}}))
      << "beyond an edge";
  EXPECT_FALSE(has_sheets_beside_plane({{0, 0, 0}, {2, 0.5, 0}, {2, 1.6, 0}, {1, 1, 1.5}}))
      << "one point";

  std::vector<Vec3> three = {{1.5, 1.5, 0.0}, {1.7, 1.5, 0.0}, {1.5, 1.7, 0.0}};
  for (int k = 0; k < 13; ++k)
    three.emplace_back(std::fmod(0.7 * k, 3.0), std::fmod(1.9 * k, 3.0), 2.2);
  EXPECT_FALSE(has_sheets_beside(three)) << "any three points lie on a plane";
  three.push_back({1.3, 1.5, 0.0});
  three.push_back({1.5, 1.3, 0.0});
  EXPECT_TRUE(has_sheets_beside(three));
}

// Two lines lie on a plane, and on any two parallel ones.
TEST(ParallelSheets, ScanLinesAreNone) {
  const Normals normals = normals_of(sample_sphere_on_scan_lines(4000, 5),
                                     [](const Vec3& p) -> Vec3 { return p.normalized(); });
  EXPECT_LT(normals.replaced, 2e-3);
  EXPECT_LT(normals.askew, normals.askew_before + 1e-3);
}

TEST(ParallelSheets, AreTheSameForAnyNumberOfThreads) {
  Progress silent;
  const std::vector<Vec3> points = two_sheets(1.5, 0.0, 6);
  const PointCloud cloud = prepare_samples(points, SampleOptions(), silent);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(cloud.normal == prepare_samples(points, SampleOptions(), silent).normal);
}

}  // namespace
}  // namespace shrinkwrap::testing
