#include "orientation/orientation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "oriented_cloud.h"
#include "samples/neighbourhoods.h"
#include "shapes.h"
#include "town.h"

namespace shrinkwrap {
namespace {

using testing::closed_shapes;
using testing::make_town;
using testing::prepared_cloud;
using testing::Random;
using testing::sample_implicit;
using testing::sample_shape;
using testing::Shape;
using testing::shape_of;
using testing::ShapeKind;
using testing::spiral_sphere;

OrientationReport orient(PointCloud& cloud) {
  Progress silent;
  return orient_normals(cloud, OrientationOptions(), silent);
}

// Samples whose normal opposes that of the shape.
Index count_wrong(const PointCloud& cloud, const Shape& shape) {
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = shape.normal(cloud.frame.to_input(cloud.position[i]));
    wrong += normal.dot(cloud.normal[i].cast<double>()) < 0.0;
  }
  return wrong;
}

std::vector<Vec3> sphere(Index count, double radius, const Vec3& centre, unsigned seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (Index i = 0; i < count; ++i) points.push_back(centre + radius * random.direction());
  return points;
}

void append(std::vector<Vec3>& points, const std::vector<Vec3>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

// Cosine of a sample's normal with the direction away from the origin of the input.
double outwardness(const PointCloud& cloud, Index i) {
  return cloud.frame.to_input(cloud.position[i]).normalized().dot(cloud.normal[i].cast<double>());
}

TEST(Orientation, IsOutwardOnClosedShapes) {
  for (ShapeKind kind : closed_shapes())
    for (unsigned seed : {1u, 2u}) {
      const Shape shape = shape_of(kind);
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      PointCloud cloud = prepared_cloud(sample_shape(kind, 8000, seed));
      const OrientationReport report = orient(cloud);
      EXPECT_EQ(report.components, shape.components);
      EXPECT_EQ(report.undecided_components, 0);
      EXPECT_EQ(report.enclosed_components, 0);
      // Across a sharp edge the true normal of a sample is a matter of opinion.
      const bool sharp = kind == ShapeKind::box || kind == ShapeKind::thin_plate;
      EXPECT_LE(count_wrong(cloud, shape), sharp ? 12 : 0);
    }
}

TEST(Orientation, IsOutwardOnAnOpenCap) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::hemisphere, 8000, 3));
  const OrientationReport report = orient(cloud);
  EXPECT_EQ(report.undecided_components, 0);
  EXPECT_EQ(count_wrong(cloud, shape_of(ShapeKind::hemisphere)), 0);
}

// Half the samples of a lens lie beyond an edge so sharp that normals on either side of it are
// nearly parallel: seen from the edge, both sides are one.
TEST(Orientation, BothSidesOfASharpEdgeFaceOutwards) {
  const Vec3 centre(0.0, 0.0, 0.94);
  const auto implicit = [&](const Vec3& p) {
    return std::max((p - centre).norm(), (p + centre).norm()) - 1.0;
  };
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::vector<Vec3> points = sample_implicit(implicit, {}, 4000, random).points;
    PointCloud cloud = prepared_cloud(points);
    orient(cloud);
    Index wrong = 0;
    for (Index i = 0; i < cloud.size(); ++i)
      wrong += (cloud.frame.to_input(cloud.position[i]).z() > 0.0) != (cloud.normal[i].z() > 0.0f);
    EXPECT_LE(wrong, 170);  // where the lens is thinner than the samples are apart
  }
}

