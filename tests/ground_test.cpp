// Sides of ground and of what stands on it: views from where the ground faces tell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "filter_outcomes.h"
#include "orientation/orientation.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

struct Block {
  Vec3 low, high;
};

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  Vec3 normal = Vec3::Zero();
};

// Of a ray from outside.
Hit hit_of(const Block& block, const Vec3& from, const Vec3& way) {
  double enters = 0.0, leaves = std::numeric_limits<double>::infinity();
  int face = kNone;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (block.low[axis] - from[axis]) / way[axis];
    const double b = (block.high[axis] - from[axis]) / way[axis];
    if (std::min(a, b) > enters) {
      enters = std::min(a, b);
      face = axis;
    }
    leaves = std::min(leaves, std::max(a, b));
  }
  Hit hit;
  if (face == kNone || enters >= leaves) return hit;
  hit.distance = enters;
  hit.normal[face] = way[face] < 0.0 ? 1.0 : -1.0;
  return hit;
}

struct Scene {
  std::vector<Vec3> points, outward;
};

// Blocks on the ground at z = -2, scanned from stations 2 above it: rays at random, from straight
// ahead 57 degrees down and 29 up, as far as 60.
Scene scan(const std::vector<Block>& blocks, const std::vector<Vec3>& stations, unsigned seed) {
  constexpr int kRays = 16000;
  constexpr double kReach = 60.0, kNoise = 0.005;
  Random random(seed);
  Scene scene;
  for (const Vec3& station : stations)
    for (std::size_t k = 0; k < kRays / stations.size(); ++k) {
      const double up = random.uniform(-1.0, 0.5), around = random.uniform(0.0, 2.0 * kPi);
      const Vec3 way(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                     std::sin(up));
      Hit nearest;
      if (way.z() < 0.0) nearest = {-2.0 / way.z(), Vec3::UnitZ()};
      for (const Block& block : blocks) {
        const Hit hit = hit_of(block, station, way);
        if (hit.distance < nearest.distance) nearest = hit;
      }
      if (!(nearest.distance < kReach)) continue;
      scene.points.push_back(station + nearest.distance * way + kNoise * random.in_cube());
      scene.outward.push_back(nearest.normal);
    }
  return scene;
}

OrientationReport orient(PointCloud& cloud, const OrientationOptions& options) {
  Progress silent;
  return orient_normals(cloud, options, silent);
}

Index count_wrong(const Scene& scene, const OrientationOptions& options) {
  PointCloud cloud = prepared_cloud(scene.points);
  EXPECT_EQ(orient(cloud, options).ground.isZero(), options.least_ground > 1.0);
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i)
    wrong += scene.outward[cloud.input_index[i]].dot(cloud.normal[i].cast<double>()) < -0.2;
  return wrong;
}

// Which touch it with few samples, as they are far sparser.
TEST(Ground, WallsFaceOutwardsAsSeenFromAbove) {
  const std::vector<Vec3> stations = {{0, 0, 0}, {20, 3, 0}, {28, -14, 0}, {-5, 20, 0}};
  const Scene house = scan({{{8, -6, -2}, {20, 6, 6}}}, stations, 1);
  OrientationOptions options;
  EXPECT_LT(count_wrong(house, options), 20);
  options.least_ground = 2.0;
  EXPECT_GT(count_wrong(house, options), 100);
}

// Of which the upper side was not seen: views from above see the other one.
TEST(Ground, CeilingsFaceDown) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    std::vector<Block> hall = {{{-10, -10, 3}, {10, 10, 3.5}}};
    for (const double x : {-8.0, 8.0})
      for (const double y : {-8.0, 8.0})
        hall.push_back({{x - 0.5, y - 0.5, -2}, {x + 0.5, y + 0.5, 3}});
    EXPECT_LT(count_wrong(scan(hall, {{0, 0, 0}, {20, 3, 0}}, seed), {}), 100) << seed;
  }
}

