#include "orientation/neighbour_graph.h"

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

// The graph of samples that are all neighbours of each other, one spacing apart in the mean.
struct SmallGraph {
  explicit SmallGraph(const std::vector<Oriented>& samples) {
    const auto count = static_cast<Index>(samples.size());
    cloud.neighbour_count = count;
    for (Index i = 0; i < count; ++i) {
      cloud.position.push_back(samples[i].position);
      cloud.normal.push_back(samples[i].normal.cast<float>());
      cloud.local_spacing.push_back(1.0f);
      for (Index k = 0; k < count; ++k) cloud.neighbour.push_back((i + k) % count);
    }
  }
  NeighbourGraph graph() const {
    Progress silent;
    return NeighbourGraph(cloud, 10, silent);
  }

  PointCloud cloud;
};

float agreement_of(const Oriented& a, const Oriented& b) {
  return SmallGraph({a, b}).graph().agreement(0, 1);
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

TEST(SideAgreement, OfSamplesAtOnePlaceIsTheirCosine) {
  const Vec3 up = Vec3::UnitZ();
  EXPECT_EQ(agreement_of({Vec3::Zero(), up}, {Vec3::Zero(), up}), 1.0f);
  EXPECT_EQ(agreement_of({Vec3::Zero(), up}, {Vec3::Zero(), -up}), -1.0f);
}

TEST(SideAgreement, IsLessSureOfHeightsInNoise) {
  const Vec3 up = Vec3::UnitZ();
  const Oriented low = {Vec3::Zero(), up}, high = {Vec3(0.3, 0.0, 0.4), up};
  std::vector<Oriented> scattered = {low, high};
  for (const double height : {-0.6, -0.2, 0.6, 1.0}) scattered.push_back({height * up, up});
  EXPECT_NEAR(agreement_of(low, high), 1.0 - 2.0 * 0.64, 1e-6);
  const SmallGraph noisy(scattered);
  const NeighbourGraph graph = noisy.graph();
  ASSERT_GT(graph.noise(), 0.4f);
  EXPECT_GT(graph.agreement(0, 1), 0.1f);
  EXPECT_LT(graph.agreement(0, 1), 0.5f);
}

// A grid of samples one unit apart, at the heights that a function says.
template <class Height>
PointCloud grid_of(const Height& height) {
  std::vector<Vec3> points;
  for (int x = 0; x < 60; ++x)
    for (int y = 0; y < 60; ++y) points.emplace_back(x, y, height(x, y));
  Progress silent;
  return prepare_samples(points, SampleOptions(), silent);
}

TEST(NeighbourGraph, TakesTheSidesOfAPlateForNoNoise) {
  constexpr double kDeviation = 0.4, kThickness = 0.8;
  Random random(3);
  Progress silent;
  const PointCloud noisy = grid_of([&](int, int) { return kDeviation * random.gaussian(); });
  const PointCloud plate =
      grid_of([](int x, int y) { return (x + y) % 2 == 0 ? 0.0 : kThickness; });
  const float noise = NeighbourGraph(noisy, 10, silent).noise();
  EXPECT_GT(noise, 0.5 * kDeviation);
  EXPECT_LT(noise, 1.5 * kDeviation);
  EXPECT_LT(NeighbourGraph(plate, 10, silent).noise(), 0.25 * kThickness);
}

// Of the edges more upright than level, how many do not take their ends for opposite sides.
double share_of_level_sides(const PointCloud& cloud, const NeighbourGraph& graph) {
  double upright = 0.0, same = 0.0;
  for (Index a = 0; a < cloud.size(); ++a)
    graph.for_each_edge_of(a, [&](Index b) {
      const Vec3 d = (cloud.position[a] - cloud.position[b]).normalized();
      const Vec3f &n = cloud.normal[a], &m = cloud.normal[b];
      if (std::abs(d.z()) < 0.8 || std::abs(n.z()) < 0.9f || std::abs(m.z()) < 0.9f) return;
      ++upright;
      same += (graph.agreement(a, b) > 0.0f) == (n.dot(m) > 0.0f);
    });
  EXPECT_GT(upright, 20.0);
  return same / upright;
}

// Blocks that stand on a plane, their walls unseen; and two planes as far apart.
TEST(NeighbourGraph, TellsStepsFromPlates) {
  constexpr double kHeight = 2.0;
  Random random(5);
  std::vector<Vec3> blocks, plate;
  for (int x = 0; x < 60; ++x)
    for (int y = 0; y < 60; ++y) {
      const bool is_top = x / 6 % 2 == 1 && y / 6 % 2 == 1;
      const double at_x = x + random.uniform(-0.3, 0.3), at_y = y + random.uniform(-0.3, 0.3);
      blocks.emplace_back(at_x, at_y, is_top ? kHeight : 0.0);
      for (const double z : {0.0, kHeight})
        plate.emplace_back(60.0 * random.uniform(), 60.0 * random.uniform(), z);
    }
  Progress silent;
  const PointCloud steps = prepare_samples(blocks, SampleOptions(), silent);
  const NeighbourGraph of_steps(steps, 10, silent);
  EXPECT_TRUE(of_steps.has_steps());
  EXPECT_GT(share_of_level_sides(steps, of_steps), 0.9);
  const PointCloud sides = prepare_samples(plate, SampleOptions(), silent);
  const NeighbourGraph of_plate(sides, 10, silent);
  EXPECT_FALSE(of_plate.has_steps());
  EXPECT_LT(share_of_level_sides(sides, of_plate), 0.1);
}

TEST(NeighbourGraph, GivesEachEdgeOnce) {
  Progress silent;
  const PointCloud cloud =
      prepare_samples(sample_shape(ShapeKind::blob, 500, 1), SampleOptions(), silent);
  constexpr int kNeighbours = 7;
  const NeighbourGraph graph(cloud, kNeighbours, silent);
  std::set<std::pair<Index, Index>> edges, expected;
  for (Index a = 0; a < cloud.size(); ++a) {
    graph.for_each_edge_of(
        a, [&](Index b) { EXPECT_TRUE(edges.insert(std::minmax(a, b)).second) << a << " " << b; });
    for (int place = 1; place <= kNeighbours; ++place)
      expected.insert(std::minmax(a, cloud.neighbours_of(a)[place]));
  }
  EXPECT_EQ(edges, expected);
}

TEST(NeighbourGraph, HasNoMoreNeighboursThanTheCloud) {
  Progress silent;
  const PointCloud cloud =
      prepare_samples(sample_shape(ShapeKind::sphere, 40, 1), SampleOptions(), silent);
  EXPECT_EQ(NeighbourGraph(cloud, 1000, silent).neighbours(), cloud.neighbour_count - 1);
  EXPECT_EQ(NeighbourGraph(cloud, -3, silent).neighbours(), 1);
}

}  // namespace
}  // namespace shrinkwrap::testing