// A wheel of plates two samples thick. Where normals are those of one plane each, neighbours on
// both sides of a plate, or across its edge, are taken for one sheet here and there, and a tree
// turns all that lies beyond.
TEST(Orientation, BladesOfAWheelFaceOutwards) {
  constexpr double kThick = 2.0, kInner = 6.0, kOuter = 26.0, kHeight = 30.0;
  constexpr int kBlades = 9;
  for (const unsigned seed : {1u, 3u}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<Vec3> points, normals;
    const auto add = [&](double area, const auto& place, const Vec3& normal) {
      for (int i = 0; i < static_cast<int>(area); ++i)
        for (int blade = 0; blade < kBlades; ++blade) {
          const Eigen::AngleAxisd turn(2.0 * kPi * blade / kBlades, Vec3::UnitZ());
          points.push_back(turn * place());
          normals.push_back(turn * normal);
        }
    };
    const auto length = [&] { return random.uniform(kInner, kOuter); };
    const auto across = [&] { return random.uniform(-0.5, 0.5) * kThick; };
    const auto height = [&] { return random.uniform(0.0, kHeight); };
    const double area = (kOuter - kInner) * kHeight;
    for (const double side : {-1.0, 1.0}) {
      add(
          area, [&] { return Vec3(length(), 0.5 * side * kThick, height()); },
          side * Vec3::UnitY());
      add((kOuter - kInner) * kThick,
          [&] { return Vec3(length(), across(), side < 0.0 ? 0.0 : kHeight); },
          side * Vec3::UnitZ());
      add(
          kHeight * kThick, [&] { return Vec3(side < 0.0 ? kInner : kOuter, across(), height()); },
          side * Vec3::UnitX());
    }
    const auto wrong_part = [&](const OrientationOptions& options, bool knows_sheets) {
      PointCloud cloud = prepared_cloud(points);
      Progress silent;
      if (!knows_sheets)
        cloud.normal =
            find_neighbourhoods(cloud.position, cloud.search, cloud.neighbour_count, silent).normal;
      orient_normals(cloud, options, silent);
      double wrong = 0.0;
      for (Index i = 0; i < cloud.size(); ++i)
        wrong += normals[cloud.input_index[i]].dot(cloud.normal[i].cast<double>()) < 0.0;
      return wrong / cloud.size();
    };
    OrientationOptions by_all, by_tree;
    by_all.signs.contact_agreement = by_tree.signs.contact_agreement = 0.0;
    by_all.poles.least_deviation = by_tree.poles.least_deviation = INFINITY;
    by_all.inverted.most_noise = by_tree.inverted.most_noise = -1.0;  // nor are patches turned
    by_tree.signs.vote_weight = 0.0;
    EXPECT_LT(wrong_part({}, true), 0.006);
    EXPECT_LT(wrong_part(by_all, false), 0.025);
    EXPECT_GT(wrong_part(by_tree, false), 0.1);
  }
}

// Two hollows in a block, nearer to each other than a spacing or two. The few samples that are
// neighbours across the wall between them see each other askew, where normals are those of one
// plane.
TEST(Orientation, HollowsThatNearlyTouchDoNotTurnEachOther) {
  OrientationOptions apart;
  apart.poles.least_deviation = INFINITY;
  apart.inverted.most_noise = -1.0;  // no patch is turned afterwards
  OrientationOptions joined = apart;
  joined.signs.contact_agreement = 0.0;
  int inside_out = 0, inside_out_if_joined = 0;
  for (const double gap : {0.04, 0.06})
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const Vec3 centre(0.35 + 0.5 * gap, 0.0, 0.0);
      const auto block = [&](const Vec3& p) {
        const Vec3 beyond = p.cwiseAbs() - Vec3(0.9, 0.6, 0.6);
        const double hollows = std::min((p - centre).norm(), (p + centre).norm()) - 0.35;
        return std::max(beyond.maxCoeff(), -hollows);
      };
      Random random(seed);
      const std::vector<Vec3> points = sample_implicit(block, {}, 1500, random).points;
      const auto has_turned = [&](const OrientationOptions& options) {
        PointCloud cloud = prepared_cloud(points);
        Progress silent;
        orient_normals(cloud, options, silent);
        Index wrong = 0, inner = 0;
        for (Index i = 0; i < cloud.size(); ++i) {
          const Vec3 p = cloud.frame.to_input(cloud.position[i]);
          const Vec3 way = p - (p.x() > 0.0 ? centre : -centre);
          if (way.norm() > 0.36) continue;
          ++inner;
          wrong += way.dot(cloud.normal[i].cast<double>()) > 0.0;
        }
        return wrong > inner / 4;
      };
      inside_out += has_turned(apart);
      inside_out_if_joined += has_turned(joined);
    }
  EXPECT_GE(inside_out_if_joined, 5) << "this test tests little";
  EXPECT_LE(inside_out, 1);
}

// The samples around any one are of both sides, so that no plane tells of either.
TEST(Orientation, BothSidesOfAPlateOfFewSamplesFaceOutwards) {
  const Shape plate = shape_of(ShapeKind::thin_plate);
  Index wrong = 0, all = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    PointCloud cloud = prepared_cloud(sample_shape(plate.kind, 300, seed));
    orient(cloud);
    wrong += count_wrong(cloud, plate);
    all += cloud.size();
  }
  EXPECT_LT(wrong, 0.1 * all);  // at the rim, most of them
}