// Its ceiling is above its floor, too.
TEST(Ground, AClosedRoomInAHouseFacesInwards) {
  Random random(3);
  Scene scene;
  const auto add_rectangle = [&](const Vec3& centre, const Vec3& a, const Vec3& b, double side) {
    for (double k = 4.0 * a.cross(b).norm(); k > 0.0; --k) {
      const double u = random.uniform(-1.0, 1.0), v = random.uniform(-1.0, 1.0);
      const Vec3 point = centre + u * a + v * b;
      if (point.z() == 0.0 && point.cwiseAbs().maxCoeff() < 14.0) continue;  // below the house
      scene.points.push_back(point);
      scene.outward.push_back(side * a.cross(b).normalized());
    }
  };
  const auto add_box = [&](double half, double low, double high, bool has_floor, double side) {
    const Vec3 x = half * Vec3::UnitX(), y = half * Vec3::UnitY(),
               z = 0.5 * (high - low) * Vec3::UnitZ();
    const Vec3 centre(0.0, 0.0, 0.5 * (low + high));
    for (const double way : {1.0, -1.0}) {
      add_rectangle(centre + way * x, y, z, way * side);
      add_rectangle(centre + way * y, z, x, way * side);
      if (way > 0.0 || has_floor) add_rectangle(centre + way * z, x, y, way * side);
    }
  };
  add_rectangle(Vec3::Zero(), 40.0 * Vec3::UnitX(), 40.0 * Vec3::UnitY(), 1.0);
  add_box(14.0, 0.0, 16.0, false, 1.0);
  add_box(9.0, 4.0, 11.0, true, -1.0);
  OrientationOptions options;
  EXPECT_LT(count_wrong(scene, options), 100);
  options.least_ground = 2.0;
  EXPECT_GT(count_wrong(scene, options), 1000);
}

// All of the cloud faces nowhere then, and views from one side would not see most of it.
TEST(Ground, IsNotWhereItIsBesideABody) {
  for (const bool has_body : {false, true}) {
    Random random(1);
    std::vector<Vec3> points;
    for (int k = 0; k < 600; ++k)
      points.emplace_back(random.uniform(3.0, 5.0), random.uniform(-1.0, 1.0),
                          0.02 * random.gaussian());
    for (int k = 0; has_body && k < 3000; ++k) points.push_back(2.0 * random.direction());
    PointCloud cloud = prepared_cloud(points);
    const OrientationReport report = orient(cloud, {});
    EXPECT_EQ(report.ground.isZero(), has_body);
    EXPECT_EQ(report.undecided_components, 1);
  }
}

// Its samples face where the denser face does on the whole, but views are trusted.
TEST(Ground, IsNotADenserFaceOfABody) {
  for (const double side : {0.7, -0.7, 3.0, -3.0}) {  // half as far from the other one
    Random random(2);
    Scene plate;
    const auto add = [&](const Vec3& point, const Vec3& normal) {
      plate.points.push_back(point);
      plate.outward.push_back(normal);
    };
    const auto across = [&] { return random.uniform(-20.0, 20.0); };
    for (int k = 0; k < 8000; ++k) {
      const double z = k % 4 == 0 ? -side : side, x = across(), y = across();
      add({x, y, z}, std::copysign(1.0, z) * Vec3::UnitZ());
    }
    for (int k = 0; k < 400 * std::abs(side); ++k) {
      Vec3 rim(across(), 20.0, side * random.uniform(-1.0, 1.0)), normal(0.0, 1.0, 0.0);
      if (k % 2) rim.y() *= -1.0, normal.y() = -1.0;
      if (k % 4 > 1) std::swap(rim.x(), rim.y()), std::swap(normal.x(), normal.y());
      add(rim, normal);
    }
    PointCloud cloud = prepared_cloud(plate.points);
    EXPECT_TRUE(orient(cloud, {}).ground.isZero());
    Index wrong = 0;
    for (Index i = 0; i < cloud.size(); ++i)
      wrong += plate.outward[cloud.input_index[i]].dot(cloud.normal[i].cast<double>()) < -0.2;
    EXPECT_LT(wrong, 20) << side;
  }
}

TEST(Ground, IsTold) {
  FilterInput terrain, ball;
  Random random(1);
  for (int k = 0; k < 600; ++k)
    terrain.points.emplace_back(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                                0.02 * random.uniform(-1.0, 1.0));
  terrain.points = in_single_precision(terrain.points);
  ball.points = in_single_precision(sample_shape(ShapeKind::sphere, 500, 1));
  const auto is_warned = [](const FilterInput& input, const char* of) {
    return is_in(run(Filter::initial_mesh, input).warnings, of);
  };
  EXPECT_TRUE(is_warned(terrain, ", 1.00)"));
  EXPECT_FALSE(is_warned(terrain, "of the cloud can be seen"));
  EXPECT_FALSE(is_warned(ball, "ground"));
}

}  // namespace
}  // namespace shrinkwrap::testing
