#include "samples/point_cloud.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::sample_shape;
using testing::ShapeKind;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

PointCloud prepare(const std::vector<Vec3>& points, int neighbours = 16) {
  Progress silent;
  SampleOptions options;
  options.neighbours = neighbours;
  return prepare_samples(points, options, silent);
}

std::vector<Vec3> tetrahedron() {
  return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

// Indices of the k nearest, the sample itself first, then by distance and index.
std::vector<Index> nearest_by_brute_force(const PointCloud& cloud, Index sample) {
  std::vector<std::pair<double, Index>> all;
  for (Index i = 0; i < cloud.size(); ++i)
    all.emplace_back(
        i == sample ? -1.0 : (cloud.position[i] - cloud.position[sample]).squaredNorm(), i);
  std::sort(all.begin(), all.end());
  std::vector<Index> nearest;
  for (int k = 0; k < cloud.neighbour_count; ++k) nearest.push_back(all[k].second);
  return nearest;
}

// Distances must agree up to single precision; indices may differ only between equal distances.
void expect_nearest_neighbours(const PointCloud& cloud, Index stride) {
  for (Index i = 0; i < cloud.size(); i += stride) {
    const std::vector<Index> expected = nearest_by_brute_force(cloud, i);
    ASSERT_EQ(cloud.neighbours_of(i)[0], i);
    const std::set<Index> distinct(cloud.neighbours_of(i),
                                   cloud.neighbours_of(i) + cloud.neighbour_count);
    ASSERT_EQ(distinct.size(), static_cast<std::size_t>(cloud.neighbour_count)) << "sample " << i;
    double last = 0.0;
    for (int k = 0; k < cloud.neighbour_count; ++k) {
      const auto distance = [&](Index j) { return (cloud.position[j] - cloud.position[i]).norm(); };
      const double found = distance(cloud.neighbours_of(i)[k]);
      ASSERT_NEAR(found, distance(expected[k]), 1e-5 * distance(expected.back()))
          << "sample " << i << " entry " << k;
      ASSERT_GE(found, last * (1.0 - 1e-5)) << "sample " << i << " entry " << k;
      last = found;
    }
  }
}

void expect_unit_normals(const PointCloud& cloud) {
  for (Index i = 0; i < cloud.size(); ++i)
    ASSERT_NEAR(cloud.normal[i].norm(), 1.0f, 1e-4f) << "sample " << i;
}

void expect_same(const PointCloud& a, const PointCloud& b) {
  EXPECT_TRUE(a.position == b.position);
  EXPECT_TRUE(a.input_index == b.input_index);
  EXPECT_TRUE(a.neighbour == b.neighbour);
  EXPECT_TRUE(a.local_spacing == b.local_spacing);
  EXPECT_TRUE(a.normal == b.normal);
  EXPECT_EQ(a.spacing, b.spacing);
}

TEST(UnitFrame, CentresTheBoxAndScalesByAPowerOfTwo) {
  const Frame frame = unit_frame({{10, 20, 30}, {14, 21, 30.5}});
  EXPECT_EQ(frame.center, Vec3(12, 20.5, 30.25));
  EXPECT_EQ(frame.scale, 0.5);  // half-extent 2 becomes 1
  EXPECT_EQ(frame.to_unit({14, 21, 30.5}), Vec3(1, 0.25, 0.125));
}

TEST(UnitFrame, HalfExtentIsAboveOneHalfAndAtMostOne) {
  for (double extent : {1e-300, 3e-7, 0.9999, 1.0, 1.0001, 2.0, 5e8, 1e308}) {
    const Frame frame = unit_frame({Vec3(0, 0, 0), Vec3(extent, 0, 0)});
    const double half = 0.5 * extent * frame.scale;
    EXPECT_GT(half, 0.5) << extent;
    EXPECT_LE(half, 1.0) << extent;
  }
}

TEST(UnitFrame, RoundsNothing) {
  std::mt19937 random(8);
  for (double offset : {0.0, 0.3, 0.9, 1.1, 2.9, 3.1, 50.0, -3.1, -1e4, 5.4e6, 1e12})
    for (double scale : {1.0, 1e-9, 3e11}) {
      std::uniform_real_distribution<double> uniform(offset - 1.0, offset + 1.0);
      std::vector<Vec3> points;
      for (int i = 0; i < 1000; ++i)
        points.push_back(scale * Vec3(uniform(random), -uniform(random), 0.2 * uniform(random)));
      const Frame frame = unit_frame(points);
      for (const Vec3& p : points) {
        const Vec3 unit = frame.to_unit(p);
        // In long doubles the sum is exact if both of its parts are known to the last bit.
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_EQ(static_cast<long double>(unit[axis]) / frame.scale +
                        static_cast<long double>(frame.center[axis]),
                    static_cast<long double>(p[axis]))
              << offset << " x " << scale;
        ASSERT_LE(unit.cwiseAbs().maxCoeff(), 3.0);
      }
    }
}

TEST(UnitFrame, SurvivesExtremes) {
  const double largest = std::numeric_limits<double>::max();
  const Frame huge = unit_frame({Vec3::Constant(-largest), Vec3::Constant(largest)});
  EXPECT_TRUE(huge.center.allFinite());
  EXPECT_LE(huge.to_unit(Vec3::Constant(largest)).maxCoeff(), 1.0);
  const Frame point = unit_frame({Vec3(1, 2, 3)});
  EXPECT_EQ(point.to_unit(Vec3(1, 2, 3)), Vec3(0, 0, 0));
  EXPECT_EQ(unit_frame({}).scale, 1.0);
}

TEST(UnitFrame, RoundTripOfFloatsIsExact) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(1000.0f, 1001.0f);
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i)
    points.push_back(Vec3f(uniform(random), uniform(random), uniform(random)).cast<double>());
  const Frame frame = unit_frame(points);
  for (const Vec3& p : points) EXPECT_EQ(frame.to_input(frame.to_unit(p)), p);
}

