#include "shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "geometry/voxel_search.h"

namespace shrinkwrap::testing {
namespace {

TEST(Random, IsTheSameEverywhere) {
  // The 10,000th number of a default mt19937_64 is given by the standard.
  Random random(5489);
  for (int i = 1; i < 10000; ++i) random.uniform();
  EXPECT_EQ(random.uniform(), static_cast<double>(9981545732273789042ull >> 11) * 0x1p-53);
}

TEST(Random, StaysInRange) {
  Random random(3);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Index k = random.below(7);
    ASSERT_TRUE(0 <= k && k < 7);
    ASSERT_NEAR(random.direction().norm(), 1.0, 1e-12);
    const double g = random.gaussian();
    sum += g;
    squares += g * g;
  }
  EXPECT_NEAR(sum / 20000, 0.0, 0.03);
  EXPECT_NEAR(squares / 20000, 1.0, 0.05);
}

class EveryShape : public ::testing::TestWithParam<ShapeKind> {};

TEST_P(EveryShape, SamplesLieOnTheSurface) {
  const Shape shape = shape_of(GetParam());
  const auto points = sample_shape(GetParam(), 2000, 1);
  ASSERT_EQ(points.size(), 2000u);
  for (const Vec3& p : points) {
    EXPECT_NEAR(shape.implicit(p), 0.0, 1e-12);
    EXPECT_LT(p.norm(), shape.radius);
    EXPECT_TRUE(shape.closed || p.z() >= 0.0);
  }
}

// A gradient above 1 would let rays step over the surface.
TEST_P(EveryShape, ImplicitFunctionIsLipschitz) {
  const Shape shape = shape_of(GetParam());
  Random random(17);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = shape.radius * random.in_cube(), q = p + 0.01 * random.direction();
    ASSERT_LE(std::abs(shape.implicit(p) - shape.implicit(q)), 0.01 * 1.02);
  }
}

TEST_P(EveryShape, NormalsPointOutwards) {
  const Shape shape = shape_of(GetParam());
  for (const Vec3& p : sample_shape(GetParam(), 500, 2)) {
    const Vec3 normal = shape.normal(p);
    EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
    EXPECT_GT(shape.implicit(p + 1e-3 * normal), 0.0);
    EXPECT_LT(shape.implicit(p - 1e-3 * normal), 0.0);
  }
}

TEST_P(EveryShape, SeedsDecide) {
  for (const auto sample : {sample_shape, sample_shape_blue_noise}) {
    const auto first = sample(GetParam(), 300, 5, {}), again = sample(GetParam(), 300, 5, {}),
               other = sample(GetParam(), 300, 6, {});
    EXPECT_TRUE(std::equal(first.begin(), first.end(), again.begin(), again.end()));
    EXPECT_FALSE(std::equal(first.begin(), first.end(), other.begin(), other.end()));
  }
}

// Samples closer than that would make the distance of blue noise meaningless; random ones are.
TEST_P(EveryShape, BlueNoiseKeepsItsDistance) {
  const auto nearest_pair = [](const std::vector<Vec3>& points) {
    const VoxelSearch search(points);
    double least = 1e300;
    std::vector<VoxelSearch::Hit> hits;
    for (const Vec3& p : points) {
      search.k_nearest(p, 2, hits);
      least = std::min(least, hits[1].squared_distance);
    }
    return std::sqrt(least);
  };
  const auto even = sample_shape_blue_noise(GetParam(), 1000, 4);
  ASSERT_EQ(even.size(), 1000u);
  EXPECT_GT(nearest_pair(even), 5.0 * nearest_pair(sample_shape(GetParam(), 1000, 4)));
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape, ::testing::ValuesIn(all_shapes()),
                         [](const auto& kind) { return shape_of(kind.param).name; });

TEST(SampleImplicit, IsUniformByArea) {
  Random random(8);
  const Shape box = shape_of(ShapeKind::box);
  const ImplicitSamples samples =
      sample_implicit([&](const Vec3& p) { return box.implicit(p); }, box.domain(), 40000, random);
  const double area = 2.0 * (1.2 * 0.9 + 0.9 * 0.7 + 0.7 * 1.2);
  EXPECT_NEAR(samples.area, area, 0.02 * area);
  const auto on_top = std::count_if(samples.points.begin(), samples.points.end(),
                                    [](const Vec3& p) { return p.z() > 0.35 - 1e-9; });
  EXPECT_NEAR(on_top / 40000.0, 1.2 * 0.9 / area, 0.01);
}

TEST(SampleShape, AppliesDefects) {
  const auto off_surface = [](const SampleDefects& defects) {
    const auto points = sample_shape(ShapeKind::sphere, 4000, 9, defects);
    return std::count_if(points.begin(), points.end(),
                         [](const Vec3& p) { return std::abs(p.norm() - 1.0) > 1e-9; });
  };
  SampleDefects defects;
  defects.rotated = true;
  EXPECT_EQ(off_surface(defects), 0);
  defects.outliers = 0.1;
  EXPECT_NEAR(static_cast<double>(off_surface(defects)), 400.0, 80.0);
  defects.noise = 0.2;
  EXPECT_GT(off_surface(defects), 3900);
}

TEST(Icosphere, IsASphere) {
  const SurfaceMesh mesh = icosphere(3);
  EXPECT_EQ(mesh.vertex_count(), 642);
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_NEAR(signed_volume(mesh), 4.18879, 0.05);
  EXPECT_GT(normal_consistency(mesh, shape_of(ShapeKind::sphere)), 0.999);
}

TEST(TorusMesh, IsATorus) {
  const SurfaceMesh mesh = torus_mesh(40, 20);
  EXPECT_EQ(mesh.vertex_count(), 800);
  expect_closed_manifold(mesh, 1, 1);
  EXPECT_NEAR(signed_volume(mesh), 2.0 * 9.8696 * 0.75 * 0.0625, 0.05);
  EXPECT_GT(normal_consistency(mesh, shape_of(ShapeKind::torus)), 0.99);
}

TEST(Topology, CountsWhatIsWrong) {
  const std::vector<Triangle> tetrahedron = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  EXPECT_TRUE(topology_of(4, tetrahedron).closed_manifold());
  EXPECT_EQ(topology_of(4, tetrahedron).genus(), 0);

  auto open = tetrahedron;
  open.pop_back();
  EXPECT_EQ(topology_of(4, open).bad_edges, 3);
  EXPECT_EQ(topology_of(4, open).bad_vertices, 3);

  auto turned = tetrahedron;
  std::swap(turned[0][0], turned[0][1]);
  EXPECT_EQ(topology_of(4, turned).bad_edges, 3);

  auto pinched = tetrahedron;  // two tetrahedra that share vertex 0
  for (Triangle t : tetrahedron) {
    for (Index& v : t) v = v == 0 ? 0 : v + 3;
    pinched.push_back(t);
  }
  EXPECT_EQ(topology_of(7, pinched).bad_edges, 0);
  EXPECT_EQ(topology_of(7, pinched).bad_vertices, 1);

  auto apart = tetrahedron;
  for (Triangle t : tetrahedron) {
    for (Index& v : t) v += 4;
    apart.push_back(t);
  }
  EXPECT_TRUE(topology_of(8, apart).closed_manifold());
  EXPECT_EQ(topology_of(8, apart).components, 2);
  EXPECT_EQ(topology_of(8, apart).genus(), 0);

  auto repeated = tetrahedron;
  repeated.push_back({0, 0, 1});
  EXPECT_EQ(topology_of(4, repeated).bad_faces, 1);
}

}  // namespace
}  // namespace shrinkwrap::testing
