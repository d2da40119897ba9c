// Edge optimisation, last step: of two diagonals the one nearer to the surface.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "edge_optimisation/edge_optimisation.h"
#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::expect_closed_manifold;
using testing::Random;

// Only the tangent planes choose, wherever diagonals differ.
EdgeOptimisationOptions planes_alone() {
  EdgeOptimisationOptions options;
  options.least_gain = 1e30;
  options.crease_angle = 0.0;
  options.least_gap = 0.0;
  return options;
}

// Two faces over the corners (+-1, 0) and (0, +-1) of a square, with an edge between the latter, in
// a narrow ring of faces that falls off as steeply as `slope` says for each corner, over an apex
// below. Whether the edge goes between the former after all.
bool goes_across(const std::array<double, 4>& height, const std::array<double, 4>& slope) {
  constexpr double kRing = 1.02;
  const std::array<Vec3, 4> corner = {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0)};
  std::vector<Vec3> positions;
  for (int n = 0; n < 4; ++n) positions.push_back(corner[n] + Vec3(0, 0, height[n]));
  for (int n = 0; n < 4; ++n)
    positions.push_back(kRing * corner[n] + Vec3(0, 0, height[n] - (kRing - 1.0) * slope[n]));
  positions.emplace_back(0, 0, -2);
  std::vector<Triangle> triangles = {{0, 1, 3}, {1, 2, 3}};
  std::vector<Index> around;
  const auto add = [&](const Triangle& t) {
    around.push_back(static_cast<Index>(triangles.size()));
    triangles.push_back(t);
  };
  for (int n = 0; n < 4; ++n) {
    const int next = (n + 1) % 4;
    add({n, 4 + n, 4 + next});
    add({n, 4 + next, next});
    add({4 + n, 8, 4 + next});
  }
  SurfaceMesh mesh = SurfaceMesh::from_triangles(std::move(positions), triangles);
  expect_closed_manifold(mesh, 1, 0);
  Progress progress;
  return optimise_edges(mesh, planes_alone(), progress, around).flips == 1;
}

TEST(NearerDiagonal, TellsTheSurfaceByTheFacesAround) {
  // The hinge is hollow, and its own faces are far larger than the others; these fall off on all
  // sides, as around a hilltop, or rise, as around a hollow.
  EXPECT_TRUE(goes_across({0.1, 0.0, 0.1, 0.0}, {0.5, 0.5, 0.5, 0.5}));
  EXPECT_FALSE(goes_across({0.1, 0.0, 0.1, 0.0}, {-0.5, -0.5, -0.5, -0.5}));
}

TEST(NearerDiagonal, TurnsOnlyToWhereTheSurfaceClearlyIs) {
  // Saddles, a gap of 0.1 between the diagonals, the surface so high over its middle.
  const auto turns = [](double over_middle) {
    const double slope = 2.0 * over_middle;
    return goes_across({0.1, 0.0, 0.1, 0.0}, {slope - 0.1, slope + 0.1, slope - 0.1, slope + 0.1});
  };
  EXPECT_FALSE(turns(-0.05));
  EXPECT_FALSE(turns(0.01));
  EXPECT_TRUE(turns(0.02));
}

// A round bar, three samples around: rings of three, one turned against the next. Edges within
// the rings cut through it, edges along it lie on it.
TEST(NearerDiagonal, SeesThatALimbIsRound) {
  constexpr int kRings = 12;
  std::vector<Vec3> positions;
  for (int ring = 0; ring < kRings; ++ring)
    for (int n = 0; n < 3; ++n) {
      const double angle = (n + 0.5 * (ring % 2)) * 2.0 * kPi / 3.0;
      positions.emplace_back(std::cos(angle), std::sin(angle), 0.8 * ring);
    }
  std::vector<Triangle> triangles = {{0, 2, 1}, {3 * kRings - 3, 3 * kRings - 2, 3 * kRings - 1}};
  for (int ring = 0; ring + 1 < kRings; ++ring)
    for (int n = 0; n < 3; ++n) {
      const auto below = [&](int k) { return 3 * ring + (n + k) % 3; };
      const auto above = [&](int k) { return 3 * ring + 3 + (n + k) % 3; };
      const int shift = ring % 2;  // above(shift) is a sixth of a turn farther than below(0)
      triangles.push_back({below(0), below(1), above(shift)});
      triangles.push_back({below(1), above(shift + 1), above(shift)});
    }
  SurfaceMesh mesh = SurfaceMesh::from_triangles(std::move(positions), triangles);
  expect_closed_manifold(mesh, 1, 0);
  Progress progress;
  optimise_edges(mesh, planes_alone(), progress);
  for (int v = 3; v + 9 < 3 * kRings; ++v) {
    bool is_along = false;
    mesh.for_each_outgoing(v, [&](Index h) { is_along |= mesh.target(h) == v + 6; });
    EXPECT_TRUE(is_along) << v;
  }
}

SurfaceMesh rough_torus(double noise) {
  Random random(23);
  SurfaceMesh mesh = testing::torus_mesh(60, 24);
  for (Vec3& p : mesh.position) p += noise * random.in_cube();
  return mesh;
}

// Each flip changes the planes of the hinges around: some would take turns for ever.
TEST(NearerDiagonal, ComesToAnEnd) {
  SurfaceMesh mesh = rough_torus(0.01);
  Progress progress;
  const Index flips = optimise_edges(mesh, planes_alone(), progress).flips;
  EXPECT_GT(flips, 500);
  EXPECT_LT(flips, mesh.halfedge_slots() / 8);
}

TEST(NearerDiagonal, LeavesRoughSurfacesAlone) {
  EdgeOptimisationOptions options = planes_alone();
  options.least_gap = 0.03;
  Progress progress;
  SurfaceMesh mesh = rough_torus(0.08), other = mesh;
  EXPECT_EQ(optimise_edges(mesh, options, progress).flips, 0);
  options.rough_gap = 1.0;
  EXPECT_GT(optimise_edges(other, options, progress).flips, 0);
}

}  // namespace
}  // namespace shrinkwrap