TEST(PrepareSamples, ReportsWhatItLeavesOut) {
  std::vector<Vec3> points = tetrahedron();
  points.push_back({kNan, 0, 0});
  points.push_back({0, -kInfinity, 0});
  points.push_back({1, 0, 0});        // duplicate
  points.push_back({-0.0, 0, -0.0});  // duplicate too
  const PointCloud cloud = prepare(points);
  EXPECT_EQ(cloud.conditioning.given, 8u);
  EXPECT_EQ(cloud.conditioning.not_finite, 2u);
  EXPECT_EQ(cloud.conditioning.duplicates, 2u);
  EXPECT_EQ(cloud.conditioning.distinct, 4u);
  std::vector<Index> kept = cloud.input_index;
  std::sort(kept.begin(), kept.end());
  EXPECT_EQ(kept, (std::vector<Index>{0, 1, 2, 3}));  // the first of each
}

TEST(PrepareSamples, KeepsDistinctPointsThatTheUnitFrameCannotTellApart) {
  std::vector<Vec3> points = {{0, 0, 0}, {1e30, 0, 0}, {0, 1e30, 0}, {0, 0, 1e30}};
  for (int i = 0; i < 50; ++i) points.push_back({1.0 + i % 25, 0, 0});
  const PointCloud cloud = prepare(points);
  EXPECT_EQ(cloud.conditioning.duplicates, 25u);
  EXPECT_EQ(cloud.size(), 29);
  std::vector<Index> kept = cloud.input_index;
  std::sort(kept.begin(), kept.end());
  EXPECT_EQ(kept.back(), 28);  // of equal points the first stays
  for (Index i = 0; i < cloud.size(); ++i) EXPECT_EQ(cloud.neighbours_of(i)[0], i);
  for (float spacing : cloud.local_spacing) EXPECT_GT(spacing, 0.0f);
  EXPECT_GT(cloud.spacing, 0.0);
  expect_unit_normals(cloud);
}

TEST(PrepareSamples, PositionsAreTheInputInTheUnitFrame) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::torus, 2000, 11);
  const PointCloud cloud = prepare(points);
  ASSERT_EQ(cloud.size(), 2000);
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(cloud.position[i], cloud.frame.to_unit(points[cloud.input_index[i]]));
}

TEST(PrepareSamples, RefusesTooFewPointsAndSaysWhy) {
  for (std::size_t count = 0; count < 4; ++count) {
    std::vector<Vec3> points = tetrahedron();
    points.resize(count);
    points.push_back({kNan, kNan, kNan});
    try {
      prepare(points);
      FAIL() << count << " points were accepted";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("4 distinct points"), std::string::npos);
    }
  }
}

TEST(PrepareSamples, RefusesLinesAndPlanes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Vec3 u = Vec3(1, 2, 3).normalized(), v = Vec3(3, -1, 2).normalized();
  for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1000, -2000, 500)}) {
    std::vector<Vec3> line, plane, plane_of_floats, thin;
    for (int i = 0; i < 500; ++i) {
      const double a = uniform(random), b = uniform(random);
      line.push_back(offset + a * u);
      plane.push_back(offset + a * u + b * v);
      const Vec3f in_floats = offset.cast<float>() + static_cast<float>(a) * u.cast<float>() +
                              static_cast<float>(b) * v.cast<float>();
      plane_of_floats.push_back(in_floats.cast<double>());
      thin.push_back(plane.back() + 1e-3 * uniform(random) * u.cross(v));
    }
    EXPECT_THROW(prepare(line), InvalidInput);
    EXPECT_THROW(prepare(plane), InvalidInput);
    EXPECT_THROW(prepare(plane_of_floats), InvalidInput);
    EXPECT_NO_THROW(prepare(thin));
  }
}

// Rounding moves points along the axes on which their coordinates are large, and no others.
TEST(PrepareSamples, LevelGroundFarNorthIsNotFlat) {
  std::vector<Vec3> ground, flat, whole_numbers;
  for (const Vec3& p : sample_shape(ShapeKind::box, 2000, 4)) {
    const double x = 4e5 + 500.0 * p.x(), y = 5.5e6 + 500.0 * p.y();
    const double relief = 0.3 * std::sin(7.0 * p.x()) * std::cos(5.0 * p.y());
    ground.push_back(rounded_to_single({x, y, 100.0 + relief}));
    flat.push_back(rounded_to_single({x, y, 100.0 + 1e-5 * p.z()}));
    whole_numbers.emplace_back(std::round(x), std::round(y), p.z() > 0.0 ? 1.0 : 0.0);
  }
  EXPECT_NO_THROW(prepare(ground));
  EXPECT_NO_THROW(prepare(whole_numbers));
  EXPECT_THROW(prepare(flat), InvalidInput);
}

