#include "neighbour_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

struct Oriented {
  Vec3 position, normal;
};

// Two samples one spacing apart in the mean, and how far those of the cloud deviate from planes.
float agreement_of(const Oriented& a, const Oriented& b, float deviation = 0.0f) {
  PointCloud cloud;
  for (const Oriented& sample : {a, b}) {
    cloud.position.push_back(sample.position);
    cloud.normal.push_back(sample.normal.cast<float>());
    cloud.local_spacing.push_back(1.0f);
    cloud.deviation.push_back(deviation);
  }
  return SideAgreement(cloud)(0, 1);
}

TEST(SideAgreement, IsOneAlongAnyArc) {
  const auto on_circle = [](double angle) {
    const Vec3 radius(std::cos(angle), std::sin(angle), 0.0);
    return Oriented{radius, radius};
  };
  for (const double angle : {0.1, 1.0, 0.5 * kPi, 2.5, kPi})
    EXPECT_NEAR(agreement_of(on_circle(0.3), on_circle(0.3 + angle)), 1.0, 1e-6) << angle;
}

TEST(SideAgreement, TellsSheetsFaceToFaceApart) {
  const Vec3 up = Vec3::UnitZ();
  EXPECT_NEAR(agreement_of({Vec3::Zero(), up}, {up, up}), -1.0, 1e-6);
  EXPECT_NEAR(agreement_of({Vec3::Zero(), -up}, {up, up}), 1.0, 1e-6) << "the sides of a plate";
  EXPECT_NEAR(agreement_of({Vec3::Zero(), up}, {Vec3::UnitX(), up}), 1.0, 1e-6);
  EXPECT_NEAR(agreement_of({Vec3::Zero(), up}, {Vec3::UnitX(), -up}), -1.0, 1e-6);
}

TEST(SideAgreement, SeesNoHeightInNoise) {
  const Oriented low = {Vec3::Zero(), Vec3::UnitZ()}, high = {Vec3(0.3, 0.0, 0.4), Vec3::UnitZ()};
  EXPECT_LT(agreement_of(low, high), -0.25);
  EXPECT_NEAR(agreement_of(low, high, 0.4f), 1.0, 1e-6);
  EXPECT_EQ(agreement_of(low, {low.position, Vec3::UnitZ()}), 1.0f) << "samples at one place";
}

TEST(NeighbourEdges, ComeOnceEach) {
  Progress silent;
  const PointCloud cloud =
      prepare_samples(sample_shape(ShapeKind::blob, 500, 1), SampleOptions(), silent);
  constexpr int kNeighbours = 7;
  std::set<std::pair<Index, Index>> edges, expected;
  for (Index a = 0; a < cloud.size(); ++a) {
    for_each_edge_of(cloud, kNeighbours, a, [&](Index b) {
      EXPECT_TRUE(edges.insert(std::minmax(a, b)).second) << a << " " << b;
    });
    for (int place = 1; place <= kNeighbours; ++place)
      expected.insert(std::minmax(a, cloud.neighbours_of(a)[place]));
  }
  EXPECT_EQ(edges, expected);
}

}  // namespace
}  // namespace shrinkwrap::testing
