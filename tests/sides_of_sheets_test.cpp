// Which side of an open sheet is outside, where views hardly tell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orientation/orientation.h"
#include "oriented_cloud.h"
#include "shapes.h"
#include "town.h"

namespace shrinkwrap {
namespace {

using testing::make_town;
using testing::prepared_cloud;
using testing::Random;
using testing::Town;
using testing::TownOptions;

OrientationReport orient(PointCloud& cloud) {
  Progress silent;
  return orient_normals(cloud, OrientationOptions(), silent);
}

// Views see its hills from above and its valleys from below, and the edges between are sharp: even
// if views counted for more than neighbours, those on a sheet would not be trusted.
TEST(SidesOfSheets, HillsAndValleysHaveOneSide) {
  const auto zigzag = [](double x) { return std::abs(std::fmod(x + 140.0, 14.0) - 7.0); };
  std::vector<Vec3> points;
  Random random(5);
  for (int i = 0; i < 80; ++i)
    for (int j = 0; j < 80; ++j) {
      const double x = i + random.uniform(-0.3, 0.3), y = j + random.uniform(-0.3, 0.3);
      points.push_back({x, y, 0.6 * (zigzag(x) + zigzag(y))});
    }
  OrientationOptions by_views;
  by_views.signs.vote_weight = by_views.disputes.vote_weight = 1e6;
  for (const OrientationOptions& options : {OrientationOptions(), by_views}) {
    PointCloud cloud = prepared_cloud(points);
    Progress silent;
    orient_normals(cloud, options, silent);
    for (const Vec3f& normal : cloud.normal) ASSERT_GT(normal.z(), 0.0f);
  }
}

Index count_wrong(const PointCloud& cloud, const std::vector<Vec3>& outward) {
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i)
    wrong += outward[cloud.input_index[i]].dot(cloud.normal[i].cast<double>()) < 0.0;
  return wrong;
}

TEST(SidesOfSheets, GroundFacesUpwardsUnderWhatStandsOnIt) {
  for (const bool has_walls : {false, true})
    for (const bool has_trees : {false, true})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(std::to_string(has_walls) + std::to_string(has_trees) + std::to_string(seed));
        const Town town = make_town({has_walls, has_trees, false}, seed);
        PointCloud cloud = prepared_cloud(town.points);
        orient(cloud);
        EXPECT_LT(count_wrong(cloud, town.outward), 0.02 * cloud.size());
      }
}

// Their corners are near enough to the ground to be its neighbours, and the views tell nothing.
TEST(SidesOfSheets, LowRoofsWithoutWallsFaceUpwards) {
  for (const double height : {1.6, 2.0, 2.5})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      SCOPED_TRACE(std::to_string(height) + " " + std::to_string(seed));
      TownOptions low;
      low.height = height;
      const Town town = make_town(low, seed);
      PointCloud cloud = prepared_cloud(town.points);
      orient(cloud);
      EXPECT_LT(count_wrong(cloud, town.outward), 0.01 * cloud.size());
    }
}

// Roofs tell, whose inner sides can hardly be seen; the ground does not.
TEST(SidesOfSheets, FaceWhereOthersDo) {
  for (const int axis : {0, 1, 2})
    for (const double sign : {-1.0, 1.0}) {
      SCOPED_TRACE(std::to_string(axis) + " " + std::to_string(sign));
      Town town = make_town({false, false, false}, 1);
      for (std::vector<Vec3>* all : {&town.points, &town.outward})
        for (Vec3& v : *all) v = Vec3(v[(axis + 1) % 3], v[(axis + 2) % 3], v[axis]) * sign;
      PointCloud cloud = prepared_cloud(town.points);
      orient(cloud);
      EXPECT_LT(count_wrong(cloud, town.outward), 0.02 * cloud.size());
    }
}

// Half a ball above the ground, which is sure that it faces down.
void add_lower_half_of_ball(std::size_t count, Random& random, std::vector<Vec3>& points) {
  for (std::size_t added = 0; added < count;) {
    const Vec3 way = random.direction();
    if (way.z() >= 0.0) continue;
    points.push_back(3.0 * way + Vec3(0.0, 0.0, 20.0));
    ++added;
  }
}

// Uneven ground from x = `left` to `right`, as wide as it is long or 60, half of it below what
// grows on it: that is no surface.
void add_wood(double left, double right, Random& random, std::vector<Vec3>& points) {
  const double width = std::min(right - left, 60.0);
  for (double x = left; x < right; ++x)
    for (double y = 0.0; y < width; ++y) {
      const auto within = [&](double at) { return at + random.uniform(-0.3, 0.3); };
      points.emplace_back(within(x), within(y), 0.05 * random.gaussian());
      if (std::sin(0.4 * x) * std::sin(0.4 * y) < 0.0) continue;
      points.emplace_back(within(x), within(y), random.uniform(0.5, 3.0));
    }
}
// Of the ground beyond x = `left`.
Index count_facing_down(const PointCloud& cloud, double left) {
  Index count = 0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    count += p.x() > left && p.z() < 0.3 && cloud.normal[i].z() < -0.7f;
  }
  return count;
}