// Drawn coarsely, the inner wall of a cup is seen from outside, through the outer one: views object
// to the edges over its rim, and finer views judge that they are wrong.
TEST(Orientation, CoarseViewsDoNotTurnTheInsideOfACup) {
  constexpr double kWall = 4.0, kRadius = 40.0, kHeight = 60.0;
  Random random(1);
  std::vector<Vec3> points;
  std::vector<char> is_inside;
  const auto add_wall = [&](double radius, double low, bool inside) {
    const Index count = static_cast<Index>(2.0 * kPi * radius * (kHeight - low));
    for (Index i = 0; i < count; ++i) {
      const double angle = random.uniform(0.0, 2.0 * kPi);
      points.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), random.uniform(low, kHeight)});
      is_inside.push_back(inside);
    }
  };
  const auto add_disc = [&](double inner, double outer, double z, bool inside) {
    const Index count = static_cast<Index>(kPi * (outer * outer - inner * inner));
    for (Index i = 0; i < count; ++i) {
      const double angle = random.uniform(0.0, 2.0 * kPi);
      const double r = std::sqrt(random.uniform(inner * inner, outer * outer));
      points.push_back({r * std::cos(angle), r * std::sin(angle), z});
      is_inside.push_back(inside);
    }
  };
  add_wall(kRadius, 0.0, false);
  add_wall(kRadius - kWall, kWall, true);
  add_disc(0.0, kRadius, 0.0, false);
  add_disc(0.0, kRadius - kWall, kWall, true);
  add_disc(kRadius - kWall, kRadius, kHeight, false);
  const auto count_wrong = [&](const OrientationOptions& options) {
    PointCloud cloud = prepared_cloud(points);
    Progress silent;
    orient_normals(cloud, options, silent);
    Index wrong = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const Vec3 p = cloud.frame.to_input(cloud.position[i]);
      if (p.z() < 2.0 * kWall || p.z() > kHeight - kWall) continue;
      const double outward = Vec3(p.x(), p.y(), 0.0).dot(cloud.normal[i].cast<double>());
      wrong += is_inside[cloud.input_index[i]] ? outward > 0.0 : outward < 0.0;
    }
    return wrong;
  };
  OrientationOptions options;
  options.propagation_samples = 700;
  EXPECT_LT(count_wrong(options), 100);
  options.disputes.most_objections = 1e9;
  EXPECT_LT(count_wrong(options), 100);
  options.judging_samples = 700;
  EXPECT_GT(count_wrong(options), 5000);
}

// Few of the samples are drawn at first, so coarsely that the two sides of the plate are one.
TEST(Orientation, DrawsThinPartsAgainMoreFinely) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::thin_plate, 20000, 4));
  OrientationOptions options;
  options.drawn_samples = options.propagation_samples = 100;
  Progress silent;
  const OrientationReport report = orient_normals(cloud, options, silent);
  EXPECT_EQ(report.undecided_components, 0);
  EXPECT_LE(count_wrong(cloud, shape_of(ShapeKind::thin_plate)), 20);
}

TEST(Orientation, WallsOfCavitiesFaceTheCavity) {
  std::vector<Vec3> points = sphere(9000, 1.0, Vec3::Zero(), 1);
  append(points, sphere(4500, 0.7, Vec3::Zero(), 2));  // wall of the cavity
  append(points, sphere(1500, 0.4, Vec3::Zero(), 3));  // a body within
  PointCloud cloud = prepared_cloud(points);
  const OrientationReport report = orient(cloud);
  EXPECT_EQ(report.components, 3);
  EXPECT_EQ(report.enclosed_components, 2);
  EXPECT_EQ(report.undecided_components, 0);
  for (Index i = 0; i < cloud.size(); ++i) {
    const double radius = cloud.frame.to_input(cloud.position[i]).norm();
    const bool is_wall = radius > 0.5 && radius < 0.9;
    ASSERT_GT(is_wall ? -outwardness(cloud, i) : outwardness(cloud, i), 0.9) << "radius " << radius;
  }
}

