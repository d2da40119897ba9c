// Which clouds are one view from a place, and that their normals face it.
#include "orientation/station.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "filter_outcomes.h"
#include "orientation/orientation.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::closed_shapes;
using testing::is_told;
using testing::prepared_cloud;
using testing::Random;
using testing::run;
using testing::sample_shape;
using testing::sample_shape_blue_noise;
using testing::ShapeKind;

Vec3 origin_of(const PointCloud& cloud) {
  return cloud.frame.to_unit(Vec3::Zero());
}

bool is_view(const PointCloud& cloud) {
  Progress silent;
  return is_view_from(cloud, origin_of(cloud), StationOptions(), silent);
}

double spread_left(const PointCloud& cloud) {
  Progress silent;
  return spread_left_from(cloud, origin_of(cloud), silent);
}

double part_hidden(const PointCloud& cloud) {
  Progress silent;
  return part_hidden_from(cloud, origin_of(cloud), silent);
}

// Where a ray from the origin meets things, or infinity.
using Distance = std::function<double(const Vec3& way)>;

Distance to_plane(const Vec3& normal, double offset) {
  return [=](const Vec3& way) {
    const double distance = offset / normal.dot(way);
    return distance > 0.0 ? distance : std::numeric_limits<double>::infinity();
  };
}

Distance to_ball(const Vec3& centre, double radius) {
  return [=](const Vec3& way) {
    const double along = way.dot(centre);
    const double left = along * along - centre.squaredNorm() + radius * radius;
    return left > 0.0 ? along - std::sqrt(left) : std::numeric_limits<double>::infinity();
  };
}

// By a camera at the origin that looks along +z: for each pixel the foremost of the things.
std::vector<Vec3> view_of(const std::vector<Distance>& things, unsigned seed) {
  constexpr int kWidth = 120, kHeight = 90;
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < kWidth; ++i)
    for (int j = 0; j < kHeight; ++j) {
      const double x = i + random.uniform(-0.3, 0.3), y = j + random.uniform(-0.3, 0.3);
      const Vec3 way =
          Vec3((x - 0.5 * kWidth) / 100.0, (y - 0.5 * kHeight) / 100.0, 1.0).normalized();
      double nearest = std::numeric_limits<double>::infinity();
      for (const Distance& distance : things) nearest = std::min(nearest, distance(way));
      if (std::isfinite(nearest)) points.push_back(nearest * way);
    }
  return points;
}

// Two balls above a table.
std::vector<Vec3> view_of_table(unsigned seed) {
  const Vec3 up(0.0, -0.6, -0.8);
  return view_of(
      {to_plane(up, -1.5), to_ball({0.1, 0.2, 1.3}, 0.2), to_ball({-0.2, 0.0, 1.1}, 0.15)}, seed);
}

std::vector<Vec3> turned_about(std::vector<Vec3> points) {
  for (Vec3& p : points) p = Vec3(-p.x(), p.y(), -p.z());
  return points;
}

std::vector<Vec3> moved(std::vector<Vec3> points, const Vec3& by) {
  for (Vec3& p : points) p += by;
  return points;
}

// Samples in the directions from a station that lies within or outside of a ball, both of its
// sides.
std::vector<Vec3> ball_from(const Vec3& station, int count, unsigned seed) {
  const Vec3 centre = -station;
  Random random(seed);
  std::vector<Vec3> points;
  while (static_cast<int>(points.size()) < count) {
    const Vec3 way = random.direction();
    const double along = way.dot(centre), left = along * along - centre.squaredNorm() + 1.0;
    if (left <= 0.0) continue;
    for (const double distance : {along - std::sqrt(left), along + std::sqrt(left)})
      if (distance > 0.0) points.push_back(distance * way);
  }
  return points;
}

Index count_turned_away(const PointCloud& cloud) {
  Index count = 0;
  for (Index i = 0; i < cloud.size(); ++i)
    count += cloud.frame.to_input(cloud.position[i]).dot(cloud.normal[i].cast<double>()) > 0.0;
  return count;
}

TEST(Station, OfOneViewOfACamera) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const PointCloud cloud = prepared_cloud(view_of_table(seed));
    EXPECT_LT(spread_left(cloud), 0.1);
    EXPECT_LT(part_hidden(cloud), 0.1);
    EXPECT_TRUE(is_view(cloud));
  }
}

