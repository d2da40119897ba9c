#include "orientation/pole_normals.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "initial_mesh/initial_mesh.h"
#include "orientation/neighbour_graph.h"
#include "orientation/orientation.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

PointCloud prepared(const std::vector<Vec3>& points) {
  Progress silent;
  return prepare_samples(points, {}, silent);
}

Index fit(PointCloud& cloud, const PoleNormalOptions& options = {}, double noise = 0.0) {
  Progress silent;
  return fit_pole_normals(cloud, noise, options, silent);
}

// A limb along z: rings of eight samples, about one unit apart on the ring, each turned against the
// ring before, and nearly twice as far apart. Closed by a sample at either end.
constexpr double kLimbRadius = 1.3;
std::vector<Vec3> limb(int rings, double apart) {
  std::vector<Vec3> points;
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < 8; ++k) {
      const double angle = (k + 0.3 * ring) * kPi / 4.0;
      points.emplace_back(kLimbRadius * std::cos(angle), kLimbRadius * std::sin(angle),
                          apart * ring);
    }
  points.emplace_back(0.0, 0.0, -0.5 * apart);
  points.emplace_back(0.0, 0.0, (rings - 0.5) * apart);
  return points;
}

// Part of the samples along a limb whose normals are 45 degrees off, or, if signs count, more.
double part_off(const PointCloud& cloud, double length, bool with_signs) {
  double off = 0.0, samples = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    if (p.z() < 0.1 * length || p.z() > 0.9 * length) continue;
    const double cosine = Vec3(p.x(), p.y(), 0.0).normalized().dot(cloud.normal[i].cast<double>());
    off += (with_signs ? cosine : std::abs(cosine)) < 0.7071;
    ++samples;
  }
  return off / samples;
}

TEST(PoleNormals, OfALimbOfRingsLookAwayFromIt) {
  for (const double apart : {1.7, 1.9, 2.1}) {
    SCOPED_TRACE(apart);
    constexpr int kRings = 30;
    const std::vector<Vec3> points = limb(kRings, apart);
    const double length = apart * kRings;
    PointCloud cloud = prepared(points), as_it_was = cloud;
    EXPECT_EQ(part_off(cloud, length, false), 1.0);
    OrientationOptions without;
    without.poles.least_deviation = INFINITY;
    Progress silent;
    EXPECT_EQ(orient_normals(as_it_was, without, silent).poled, 0);
    EXPECT_EQ(part_off(as_it_was, length, false), 1.0);

    EXPECT_GT(orient_normals(cloud, {}, silent).poled, 7 * kRings)
        << "that normals are wrong is not to pass for noise";
    EXPECT_EQ(part_off(cloud, length, true), 0.0);
    const InitialMeshReport solid = make_initial_mesh(cloud, {}, silent).report;
    EXPECT_EQ(solid.components, 1);
    EXPECT_EQ(solid.genus, 0);
    EXPECT_GT(solid.samples_with_solid_behind, 0.99);
  }
}

// Neighbours on both sides of a sample, all on one lattice: planes through three of them hold the
// sample as well.
TEST(PoleNormals, OfARodOnALattice) {
  std::vector<Vec3> points;
  constexpr int kRings = 40;
  constexpr double kApart = 2.1;
  for (int ring = 0; ring < kRings; ++ring)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y) {
        const bool is_end = ring == 0 || ring == kRings - 1;
        if (x != 0 || y != 0 || is_end) points.emplace_back(x, y, kApart * ring);
      }
  PointCloud cloud = prepared(points);
  const double length = kApart * kRings;
  EXPECT_GT(part_off(cloud, length, false), 0.9);
  fit(cloud);
  EXPECT_LT(part_off(cloud, length, false), 0.06);
}

// The ball through a corner of a tetrahedron that touches the others from the far side is as large
// as can be if its centre lies on the axis: none holds them all.
TEST(PoleNormals, OfACornerLieOnItsAxis) {
  std::vector<Vec3> points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  PointCloud cloud = prepared(points);
  for (Index i = 0; i < cloud.size(); ++i)
    cloud.normal[i] = cloud.position[i].unitOrthogonal().cast<float>();
  PoleNormalOptions any;
  any.least_deviation = any.least_ratio = any.least_ratio_to_face = 0.0;
  EXPECT_EQ(fit(cloud, any), 4);
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_NEAR(cloud.normal[i].dot(cloud.position[i].normalized().cast<float>()), 1.0, 1e-6);
}

// The largest ball of a sample in a stack of sheets lies between the samples of the next.
TEST(PoleNormals, SheetsOnTopOfEachOtherKeepTheirs) {
  constexpr double kWidth = 24.0;
  Random random(1);
  std::vector<Vec3> points;
  for (int sheet = 0; sheet < 5; ++sheet)
    for (int i = 0; i < static_cast<int>(kWidth * kWidth); ++i)
      points.emplace_back(random.uniform(0.0, kWidth), random.uniform(0.0, kWidth), 1.6 * sheet);
  const auto askew_after = [&](const PoleNormalOptions& options) {
    PointCloud cloud = prepared(points);
    fit(cloud, options);
    double askew = 0.0, inner = 0.0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const Vec3 p = cloud.frame.to_input(cloud.position[i]);
      if (std::max(std::abs(p.x() - 0.5 * kWidth), std::abs(p.y() - 0.5 * kWidth)) > 9.0) continue;
      ++inner;
      askew += std::abs(cloud.normal[i].z()) < 0.866f;
    }
    return askew / inner;
  };
  PoleNormalOptions none, any;
  none.least_deviation = INFINITY;
  any.least_ratio = any.least_ratio_to_face = 0.0;
  const double before = askew_after(none);
  EXPECT_LT(before, 0.01);
  EXPECT_LT(askew_after({}), before + 0.005);
  EXPECT_GT(askew_after(any), before + 0.2);
}