// Hollow balls within each other, whose walls are as thin as a few spacings. Slanting views of
// samples a few spacings apart see through such walls, and of few of the samples all views do.
TEST(Orientation, NoWallIsSeenThroughAnother) {
  struct Case {
    double wall, gap;  // x spacing
    Index drawn;
  };
  for (const auto& [wall, gap, drawn] : {Case{2.5, 3.25, 16000}, Case{4.0, 6.0, 1000}}) {
    SCOPED_TRACE(wall);
    const double spacing = 0.05;
    const std::vector<double> radii = {1.0, 1.0 - wall * spacing, 1.0 - (wall + gap) * spacing,
                                       1.0 - (2.0 * wall + gap) * spacing};
    std::vector<Vec3> points;
    for (const double radius : radii) append(points, spiral_sphere(radius, spacing));
    PointCloud cloud = prepared_cloud(points);
    OrientationOptions options;
    options.drawn_samples = options.propagation_samples = drawn;
    Progress silent;
    const OrientationReport report = orient_normals(cloud, options, silent);
    EXPECT_EQ(report.components, 4);
    EXPECT_EQ(report.enclosed_components, 3);
    Index wrong = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const double radius = cloud.frame.to_input(cloud.position[i]).norm();
      const bool is_inner =
          std::abs(radius - radii[1]) < 1e-3 || std::abs(radius - radii[3]) < 1e-3;
      wrong += (is_inner ? -outwardness(cloud, i) : outwardness(cloud, i)) < 0.9;
    }
    EXPECT_EQ(wrong, 0);
  }
}

// Splats of few of the samples, as large as the hole, hide it: no wall of a cavity, though it lies
// within the body.
TEST(Orientation, AnIslandDeepInAHoleIsSeen) {
  std::vector<Vec3> points;
  for (const Vec3& p : sphere(30000, 1.0, Vec3::Zero(), 6))
    if (p.z() < 0.0 || std::hypot(p.x(), p.y()) > 0.15) points.push_back(p);
  const auto of_ball = static_cast<Index>(points.size());
  Random random(7);
  while (points.size() < static_cast<std::size_t>(of_ball) + 120) {
    const Vec3 p = random.in_cube();
    if (std::hypot(p.x(), p.y()) < 1.0) points.emplace_back(0.1 * p.x(), 0.1 * p.y(), 0.93);
  }
  PointCloud cloud = prepared_cloud(points);
  OrientationOptions options;
  options.drawn_samples = options.propagation_samples = 1000;
  Progress silent;
  const OrientationReport report = orient_normals(cloud, options, silent);
  EXPECT_EQ(report.components, 2);
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i) wrong += outwardness(cloud, i) < 0.9;
  EXPECT_EQ(wrong, 0);
}

// From outside nobody sees those in the middle, which are no cavities.
TEST(Orientation, BodiesBehindOthersFaceOutwards) {
  std::vector<Vec3> points, centres;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y)
      for (int z = 0; z < 4; ++z) centres.emplace_back(0.2 * x, 0.2 * y, 0.2 * z);
  for (std::size_t k = 0; k < centres.size(); ++k)
    append(points, sphere(200, 0.06, centres[k], static_cast<unsigned>(k)));
  PointCloud cloud = prepared_cloud(points);
  const OrientationReport report = orient(cloud);
  EXPECT_EQ(report.components, 100);
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    const Vec3 centre = 0.2 * (p / 0.2).array().round().matrix();
    wrong += cloud.normal[i].cast<double>().dot(p - centre) <= 0.0;
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Orientation, SmallComponentsBesideALargeOneAreSeen) {
  std::vector<Vec3> points = sphere(30000, 1.0, Vec3::Zero(), 5);
  for (unsigned k = 0; k < 12; ++k)
    append(points, sphere(60, 0.05, Vec3(1.3 * std::cos(0.5 * k), 1.3 * std::sin(0.5 * k), 0), k));
  PointCloud cloud = prepared_cloud(points);
  const OrientationReport report = orient(cloud);
  EXPECT_EQ(report.components, 13);
  EXPECT_EQ(report.undecided_components, 0);
  Index wrong = 0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    Vec3 centre = Vec3::Zero();
    if (cloud.input_index[i] >= 30000) {
      const unsigned k = static_cast<unsigned>(cloud.input_index[i] - 30000) / 60;
      centre = Vec3(1.3 * std::cos(0.5 * k), 1.3 * std::sin(0.5 * k), 0);
    }
    wrong += (p - centre).dot(cloud.normal[i].cast<double>()) < 0.0;
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Orientation, TellsHowFarTheCloudIsClosed) {
  const auto closedness = [](const std::vector<Vec3>& points) {
    PointCloud cloud = prepared_cloud(points);
    return orient(cloud).closedness;
  };
  for (const ShapeKind kind : closed_shapes())
    EXPECT_EQ(closedness(sample_shape(kind, 3000, 1)), 1.0);
  // Views see through few samples, or the rings of a scanner.
  for (const Index count : {100, 200})
    EXPECT_EQ(closedness(sphere(count, 1.0, Vec3::Zero(), 1)), 1.0) << count;
  std::vector<Vec3> rings;
  for (int ring = 1; ring < 8; ++ring)
    for (int i = 0; i < 150; ++i) {
      const double across = M_PI * ring / 8.0, along = 2.0 * M_PI * i / 150.0;
      rings.emplace_back(std::sin(across) * std::cos(along), std::sin(across) * std::sin(along),
                         std::cos(across));
    }
  EXPECT_EQ(closedness(rings), 1.0);
  EXPECT_EQ(closedness(make_town({false, false, true}, 1).points), 0.0);
  EXPECT_LT(closedness(make_town({}, 1).points), 0.3);  // roofs hide the edges of holes
  std::vector<Vec3> both = make_town({}, 1).points;
  append(both, sphere(4000, 30.0, {50.0, 50.0, 60.0}, 1));
  const double of_both = closedness(both);
  EXPECT_GT(of_both, 0.1);
  EXPECT_LT(of_both, 0.9);
}