TEST(Station, NotWhereTheCameraWasNot) {
  for (const Vec3& by :
       {Vec3(0.0, 0.0, -3.0), Vec3(-5.0, 0.0, 0.0), Vec3(0.0, 0.0, 20.0), Vec3(5e5, 5e6, 300.0)}) {
    const PointCloud cloud = prepared_cloud(moved(view_of_table(1), by));
    EXPECT_FALSE(is_view(cloud)) << by.transpose();
  }
  for (const ShapeKind kind : closed_shapes())
    for (const double away : {0.0, 1.0, 2.0, 4.0}) {
      const PointCloud cloud =
          prepared_cloud(moved(sample_shape(kind, 3000, 1), Vec3(away, 0.3, 0.1)));
      EXPECT_FALSE(is_view(cloud)) << away;
    }
}

// Both sides of it as dense as seen from there, or the back sparser.
TEST(Station, NotOfWhatHidesHalfOfItself) {
  const StationOptions options;
  for (const Index behind : {1, 4}) {
    std::vector<Vec3> points;
    for (const Vec3& p : ball_from({0.0, 0.0, -3.0}, 12000, 1))
      if (p.norm() < std::sqrt(8.0) || points.size() % behind == 0) points.push_back(p);
    const PointCloud cloud = prepared_cloud(points);
    EXPECT_LT(spread_left(cloud), options.most_spread_left);
    EXPECT_GT(part_hidden(cloud), options.most_hidden);
    EXPECT_FALSE(is_view(cloud));
  }
}

// Outer and inner side of a dome are seen, and it is sparser farther away by chance.
TEST(Station, NotOfADomeThatIsSparserFartherAway) {
  const Vec3 centre = 3.0 * Vec3(std::sin(1.37), 0.0, std::cos(1.37));
  Random random(1);
  std::vector<Vec3> points;
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::hemisphere, 3000, 1))
    if (random.uniform() < std::pow(10.0, 0.5 * p.x() - 0.5)) points.push_back(p + centre);
  const PointCloud cloud = prepared_cloud(points);
  EXPECT_FALSE(is_view(cloud));
  StationOptions trusting;
  trusting.most_hidden_in_doubt = trusting.most_hidden;
  Progress silent;
  EXPECT_TRUE(is_view_from(cloud, origin_of(cloud), trusting, silent)) << "nothing else tells";
}

// Ground around a scanner 1.7 above it, at a height above the origin.
std::vector<Vec3> ground_around(double height) {
  Random random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 8000; ++i) {
    const double around = random.uniform(0.0, 2.0 * kPi), down = random.uniform(0.15, 1.0);
    points.emplace_back(1.7 / std::tan(down) * std::cos(around),
                        1.7 / std::tan(down) * std::sin(around),
                        height + 0.002 * random.gaussian());
  }
  return points;
}

// As dense as seen from above and from below.
TEST(Station, AboveGroundThatIsAllAround) {
  EXPECT_TRUE(is_view(prepared_cloud(ground_around(-1.7))));
  EXPECT_FALSE(is_view(prepared_cloud(ground_around(1.7))));
  std::vector<Vec3> wall = ground_around(-1.7);
  for (Vec3& p : wall) p = Vec3(p.z(), p.y(), -p.x());
  EXPECT_FALSE(is_view(prepared_cloud(wall))) << "it may have been seen from the other side";
}

// Ground around a scanner above it, with the origin below; and ground far above the origin.
TEST(Station, NotBehindTheSheet) {
  Random random(1);
  std::vector<Vec3> terrain;
  for (int i = 0; i < 8000; ++i) {
    const double x = random.uniform(-500.0, 500.0), y = random.uniform(-500.0, 500.0);
    terrain.emplace_back(x, y, 3000.0 + 60.0 * std::sin(0.01 * x) * std::sin(0.01 * y));
  }
  const StationOptions options;
  const PointCloud ring = prepared_cloud(ground_around(0.5));
  EXPECT_LT(spread_left(ring), options.most_spread_left);
  EXPECT_FALSE(is_view(ring));
  EXPECT_FALSE(is_view(prepared_cloud(terrain)));
}

