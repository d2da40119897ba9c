#include "orientation/crease_planes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "initial_mesh/initial_mesh.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

OrientationOptions without_creases() {
  OrientationOptions options;
  options.most_noise_at_creases = -1.0;
  return options;
}

struct Cloud {
  PointCloud cloud;
  OrientationReport report;
};

Cloud oriented(const std::vector<Vec3>& points, const OrientationOptions& options = {}) {
  Progress silent;
  Cloud result;
  result.cloud = prepare_samples(points, {}, silent);
  result.report = orient_normals(result.cloud, options, silent);
  return result;
}

// Part of the samples of what has faces along the axes alone whose normals are 30 degrees off all.
double part_askew(const PointCloud& cloud) {
  const auto askew =
      std::count_if(cloud.normal.begin(), cloud.normal.end(),
                    [](const Vec3f& normal) { return normal.cwiseAbs().maxCoeff() < 0.866f; });
  return static_cast<double>(askew) / cloud.size();
}

// A block with slots, as wide as the walls between them.
double comb_distance(const Vec3& p) {
  constexpr double kWidth = 0.08;
  const double block = box_distance(p, {0.8, 0.5, 0.4});
  const double place = std::fmod(p.x() + 0.8 + 20.0 * kWidth, 2.0 * kWidth);
  const double slot = std::max(std::abs(place - kWidth) - 0.5 * kWidth, -0.2 - p.z());
  return std::max(block, -slot);
}

std::vector<Vec3> comb(Index samples, unsigned seed) {
  Random random(seed);
  return sample_implicit(comb_distance, {}, samples, random).points;
}

double part_wrong(const PointCloud& cloud) {
  double wrong = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = outward_normal(comb_distance, cloud.frame.to_input(cloud.position[i]));
    wrong += normal.dot(cloud.normal[i].cast<double>()) < -0.3;
  }
  return wrong / cloud.size();
}

TEST(CreasePlanes, AreThoseOfFaces) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::box, 6000, 1);
  const Cloud before = oriented(points, without_creases()), after = oriented(points);
  EXPECT_EQ(before.report.creased, 0);
  EXPECT_GT(part_askew(before.cloud), 0.05);
  EXPECT_LT(part_askew(after.cloud), 0.01);
  EXPECT_GT(after.report.creased, 600);
}

TEST(CreasePlanes, OfWallsAndSlotsOfTwoSpacings) {
  const std::vector<Vec3> points = comb(10000, 1);
  OrientationOptions without = without_creases(), with;
  without.poles.least_deviation = with.poles.least_deviation = INFINITY;
  const Cloud before = oriented(points, without), after = oriented(points, with);
  EXPECT_GT(part_askew(before.cloud), 0.12);
  EXPECT_LT(part_askew(after.cloud), 0.03);
  EXPECT_LT(part_wrong(after.cloud), 0.5 * part_wrong(before.cloud))
      << "a face has the side to which most of it looks";
  Progress silent;
  const auto genus_of = [&](const PointCloud& cloud) {
    return make_initial_mesh(cloud, {}, silent).report.genus;
  };
  const int genus = genus_of(after.cloud);
  EXPECT_LT(genus, 6);
  EXPECT_GT(genus_of(before.cloud), genus + 6);
}

TEST(CreasePlanes, WhatIsCurvedHasNone) {
  EXPECT_EQ(oriented(sample_shape(ShapeKind::sphere, 4000, 1)).report.creased, 0);

  // A rod as thin as a neighbourhood is wide: some of any strip along it lie on a plane.
  const auto rod_on_plate = [](const Vec3& p) {
    const double rod = std::max(length_of(p.x(), p.y()) - 0.06, std::abs(p.z() - 0.4) - 0.4);
    return std::min(box_distance(p, {0.5, 0.5, 0.1}), rod);
  };
  Random random(1);
  const std::vector<Vec3> points = sample_implicit(rod_on_plate, {}, 2500, random).points;
  EXPECT_GT(oriented(points).report.creased, 0);
  const auto mean_sine_on_rod = [&](const OrientationOptions& options) {
    const PointCloud cloud = oriented(points, options).cloud;
    double sines = 0.0, samples = 0.0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const Vec3 p = cloud.frame.to_input(cloud.position[i]);
      if (p.z() < 0.2 || p.z() > 0.7) continue;
      const Vec3f away = Vec3(p.x(), p.y(), 0.0).normalized().cast<float>();
      sines += away.cross(cloud.normal[i]).norm();
      ++samples;
    }
    return sines / samples;
  };
  EXPECT_LT(mean_sine_on_rod({}), mean_sine_on_rod(without_creases()) + 0.03)
      << "few that happen to lie on a plane make no face";
}

