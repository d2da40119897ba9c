#include "samples/tangent_target.h"

#include <gtest/gtest.h>

#include <cmath>

#include "orientation/orientation.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::Random;
using testing::sample_shape;
using testing::sample_shape_blue_noise;
using testing::shape_of;
using testing::ShapeKind;

struct Fixture {
  explicit Fixture(const std::vector<Vec3>& points) {
    Progress silent;
    cloud = prepare_samples(points, SampleOptions(), silent);
    orient_normals(cloud, OrientationOptions(), silent);
  }
  Vec3 unit(const Vec3& p) const { return cloud.frame.to_unit(p); }
  Vec3 input(const Vec3& p) const { return cloud.frame.to_input(p); }
  double spacing() const { return cloud.frame.to_input_length(cloud.spacing); }

  PointCloud cloud;
};

TEST(TangentTarget, IsOnTheSurface) {
  const Fixture sphere(sample_shape_blue_noise(ShapeKind::sphere, 4000, 1));
  const TangentTarget targets(sphere.cloud);
  Random random(2);
  int membranes = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 normal = random.direction();
    const Vec3 query = sphere.unit(normal * (1.0 + sphere.spacing() * random.uniform(-1.5, 1.5)));
    const auto target = targets.find(query, normal, query, kNone);
    membranes += target.is_membrane;
    if (target.is_membrane) {
      EXPECT_EQ(target.point, query);
    } else {
      EXPECT_NEAR(sphere.input(target.point).norm(), 1.0, 0.15 * sphere.spacing());
    }
  }
  EXPECT_EQ(membranes, 0);
}

TEST(TangentTarget, HintLeadsToTheSameTarget) {
  const Fixture torus(sample_shape(ShapeKind::torus, 6000, 3));
  const TangentTarget targets(torus.cloud);
  Random random(4);
  int same = 0;
  for (int i = 0; i < 500; ++i) {
    const Index sample = random.below(torus.cloud.size());
    const Vec3 normal = torus.cloud.normal[sample].cast<double>();
    const Vec3 query =
        torus.cloud.position[sample] + 0.5 * torus.cloud.spacing * random.direction();
    const auto full = targets.find(query, normal, query, kNone);
    const Index hint = torus.cloud.neighbours_of(full.nearest)[random.below(16)];
    same += targets.find(query, normal, query, hint).nearest == full.nearest;
  }
  EXPECT_GT(same, 480);  // a walk may stop at a local minimum
}

// The two sides of a plate are nearer to each other than many a vertex is to its own side.
TEST(TangentTarget, KeepsTheSidesOfAThinPlateApart) {
  Random random(5);
  std::vector<Vec3> points;
  for (int x = -20; x <= 20; ++x)  // two layers, about a spacing apart
    for (int y = -20; y <= 20; ++y)
      for (double z : {-0.03, 0.03})
        points.emplace_back(0.05 * x + random.uniform(-0.01, 0.01),
                            0.05 * y + random.uniform(-0.01, 0.01), z);
  const Fixture plate(points);
  PointCloud cloud = plate.cloud;  // normals by construction: the layers are too close to tell
  Progress silent;
  for (Index i = 0; i < cloud.size(); ++i) {
    const float side = plate.input(cloud.position[i]).z() > 0.0 ? 1.0f : -1.0f;
    cloud.normal[i] = side * Vec3f::UnitZ();
    cloud.plane[i] = {cloud.position[i].cast<float>(), cloud.normal[i]};
  }
  TangentTargetOptions options;
  options.off_centre = 10.0;  // no fading
  options.beyond_rim = 20.0;
  const TangentTarget targets(cloud, options);
  for (int i = 0; i < 300; ++i) {
    const Vec3 query(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8),
                     random.uniform(-0.06, 0.06));
    const auto up = targets.find(plate.unit(query), Vec3::UnitZ(), plate.unit(query), kNone);
    const auto down = targets.find(plate.unit(query), -Vec3::UnitZ(), plate.unit(query), kNone);
    const auto height = [&](const TangentTarget::Target& target, double of_membranes) {
      return target.is_membrane ? of_membranes : plate.input(target.point).z();
    };
    EXPECT_NEAR(height(up, 0.03), 0.03, 1e-5);
    EXPECT_NEAR(height(down, -0.03), -0.03, 1e-5);
    EXPECT_GT(cloud.normal[up.nearest].z(), 0.0f);
    EXPECT_LT(cloud.normal[down.nearest].z(), 0.0f);
  }
}

TEST(TangentTarget, FindsMembranes) {
  const Fixture cap(sample_shape(ShapeKind::hemisphere, 8000, 6));
  const TangentTarget targets(cap.cloud);
  const auto is_membrane = [&](const Vec3& query, const Vec3& normal) {
    return targets.find(cap.unit(query), normal, cap.unit(query), kNone).is_membrane;
  };
  // Walk down the sphere along a meridian: on the cap no membrane, beyond the rim all membrane.
  double rim = 2.0;  // height of the lowest sample
  for (const Vec3& p : cap.cloud.position) rim = std::min(rim, cap.input(p).z());
  int on_cap = 0, beyond = 0;
  for (int i = 0; i < 100; ++i) {
    const double angle = 0.0628 * i;
    const auto at_height = [&](double z) {
      const double r = std::sqrt(1.0 - z * z);
      return Vec3(r * std::cos(angle), r * std::sin(angle), z);
    };
    const Vec3 inner = at_height(rim + 6.0 * cap.spacing());
    on_cap += is_membrane(inner, inner);
    const Vec3 outer = at_height(std::max(-1.0, rim - 1.2 * cap.spacing()));
    beyond += is_membrane(outer, outer);
  }
  EXPECT_LE(on_cap, 4);
  EXPECT_GE(beyond, 96);
  EXPECT_TRUE(is_membrane({0, 0, 0.3}, -Vec3::UnitZ()));                  // far from all samples
  EXPECT_TRUE(is_membrane({0, 0, 1.0}, -Vec3::UnitZ()));                  // against all normals
  EXPECT_FALSE(is_membrane({0, 0, 1.0 - cap.spacing()}, Vec3::UnitZ()));  // the cap itself
}

// From the plane to the centroid of the one-ring, without a jump, as the query leaves the data.
TEST(TangentTarget, FadesTowardsTheCentroidAtTheRim) {
  std::vector<Vec3> points;
  for (int x = -20; x <= 0; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(x, y, 0.0);
  points.emplace_back(-10, 0, -8);
  Fixture half_plane(points);
  for (Index i = 0; i < half_plane.cloud.size(); ++i) {
    half_plane.cloud.normal[i] = Vec3f::UnitZ();
    half_plane.cloud.plane[i] = {half_plane.cloud.position[i].cast<float>(), Vec3f::UnitZ()};
  }
  const TangentTarget targets(half_plane.cloud);
  double last = 0.0;
  bool faded = false, ended = false;
  for (double x = -5.0; x < 4.0; x += 0.01) {
    const Vec3 query(x, 0.1, 1.0), centroid(x, 0.1, 2.0);
    const auto target =
        targets.find(half_plane.unit(query), Vec3::UnitZ(), half_plane.unit(centroid), kNone);
    if (target.is_membrane) {
      ended = true;
      continue;
    }
    EXPECT_FALSE(ended) << x;
    const double height = half_plane.input(target.point).z();
    EXPECT_NEAR(height, last, 0.5) << x;
    faded = faded || (height > 0.1 && height < 1.9);
    last = height;
  }
  EXPECT_TRUE(faded);
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace shrinkwrap