TEST(Orientation, DoesNotDependOnTheSignsItIsGiven) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::torus, 5000, 7));
  PointCloud flipped = cloud;
  for (Index i = 0; i < cloud.size(); i += 3) flipped.normal[i] = -flipped.normal[i];
  orient(cloud);
  orient(flipped);
  EXPECT_TRUE(cloud.normal == flipped.normal);
}

TEST(Orientation, GivesTheSameBytesForAnyNumberOfThreads) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::double_torus, 20000, 8));
  PointCloud same = cloud;
  orient(cloud);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  orient(same);
  EXPECT_TRUE(cloud.normal == same.normal);
  for (Index i = 0; i < cloud.size(); ++i) {
    ASSERT_EQ(cloud.plane[i].point, same.plane[i].point);
    ASSERT_EQ(cloud.plane[i].normal, same.plane[i].normal);
  }
}

TEST(Orientation, PlanesLieOnTheSurface) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::sphere, 8000, 9));
  orient(cloud);
  for (Index i = 0; i < cloud.size(); ++i) {
    const TangentPlane& plane = cloud.plane[i];
    ASSERT_NEAR(plane.normal.norm(), 1.0f, 1e-4f);
    const Vec3 p = cloud.frame.to_input(plane.point.cast<double>());
    ASSERT_NEAR(p.norm(), 1.0, 4e-3);  // a fifth of the spacing: the mean lies within
    ASSERT_GT(plane.normal.dot(p.normalized().cast<float>()), 0.995f);
  }
}

TEST(Orientation, BearsAnything) {
  Random random(10);
  std::vector<std::vector<Vec3>> clouds = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (Index count : {5, 17, 40, 2000}) {
    clouds.emplace_back();
    for (Index i = 0; i < count; ++i) clouds.back().push_back(random.in_cube());
  }
  clouds.push_back(clouds.back());
  clouds.back().emplace_back(1e6, 0, 0);  // a far outlier
  clouds.emplace_back();                  // a line of points with one beside it, and one far away
  for (int i = 0; i < 300; ++i) clouds.back().emplace_back(i, 0, 0);
  clouds.back().emplace_back(0, 1, 0);
  clouds.back().emplace_back(0, 0, 50);
  for (const auto& points : clouds) {
    PointCloud cloud = prepared_cloud(points);
    const OrientationReport report = orient(cloud);
    EXPECT_GE(report.components, 1);
    for (Index i = 0; i < cloud.size(); ++i) {
      ASSERT_NEAR(cloud.normal[i].norm(), 1.0f, 1e-4f);
      ASSERT_NEAR(cloud.plane[i].normal.norm(), 1.0f, 1e-4f);
      ASSERT_TRUE(cloud.plane[i].point.allFinite());
    }
  }
}

TEST(Orientation, CanBeCancelled) {
  PointCloud cloud = prepared_cloud(sample_shape(ShapeKind::sphere, 1000, 1));
  Progress progress([](double, const char*) { return false; }, {Stage::orientation});
  EXPECT_THROW(orient_normals(cloud, OrientationOptions(), progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
