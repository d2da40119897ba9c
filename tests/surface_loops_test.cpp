// Loops on a torus: around its tube, along it, and cuts along them.
#include "mesh/surface_loops.h"

#include <gtest/gtest.h>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

constexpr int kAlong = 40, kAround = 10;  // edges

// Around the tube, at a place along it.
Loop around(int place) {
  Loop loop;
  for (Index j = 0; j < kAround; ++j) loop.push_back(place * kAround + j);
  return loop;
}
Loop along() {
  Loop loop;
  for (Index i = 0; i < kAlong; ++i) loop.push_back(i * kAround);
  return loop;
}

class SurfaceLoops : public ::testing::Test {
 protected:
  SurfaceMesh torus = torus_mesh(kAlong, kAround);
  Progress silent;
};

TEST_F(SurfaceLoops, ThroughAVertexThereAreTwoOnATorus) {
  for (const Index root : {0, 7, 123}) {
    const std::vector<Loop> loops = loops_from(torus, {root}, silent);
    ASSERT_EQ(loops.size(), 2u);
    EXPECT_EQ(loops[0].size(), static_cast<std::size_t>(kAround));
    EXPECT_EQ(loops[1].size(), static_cast<std::size_t>(kAlong));
    for (const Loop& loop : loops)
      for (std::size_t i = 0; i < loop.size(); ++i)
        EXPECT_NE(torus.find_halfedge(loop[i], loop[(i + 1) % loop.size()]), kNone);
  }
  EXPECT_TRUE(loops_from(icosphere(2), {0}, silent).empty());
}

TEST_F(SurfaceLoops, ABallIsADiscUntilItMeetsItself) {
  PathTree tree(torus);
  for (Index radius = 1; radius <= 8; ++radius) {
    ASSERT_TRUE(tree.grow(torus, {55}, radius, torus.position.size(), silent));
    const bool is_disc = radius < kAround / 2;
    EXPECT_EQ(tree.is_disc(torus), is_disc) << radius;
    const Loop loop = loop_in_ball(torus, tree, 55, radius, silent);
    EXPECT_EQ(loop.size(), is_disc ? 0u : static_cast<std::size_t>(kAround)) << radius;
  }
  EXPECT_FALSE(tree.grow(torus, {55}, 8, 50, silent)) << "there are more than 50 vertices so near";
}

TEST_F(SurfaceLoops, DisjointOnesShareNoVertex) {
  DisjointLoops disjoint(torus, 3);
  for (const Loop& loop :
       {around(3), along(), Loop(), around(3), around(9), around(20), around(30)})
    disjoint.add(loop);
  EXPECT_EQ(disjoint.loops, (std::vector<Loop>{around(3), around(9), around(20)}));
}

TEST_F(SurfaceLoops, OfThoseThatSeparateOneIsLeftOut) {
  std::vector<Loop> loops = {around(3)};
  keep_inseparable(torus, loops, silent);
  EXPECT_EQ(loops, (std::vector<Loop>{around(3)}));
  // Around the tube, with a detour: longer.
  Loop detour = around(20);
  detour.insert(detour.begin() + 1, 21 * kAround + 1);
  for (const Loop& first : {around(3), detour}) {
    loops = {first, first == detour ? around(3) : detour};
    keep_inseparable(torus, loops, silent);
    EXPECT_EQ(loops, (std::vector<Loop>{first}));
  }
  loops = {detour, around(3)};
  sort_by_length(loops);
  EXPECT_EQ(loops, (std::vector<Loop>{around(3), detour}));
}

TEST_F(SurfaceLoops, MouthsPartCavitiesNotBodies) {
  const std::vector<Loop> both = {around(3), around(20)};
  const auto mouths = [&](const SurfaceMesh& mesh, std::vector<Loop> loops, Index least) {
    keep_mouths_of_cavities(mesh, loops, std::vector<Index>(mesh.position.size(), 1), least,
                            silent);
    return loops.size();
  };
  EXPECT_EQ(mouths(torus, both, 1), 0u) << "two bodies";
  // The wall of a hollow ball, and a hole through it.
  const SurfaceMesh outside = icosphere(3), inside = icosphere(2);
  std::vector<Vec3> position = outside.position;
  std::vector<Triangle> triangles = outside.triangles();
  const auto count = static_cast<Index>(position.size());
  for (const Vec3& p : inside.position) position.emplace_back(0.8 * p);
  for (const Triangle& t : inside.triangles())
    triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
  const Triangle outer = triangles[0], inner = triangles[outside.triangles().size()];
  triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(outside.triangles().size()));
  triangles.erase(triangles.begin());
  for (int k = 0; k < 3; ++k) {
    // The inner one runs the other way.
    const Index a = outer[k], b = outer[(k + 1) % 3];
    const Index c = inner[(3 - k) % 3], d = inner[2 - k];
    triangles.push_back({a, b, d});
    triangles.push_back({a, d, c});
  }
  const SurfaceMesh hollow = SurfaceMesh::from_triangles(position, triangles, silent);
  expect_closed_manifold(hollow, 1, 0);
  const Loop rim(outer.begin(), outer.end());
  const Index of_inside = static_cast<Index>(inside.position.size());
  EXPECT_EQ(mouths(hollow, {rim}, 1), 1u);
  EXPECT_EQ(mouths(hollow, {rim}, of_inside - 3), 1u);
  EXPECT_EQ(mouths(hollow, {rim}, of_inside + 4), 0u) << "too few samples";
}

TEST_F(SurfaceLoops, CutsCloseBothSides) {
  const Index vertices = torus.vertex_count();
  cut_along(torus, {around(3)}, silent);
  EXPECT_TRUE(torus.is_consistent());
  expect_closed_manifold(torus, 1, 0);
  EXPECT_EQ(torus.vertex_count(), vertices + kAround + 2);
  SurfaceMesh other = torus_mesh(kAlong, kAround);
  cut_along(other, {around(3), around(20)}, silent);
  expect_closed_manifold(other, 2, 0);
}

}  // namespace
}  // namespace shrinkwrap::testing