// It is seen more from below.
TEST(SidesOfSheets, GroundFacesUpUnderAWood) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    std::vector<Vec3> points;
    add_wood(0.0, 60.0, random, points);
    PointCloud cloud = prepared_cloud(points);
    orient(cloud);
    EXPECT_LT(count_facing_down(cloud, -1.0), 360) << "of 3600, seed " << seed;
  }
}

// Which are too small to be told from bodies by themselves; nor do they follow few others.
TEST(SidesOfSheets, GroundDoesNotFollowPiecesOfIt) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    std::vector<Vec3> points;
    add_wood(0.0, 60.0, random, points);
    add_wood(70.0, 85.0, random, points);
    add_lower_half_of_ball(60, random, points);
    PointCloud cloud = prepared_cloud(points);
    orient(cloud);
    EXPECT_LT(count_facing_down(cloud, -1.0), 380) << "of 3825, seed " << seed;
    EXPECT_LT(count_facing_down(cloud, 65.0), 23) << "of 225, seed " << seed;
  }
}

TEST(SidesOfSheets, FollowOthersThatAreNotFew) {
  for (const std::size_t others : {40u, 400u}) {
    Random random(1);
    std::vector<Vec3> points;
    add_lower_half_of_ball(others, random, points);
    while (points.size() < 4000)
      points.emplace_back(random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0),
                          0.05 * random.gaussian());
    PointCloud cloud = prepared_cloud(points);
    EXPECT_EQ(orient(cloud).undecided_components, 1);
    Index up = 0, ground = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
      if (cloud.frame.to_input(cloud.position[i]).z() > 1.0)
        continue;  // hidden from the other side
      ++ground;
      up += cloud.normal[i].z() > 0.0f;
    }
    EXPECT_EQ(up, others == 40 ? ground : 0) << others;
  }
}

// Flat on the whole, as it is long.
TEST(SidesOfSheets, HalfAPipeFacesOutwards) {
  for (const double side : {1.0, -1.0}) {
    Random random(3);
    std::vector<Vec3> points;
    for (int i = 0; i < 6000; ++i) {
      const double around = random.uniform(0.0, kPi);
      points.emplace_back(random.uniform(0.0, 8.0), std::cos(around), side * std::sin(around));
    }
    PointCloud cloud = prepared_cloud(points);
    orient(cloud);
    for (Index i = 0; i < cloud.size(); ++i)
      ASSERT_GT(cloud.frame.to_input(cloud.position[i])
                    .tail<2>()
                    .dot(cloud.normal[i].tail<2>().cast<double>()),
                0.0)
          << side;
  }
}

TEST(SidesOfSheets, SaysThatTheyHaveNoOutside) {
  Random random(6);
  std::vector<Vec3> points;
  for (int i = 0; i < 3000; ++i) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
    points.emplace_back(x, y, 0.02 * std::sin(4 * x) * std::sin(4 * y));
  }
  PointCloud cloud = prepared_cloud(points);
  const OrientationReport report = orient(cloud);
  EXPECT_EQ(report.components, 1);
  EXPECT_EQ(report.undecided_components, 1);
  for (Index i = 1; i < cloud.size(); ++i)  // of one sign all the same
    ASSERT_GT(cloud.normal[i].dot(cloud.normal[0]), 0.5f);
}

// Whichever sign the samples happened to come with: a terrain faces up, a wall along its axis.
TEST(SidesOfSheets, FaceUp) {
  for (const int axis : {2, 1, 0})
    for (const double direction : {1.0, -1.0}) {
      Random random(7);
      std::vector<Vec3> points;
      for (Index i = 0; i < 4000; ++i) {
        const double x = random.uniform(-1.0, 1.0), y = random.uniform(-1.0, 1.0);
        Vec3 p;
        p[(axis + 1) % 3] = x;
        p[(axis + 2) % 3] = y;
        p[axis] = direction * 0.1 * x * y;
        points.push_back(p);
      }
      const PointCloud sheet = [&] {
        PointCloud cloud = prepared_cloud(points);
        orient(cloud);
        return cloud;
      }();
      Index down = 0;
      for (const Vec3f& normal : sheet.normal) down += normal[axis] < 0.0f;
      EXPECT_EQ(down, 0) << "axis " << axis << ", direction " << direction;
    }
}

}  // namespace
}  // namespace shrinkwrap