TEST(PrepareSamples, RefusesTooFewNeighbours) {
  EXPECT_THROW(prepare(tetrahedron(), 3), InvalidInput);
}

TEST(PrepareSamples, FourPointsAreEnough) {
  const PointCloud cloud = prepare(tetrahedron());
  EXPECT_EQ(cloud.neighbour_count, 4);
  expect_nearest_neighbours(cloud, 1);
  expect_unit_normals(cloud);
}

TEST(PrepareSamples, FindsTheNearestNeighboursOfShapes) {
  for (ShapeKind kind : {ShapeKind::sphere, ShapeKind::box, ShapeKind::thin_plate})
    for (int neighbours : {4, 16, 37})
      expect_nearest_neighbours(prepare(sample_shape(kind, 3000, 5), neighbours), 7);
}

TEST(PrepareSamples, FindsTheNearestNeighboursOnAGridWithItsTies) {
  std::vector<Vec3> points;
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      for (int z = 0; z < 12; ++z) points.emplace_back(x, y, z);
  expect_nearest_neighbours(prepare(points), 5);
}

TEST(PrepareSamples, FindsTheNearestNeighboursWhateverTheDensity) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points;
    for (double spread : {1.0, 1e-2, 1e-4, 1e-7})  // clusters within clusters
      for (int i = 0; i < 700; ++i)
        points.push_back(Vec3(0.3, 0.2, 0.1) +
                         spread * Vec3(normal(random), normal(random), normal(random)));
    for (int line = 0; line < 20; ++line)  // scan lines: 1 to 200
      for (int i = 0; i < 100; ++i) points.emplace_back(0.1 * line, 5.0, 5e-4 * i);
    points.emplace_back(50, 50, 50);
    expect_nearest_neighbours(prepare(points), 11);
  }
}

TEST(PrepareSamples, NormalsAreThoseOfTheSphere) {
  const PointCloud cloud = prepare(sample_shape(ShapeKind::sphere, 5000, 9));
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_GT(std::abs(cloud.normal[i].dot(cloud.position[i].cast<float>().normalized())), 0.98f);
}

TEST(PrepareSamples, SpacingIsThatOfARegularGrid) {
  std::vector<Vec3> points;
  const int side = 60;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y) points.emplace_back(x, y, x == 0 && y == 0 ? 5.0 : 0.0);
  const PointCloud cloud = prepare(points);
  EXPECT_NEAR(cloud.frame.to_input_length(cloud.spacing), 1.0, 0.15);
}

// Along the rim of a scan, half of the neighbours are missing.
TEST(PrepareSamples, SpacingBesideIsNotThatOfTheRim) {
  const PointCloud cloud = prepare(sample_shape_blue_noise(ShapeKind::hemisphere, 4000, 3));
  double at = 0.0, beside = 0.0, inside = 0.0;  // means, x the median
  Index rim = 0;
  for (Index i = 0; i < cloud.size(); ++i) {
    EXPECT_GE(cloud.spacing_beside(i), cloud.spacing);
    EXPECT_LE(cloud.spacing_beside(i), cloud.spacing_at(i));
    const bool is_at_rim = std::abs(cloud.frame.to_input(cloud.position[i]).z()) <
                           0.5 * cloud.frame.to_input_length(cloud.spacing);
    rim += is_at_rim;
    (is_at_rim ? beside : inside) += cloud.spacing_beside(i) / cloud.spacing;
    if (is_at_rim) at += cloud.spacing_at(i) / cloud.spacing;
  }
  ASSERT_GT(rim, 30);
  EXPECT_GT(at / rim, 1.25);
  EXPECT_LT(beside / rim, 1.15);
  EXPECT_LT(inside / (cloud.size() - rim), 1.05);
}

TEST(PrepareSamples, GivesTheSameBytesForAnyNumberOfThreads) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::double_torus, 20000, 21);
  const PointCloud many = prepare(points);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  expect_same(many, prepare(points));
}

TEST(PrepareSamples, DoesNotDependOnTheOrderOfTheInput) {
  std::vector<Vec3> points = sample_shape(ShapeKind::bowl, 5000, 2);
  const PointCloud before = prepare(points);
  std::shuffle(points.begin(), points.end(), std::mt19937(4));
  const PointCloud after = prepare(points);
  EXPECT_TRUE(before.position == after.position);
  EXPECT_TRUE(before.neighbour == after.neighbour);
}

TEST(PrepareSamples, CanBeCancelled) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 1000, 1);
  Progress progress([](double, const char*) { return false; }, {Stage::samples});
  EXPECT_THROW(prepare_samples(points, SampleOptions(), progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