TEST(CreasePlanes, WhatIsThatOfAFaceStays) {
  const Cloud plate = oriented(sample_shape(ShapeKind::thin_plate, 1000, 1));
  EXPECT_GT(plate.report.creased, 0);
  EXPECT_LT(plate.report.creased, plate.cloud.size() / 2) << "but at its rim";
}

TEST(CreasePlanes, NoisyCloudsHaveNone) {
  EXPECT_EQ(oriented(sample_noisy_shape(ShapeKind::box, 6000, 1, 0.15)).report.creased, 0);
}

TEST(CreasePlanes, LittleDeviationIsOneFace) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::blob, 6000, 1);
  OrientationOptions any;
  any.creases.least_deviation = 0.0;
  EXPECT_GT(oriented(points, any).report.creased, oriented(points).report.creased + 60);
}

TEST(CreasePlanes, AreTheSameForAnyNumberOfThreads) {
  const std::vector<Vec3> points = comb(8000, 2);
  const PointCloud cloud = oriented(points).cloud;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Cloud again = oriented(points);
  EXPECT_TRUE(again.cloud.normal == cloud.normal);
  EXPECT_GT(again.report.creased, 0);
}

TEST(CreasePlanes, OfFewOrManyNeighbours) {
  for (const int neighbours : {0, 1, 2, 3, 64, 1000}) {
    SCOPED_TRACE(neighbours);
    OrientationOptions options;
    options.creases.neighbours = neighbours;
    const Cloud box = oriented(sample_shape(ShapeKind::box, 3000, 3), options);
    for (const Vec3f& normal : box.cloud.normal) EXPECT_NEAR(normal.norm(), 1.0f, 1e-4f);
    EXPECT_EQ(box.report.creased > 0, neighbours == 64 || neighbours == 1000);
  }
  OrientationOptions noisy;
  noisy.most_noise_at_creases = INFINITY;
  EXPECT_EQ(oriented(sample_shape(ShapeKind::box, 20, 3), noisy).report.creased, 0)
      << "a quarter of 32 is more than a face has";
}

// The walls of a square tower that was cut into slices, of which each holds samples one unit apart.
std::vector<Vec3> sliced_tower(double gap, double half_width, double slope) {
  std::vector<Vec3> points;
  Random random(1);
  for (double z = 0.0; z < 60.0; z += gap) {
    const double half = half_width - slope * z, first = random.uniform();
    for (double along = first; along < 8.0 * half; along += 1.0) {
      const double side = std::floor(along / (2.0 * half)), t = along - (2.0 * side + 1.0) * half;
      const double x = side < 2.0 ? t : -t, y = side == 0.0 || side == 3.0 ? -half : half;
      points.push_back(side == 0.0 || side == 2.0 ? Vec3(x, y, z) : Vec3(-y, x, z));
    }
  }
  return points;
}

TEST(CreasePlanes, SlicesAreNoFaces) {
  OrientationOptions any;
  any.creases.least_agreement = -1.0;
  const Cloud wide = oriented(sliced_tower(15.0, 8.0, 0.0));
  ASSERT_TRUE(wide.cloud.conditioning.on_lines);
  EXPECT_EQ(wide.report.creased, 0);
  const Cloud narrow = oriented(sliced_tower(4.5, 12.0, 0.1));
  ASSERT_FALSE(narrow.cloud.conditioning.on_lines);
  EXPECT_LT(narrow.report.creased, oriented(sliced_tower(4.5, 12.0, 0.1), any).report.creased / 2);
}

}  // namespace
}  // namespace shrinkwrap::testing