TEST(Station, NotWithinWhatIsAllAround) {
  const PointCloud cloud = prepared_cloud(ball_from({0.6, 0.3, 0.2}, 6000, 1));
  const StationOptions options;
  EXPECT_LT(spread_left(cloud), options.most_spread_left);
  EXPECT_LT(part_hidden(cloud), options.most_hidden);
  EXPECT_FALSE(is_view(cloud));
}

TEST(Station, MayBeASample) {
  std::vector<Vec3> points = view_of_table(1);
  points.push_back(Vec3::Zero());
  const PointCloud cloud = prepared_cloud(points);
  EXPECT_TRUE(is_view(cloud));
}

// A flat sheet, of which nothing else tells the side.
TEST(Station, NormalsFaceIt) {
  Progress silent;
  std::vector<Vec3> view = view_of({to_plane(Vec3(0.0, -0.6, -0.8), -1.5)}, 2);
  for (Vec3& p : view) p *= 1.0 + 0.001 * std::sin(20.0 * p.x()) * std::sin(20.0 * p.y());
  for (const bool is_turned : {false, true}) {
    const std::vector<Vec3> points = is_turned ? turned_about(view) : view;
    PointCloud cloud = prepared_cloud(points);
    OrientationReport report = orient_normals(cloud, {}, silent);
    EXPECT_TRUE(report.is_view);
    EXPECT_GT(report.components, 0);
    EXPECT_EQ(report.undecided_components, 0);
    EXPECT_LT(report.closedness, 0.5);
    EXPECT_EQ(count_turned_away(cloud), 0);

    OrientationOptions without;
    without.station.most_spread_left = 0.0;
    report = orient_normals(cloud, without, silent);
    EXPECT_FALSE(report.is_view);
    EXPECT_EQ(count_turned_away(cloud), is_turned ? 0 : cloud.size()) << "up, along +z";
  }
}

// Steps of the distance wider than the samples are apart: neighbours tell nothing of each other.
TEST(Station, NormalsFaceItOneByOne) {
  Progress silent;
  std::vector<Vec3> points = view_of_table(3);
  for (Vec3& p : points) p *= 0.05 * std::round(p.z() / 0.05) / p.z();
  PointCloud cloud = prepared_cloud(points);
  EXPECT_TRUE(orient_normals(cloud, {}, silent).is_view);
  EXPECT_LT(count_turned_away(cloud), 0.01 * cloud.size());
  OrientationOptions without;
  without.station.most_spread_left = 0.0;
  without.least_ground = 2.0;  // views from one side would tell, too
  orient_normals(cloud, without, silent);
  const Index away = count_turned_away(cloud);
  EXPECT_GT(std::min(away, cloud.size() - away), 0.05 * cloud.size());
}

// Where noise turns normals beyond the line of sight, neighbours know better.
TEST(Station, NormalsSeenAslantAreLikeTheirNeighbours) {
  Progress silent;
  for (const double up : {-1.0, 1.0}) {  // ground and ceiling
    Random random(1);
    std::vector<Vec3> points = view_of({to_plane(Vec3(0.0, up, 0.0), -0.3)}, 4);
    points.erase(
        std::remove_if(points.begin(), points.end(), [](const Vec3& p) { return p.z() > 6.0; }),
        points.end());
    for (Vec3& p : points) p.y() += 0.008 * p.z() * random.gaussian();
    PointCloud cloud = prepared_cloud(points);
    EXPECT_TRUE(orient_normals(cloud, {}, silent).is_view);
    Index wrong = 0, beyond = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const bool is_right = up * cloud.normal[i].y() > 0.0f;
      const Vec3 way = cloud.frame.to_input(cloud.position[i]);
      wrong += !is_right;
      beyond += is_right && cloud.normal[i].cast<double>().dot(way) > 0.0;
    }
    EXPECT_GT(beyond, 20);
    EXPECT_LT(4 * wrong, beyond);
  }
}

TEST(Station, IsTold) {
  const std::string told = "seen from the origin";
  FilterInput view, ball;
  view.points = testing::in_single_precision(view_of_table(1));
  ball.points = testing::in_single_precision(sample_shape(ShapeKind::sphere, 500, 1));
  for (const Filter filter : {Filter::reconstruct, Filter::initial_mesh}) {
    EXPECT_TRUE(is_told(run(filter, view), told));
    EXPECT_FALSE(is_told(run(filter, ball), told));
  }
}

}  // namespace
}  // namespace shrinkwrap