TEST(PoleNormals, WhatIsOnePlaneOrNearlyThePoleStays) {
  PointCloud sphere = prepared(sample_shape(ShapeKind::sphere, 4000, 1));
  EXPECT_EQ(fit(sphere), 0);

  // At the edges of a box the pole lies between the faces, and the normal is to be that of one.
  const std::vector<Vec3> points = sample_shape(ShapeKind::box, 6000, 1);
  PointCloud box = prepared(points), again = prepared(points);
  PoleNormalOptions any;
  any.most_cosine = 1.0;
  EXPECT_LT(30 * fit(box), box.size());
  EXPECT_GT(15 * fit(again, any), again.size());
}

// The balls beyond the rim may be of any size, and those along the normals nearly so: by rounding.
TEST(PoleNormals, RimsOfSheetsKeepTheirs) {
  constexpr int kWidth = 30;
  const Eigen::AngleAxisd turn(0.7, Vec3(1.0, 2.0, 3.0).normalized());
  const Vec3f up = (turn * Vec3::UnitZ()).cast<float>();
  Random random(1);
  std::vector<Vec3> points;
  for (const double z : {0.0, 1.6})
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kWidth; ++y)
        points.push_back(turn *
                         Vec3(x + random.uniform(-0.2, 0.2), y + random.uniform(-0.2, 0.2), z));
  const auto askew_after = [&](double most_diameter) {
    PointCloud cloud = prepared(points);
    PoleNormalOptions options;
    options.most_diameter = most_diameter;
    fit(cloud, options);
    const auto askew =
        std::count_if(cloud.normal.begin(), cloud.normal.end(),
                      [&](const Vec3f& normal) { return std::abs(normal.dot(up)) < 0.7071f; });
    return static_cast<double>(askew) / cloud.size();
  };
  EXPECT_LT(askew_after(PoleNormalOptions().most_diameter), 0.004);
  EXPECT_GT(askew_after(INFINITY), 0.01);
}

TEST(PoleNormals, NoiseMakesFew) {
  Progress silent;
  const auto replaced_of = [&](double noise, const PoleNormalOptions& options) {
    PointCloud cloud = prepared(sample_noisy_shape(ShapeKind::blob, 6000, 1, noise));
    return fit(cloud, options, scatter_of_samples(cloud, silent));
  };
  PoleNormalOptions any;
  any.least_over_noise = 0.0;
  for (const double noise : {0.1, 0.25}) EXPECT_EQ(replaced_of(noise, {}), 0) << noise;
  for (const double noise : {0.5, 1.0}) {
    EXPECT_GT(replaced_of(noise, any), 60) << noise;
    EXPECT_LT(replaced_of(noise, {}), 20) << noise;
  }
}

TEST(PoleNormals, AreTheSameForAnyNumberOfThreads) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::thin_plate, 3000, 2);
  PointCloud cloud = prepared(points), again = cloud;
  EXPECT_GT(fit(cloud), 0);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  fit(again);
  EXPECT_TRUE(again.normal == cloud.normal);
}

TEST(PoleNormals, OfFewOrManyNeighbours) {
  for (const int neighbours : {-1, 0, 1, 2, 3, 4, 64, 1000}) {
    SCOPED_TRACE(neighbours);
    PointCloud cloud = prepared(limb(20, 1.9));
    PoleNormalOptions options;
    options.neighbours = neighbours;
    EXPECT_EQ(fit(cloud, options) > 0, neighbours > 3);
    for (const Vec3f& normal : cloud.normal) EXPECT_NEAR(normal.norm(), 1.0f, 1e-5f);
  }
}

// Neighbours that all lie on a line.
TEST(PoleNormals, OfWhatHasNoneStay) {
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(i, 0.0, 0.0);
  points.emplace_back(20.0, 400.0, 300.0);
  points.emplace_back(20.0, -400.0, 300.0);
  PointCloud cloud = prepared(points);
  PoleNormalOptions any;
  any.least_deviation = -1.0;
  any.least_over_noise = 0.0;
  any.most_cosine = 2.0;
  any.least_ratio = any.least_ratio_to_face = 0.0;
  const std::vector<Vec3f> before = cloud.normal;
  fit(cloud, any);
  for (Index i = 0; i < cloud.size(); ++i) {
    EXPECT_NEAR(cloud.normal[i].norm(), 1.0f, 1e-5f);
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    if (p.y() == 0.0) {
      EXPECT_EQ(cloud.normal[i], before[i]);
    }
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
