// Exact signs, pairs of triangles, and the search for pairs of faces that meet.
#include "mesh/self_intersection.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "expect_mesh.h"
#include "geometry/exact_predicates.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::crossing_spheres;
using testing::faces_of_pairs;
using testing::icosphere;
using testing::joined;
using testing::placed;
using testing::Random;
using testing::torus_mesh;
using Pair = std::pair<Index, Index>;

// --- a judge of its own: integers, and the definition ------------------------------------------

struct Lattice {
  std::int64_t x, y, z;
};
Lattice operator-(const Lattice& p, const Lattice& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}
Lattice cross(const Lattice& p, const Lattice& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
std::int64_t dot(const Lattice& p, const Lattice& q) {
  return p.x * q.x + p.y * q.y + p.z * q.z;
}
bool is_zero(const Lattice& p) {
  return p.x == 0 && p.y == 0 && p.z == 0;
}

using LatticeTriangle = std::array<Lattice, 3>;
Lattice normal_of(const LatticeTriangle& t) {
  return cross(t[1] - t[0], t[2] - t[0]);
}

// Pre: p lies in the plane of t.
bool holds(const LatticeTriangle& t, const Lattice& p) {
  const Lattice n = normal_of(t);
  for (int i = 0; i < 3; ++i)
    if (dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), n) < 0) return false;
  return true;
}

// Pre: all in one plane with the normal n.
bool segments_meet(const Lattice& a, const Lattice& b, const Lattice& c, const Lattice& d,
                   const Lattice& n) {
  const auto side = [&](const Lattice& p, const Lattice& q, const Lattice& r) {
    const std::int64_t s = dot(cross(q - p, r - p), n);
    return s > 0 ? 1 : s < 0 ? -1 : 0;
  };
  const auto between = [&](const Lattice& p, const Lattice& q, const Lattice& r) {
    return side(p, q, r) == 0 && dot(p - r, q - r) <= 0;
  };
  if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) return true;
  return between(a, b, c) || between(a, b, d) || between(c, d, a) || between(c, d, b);
}

bool segment_meets(const Lattice& a, const Lattice& b, const LatticeTriangle& t) {
  const Lattice n = normal_of(t);
  const std::int64_t height_a = dot(a - t[0], n), height_b = dot(b - t[0], n);
  if ((height_a > 0 && height_b > 0) || (height_a < 0 && height_b < 0)) return false;
  if (height_a == 0 && holds(t, a)) return true;
  if (height_b == 0 && holds(t, b)) return true;
  if (height_a == 0 && height_b == 0) {
    for (int i = 0; i < 3; ++i)
      if (segments_meet(a, b, t[i], t[(i + 1) % 3], n)) return true;
    return false;
  }
  if (height_a == 0 || height_b == 0) return false;
  // The line through a and b passes all three edges on one side.
  int left = 0, right = 0;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t turn = dot(b - a, cross(t[i] - a, t[(i + 1) % 3] - a));
    left += turn > 0 ? 1 : 0;
    right += turn < 0 ? 1 : 0;
  }
  return left == 0 || right == 0;
}

bool lattice_triangles_meet(const std::vector<Lattice>& p, const Triangle& f, const Triangle& g) {
  const LatticeTriangle s{p[f[0]], p[f[1]], p[f[2]]}, t{p[g[0]], p[g[1]], p[g[2]]};
  if (is_zero(normal_of(s)) || is_zero(normal_of(t))) return false;
  std::vector<int> f_free, g_free;
  for (int i = 0; i < 3; ++i) {
    if (std::find(g.begin(), g.end(), f[i]) == g.end()) f_free.push_back(i);
    if (std::find(f.begin(), f.end(), g[i]) == f.end()) g_free.push_back(i);
  }
  if (f_free.empty()) return true;
  if (f_free.size() == 1) {
    const Lattice n = normal_of(s), &apex = t[g_free[0]];
    const Lattice &from = s[(f_free[0] + 1) % 3], &to = s[(f_free[0] + 2) % 3];
    return dot(n, apex - from) == 0 && dot(n, cross(to - from, apex - from)) > 0;
  }
  if (f_free.size() == 2)
    return segment_meets(s[f_free[0]], s[f_free[1]], t) ||
           segment_meets(t[g_free[0]], t[g_free[1]], s);
  for (int i = 0; i < 3; ++i)
    if (segment_meets(s[i], s[(i + 1) % 3], t) || segment_meets(t[i], t[(i + 1) % 3], s))
      return true;
  return false;
}

// --- exact signs -------------------------------------------------------------------------------

TEST(ExactPredicates, SignsOfSimpleCases) {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_EQ(orientation_sign(o, x, y, z), 1);
  EXPECT_EQ(orientation_sign(o, y, x, z), -1);
  EXPECT_EQ(orientation_sign(o, x, y, Vec3(3, -7, 0)), 0);
  EXPECT_EQ(orientation_sign_2d(o, x, y, 2), 1);
  EXPECT_EQ(orientation_sign_2d(o, y, z, 0), 1);
  EXPECT_EQ(orientation_sign_2d(o, z, x, 1), 1);
  EXPECT_EQ(orientation_sign_2d(o, x, 2 * x, 2), 0);
}

TEST(ExactPredicates, OneUnitInTheLastPlaceDecides) {
  // Exactly in the plane x + y + z = 4.
  const Vec3 a(1, 1, 2), b(3, 1, 0), c(-1, 3, 2);
  const Vec3 d = a + (b - a) * 0.5 + (c - a) * 0.25;
  const double up = std::numeric_limits<double>::infinity();
  const Vec3 above(d.x(), d.y(), std::nextafter(d.z(), up));
  const Vec3 below(d.x(), d.y(), std::nextafter(d.z(), -up));
  EXPECT_EQ(orientation_sign(a, b, c, above), exact::orientation_sign(a, b, c, above));
  EXPECT_EQ(orientation_sign(a, b, c, below), exact::orientation_sign(a, b, c, below));
  EXPECT_NE(orientation_sign(a, b, c, above), orientation_sign(a, b, c, below));
}

// Coordinates of which many are equal: all ways in which three or four points lie in a plane across
// an axis, with a fourth by the last bit beside it, and collinear ones.
TEST(ExactPredicates, SignsInDoubtAreTheExactOnes) {
  const double step = 0.1, next = std::nextafter(step, 1.0);
  const std::array<double, 4> coordinates = {0.0, step, next, 0.7};
  Random random(8);
  std::array<int, 3> count{};
  for (int i = 0; i < 100000; ++i) {
    std::array<Vec3, 4> p;
    for (Vec3& point : p)
      for (int axis = 0; axis < 3; ++axis)
        point[axis] = coordinates[static_cast<std::size_t>(random.below(4))];
    const int sign = exact::orientation_sign(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(orientation_sign_in_doubt(p[0], p[1], p[2], p[3]), sign);
    ASSERT_EQ(orientation_sign(p[0], p[1], p[2], p[3]), sign);
    ++count[static_cast<std::size_t>(sign + 1)];
  }
  for (const int signs : count) EXPECT_GT(signs, 10000);
}

TEST(ExactPredicates, FilteredSignsAreTheExactOnes) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    for (int i = 0; i < 20000; ++i) {
      const double scale = std::ldexp(1.0, static_cast<int>(random.below(1200)) - 600);
      std::array<Vec3, 4> p;
      for (Vec3& point : p) point = random.in_cube() * scale;
      // Almost, often exactly in one plane.
      if (i % 2 == 0) p[3] = p[0] + 0.5 * (p[1] - p[0]) + 0.25 * (p[2] - p[0]);
      ASSERT_EQ(orientation_sign(p[0], p[1], p[2], p[3]),
                exact::orientation_sign(p[0], p[1], p[2], p[3]));
      if (i % 4 == 0) p[2] = p[0] + 0.5 * (p[1] - p[0]);
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_EQ(orientation_sign_2d(p[0], p[1], p[2], axis),
                  exact::orientation_sign_2d(p[0], p[1], p[2], axis));
    }
  }
}

TEST(ExactPredicates, ProjectionAxis) {
  EXPECT_EQ(projection_axis(Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(3, 3, 3)), kNone);
  EXPECT_EQ(projection_axis(Vec3(1, 2, 3), Vec3(1, 2, 3), Vec3(0, 5, 0)), kNone);
  EXPECT_EQ(projection_axis(Vec3(0, 0, 0), Vec3(1, 0, 0.1), Vec3(0, 1, 0.1)), 2);
  EXPECT_EQ(projection_axis(Vec3(0, 0, 0), Vec3(0, 1e-160, 0), Vec3(0, 0, 1e-160)), 0);
}

// --- pairs of triangles ------------------------------------------------------------------------

TEST(TrianglePairs, AgreeWithIntegersOnALattice) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    std::array<int, 3> meeting = {};
    for (int i = 0; i < 100000; ++i) {
      const Index width = 2 + random.below(4), shared = random.below(3);
      std::vector<Lattice> lattice(6);
      std::vector<Vec3> positions(6);
      for (int v = 0; v < 6; ++v) {
        lattice[v] = {random.below(width), random.below(width), random.below(width)};
        // Thirds are rounded, all in the same way: half of the cases are off the filter's grid.
        const Vec3 p(static_cast<double>(lattice[v].x), static_cast<double>(lattice[v].y),
                     static_cast<double>(lattice[v].z));
        positions[v] = i % 2 == 0 ? p : Vec3(p * 0x1p-30 + Vec3::Constant(0x1p10));
      }
      const Triangle f = {0, 1, 2};
      Triangle g = {3, 4, 5};
      for (Index k = 0; k < shared; ++k) g[k] = f[(k + random.below(2)) % 3 == 2 ? 2 : k];
      if (shared == 2 && g[0] == g[1]) continue;
      std::rotate(g.begin(), g.begin() + random.below(3), g.end());
      const bool expected = lattice_triangles_meet(lattice, f, g);
      meeting[shared] += expected ? 1 : 0;
      const TrianglePairs pairs(positions);
      ASSERT_EQ(pairs.meet(f, g), expected) << "case " << i;
      ASSERT_EQ(pairs.meet(g, f), expected) << "case " << i;
      ASSERT_EQ(pairs.meet({f[1], f[0], f[2]}, {g[2], g[1], g[0]}), expected) << "case " << i;
    }
    for (int count : meeting) EXPECT_GT(count, 1000);
  }
}

TEST(TrianglePairs, WhatCountsAsMeeting) {
  const std::vector<Vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},     {0, 0, 0},
                               {1, 0, 1}, {0, 1, 1}, {0.4, 0.4, 0}, {1, 1, 0}};
  const TrianglePairs pairs(p);
  EXPECT_TRUE(pairs.meet({0, 1, 2}, {3, 4, 5})) << "touch at a corner that is not shared";
  EXPECT_FALSE(pairs.meet({0, 1, 2}, {0, 4, 5})) << "share that corner";
  EXPECT_FALSE(pairs.meet({0, 1, 2}, {2, 1, 4})) << "share an edge";
  EXPECT_FALSE(pairs.meet({0, 1, 2}, {2, 1, 7})) << "share an edge, coplanar";
  EXPECT_TRUE(pairs.meet({0, 1, 2}, {2, 1, 6})) << "folded onto each other";
  EXPECT_TRUE(pairs.meet({0, 1, 2}, {0, 2, 1})) << "the same three corners";
  EXPECT_FALSE(pairs.meet({0, 1, 2}, {0, 3, 6})) << "degenerate";
}

// --- meshes --------------------------------------------------------------------------------------

std::vector<Pair> all_pairs(const std::vector<Vec3>& positions,
                            const std::vector<Triangle>& triangles) {
  const TrianglePairs test(positions);
  std::vector<Pair> pairs;
  for (Index f = 0; f < static_cast<Index>(triangles.size()); ++f)
    for (Index g = f + 1; g < static_cast<Index>(triangles.size()); ++g)
      if (test.meet(triangles[f], triangles[g])) pairs.emplace_back(f, g);
  return pairs;
}

struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

Mesh two_spheres_that_cut() {
  const SurfaceMesh mesh = crossing_spheres(3);
  return {mesh.position, mesh.triangles()};
}

TEST(SelfIntersection, NoneInAGoodMesh) {
  Progress progress;
  for (const SurfaceMesh& mesh : {icosphere(0), icosphere(4), torus_mesh(60, 20)}) {
    EXPECT_TRUE(self_intersections(mesh.position, mesh.triangles(), progress).empty());
    EXPECT_TRUE(self_intersecting_faces(mesh.position, mesh.triangles(), progress).empty());
  }
  EXPECT_TRUE(self_intersections({}, {}, progress).empty());
}

TEST(SelfIntersection, FindsAllPairsOfTwoSpheres) {
  const Mesh mesh = two_spheres_that_cut();
  Progress progress;
  const std::vector<Pair> pairs = self_intersections(mesh.positions, mesh.triangles, progress);
  EXPECT_GT(pairs.size(), 50u);
  EXPECT_EQ(pairs, all_pairs(mesh.positions, mesh.triangles));
  EXPECT_EQ(faces_of_pairs(pairs),
            self_intersecting_faces(mesh.positions, mesh.triangles, progress));
}

TEST(SelfIntersection, FindsAllPairsOfSoups) {
  Progress progress;
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Mesh soup;
    const bool on_lattice = seed % 2 == 0;
    for (int v = 0; v < 300; ++v) {
      Vec3 p = random.in_cube();
      if (on_lattice) p = (4.0 * p).array().floor().matrix();
      soup.positions.push_back(p);
    }
    // Small and large triangles; some share corners, some are degenerate.
    for (int f = 0; f < 300; ++f) {
      const Index v = random.below(300), u = random.below(300), w = random.below(300);
      soup.triangles.push_back({v, (v + 1 + random.below(3)) % 300, u});
      if (f % 10 == 0) soup.triangles.push_back({u, v, w});
    }
    const auto repeats = [](const Triangle& t) {
      return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    };
    soup.triangles.erase(std::remove_if(soup.triangles.begin(), soup.triangles.end(), repeats),
                         soup.triangles.end());
    const std::vector<Pair> pairs = self_intersections(soup.positions, soup.triangles, progress);
    EXPECT_EQ(pairs, all_pairs(soup.positions, soup.triangles));
    EXPECT_EQ(faces_of_pairs(pairs),
              self_intersecting_faces(soup.positions, soup.triangles, progress));
  }
}

TEST(SelfIntersection, SameForAnyScaleAndPlace) {
  const Mesh mesh = two_spheres_that_cut();
  Progress progress;
  const std::vector<Pair> expected = self_intersections(mesh.positions, mesh.triangles, progress);
  for (double scale : {0x1p-1000, 0x1p-600, 0x1p-100, 0x1p30, 0x1p600, 0x1p1000}) {
    std::vector<Vec3> positions = mesh.positions;
    for (Vec3& p : positions) p *= scale;
    EXPECT_EQ(self_intersections(positions, mesh.triangles, progress), expected) << scale;
  }
  // Rounded first, so that a shift by so much loses nothing.
  std::vector<Vec3> rounded = mesh.positions, shifted;
  for (Vec3& p : rounded) {
    p = rounded_to_single(p);
    for (double& coordinate : p) coordinate = std::round(coordinate * 0x1p20) * 0x1p-20;
    shifted.push_back(p + Vec3(0x1p22, -0x1p23, 0x1p21));
  }
  EXPECT_EQ(self_intersections(shifted, mesh.triangles, progress),
            self_intersections(rounded, mesh.triangles, progress));
}

TEST(SelfIntersection, SameForAnyNumberOfThreads) {
  std::vector<SurfaceMesh> spheres;
  for (int i = 0; i < 4; ++i) spheres.push_back(placed(icosphere(4), 1.0, {0.5 * i, 0.1 * i, 0.0}));
  const SurfaceMesh all = joined(spheres);
  const Mesh mesh = {all.position, all.triangles()};
  const auto run = [&](std::size_t threads) {
    tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    Progress progress;
    return std::make_pair(self_intersections(mesh.positions, mesh.triangles, progress),
                          self_intersecting_faces(mesh.positions, mesh.triangles, progress));
  };
  const auto one = run(1);
  EXPECT_FALSE(one.first.empty());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(run(4), one);
}

TEST(SelfIntersection, LeavesOutWhatIsNoTriangle) {
  Mesh mesh = two_spheres_that_cut();
  Progress progress;
  const std::vector<Pair> expected = self_intersections(mesh.positions, mesh.triangles, progress);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Index bad = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back({0.0, nan, 0.0});
  mesh.positions.push_back({std::numeric_limits<double>::infinity(), 0.0, 0.0});
  mesh.triangles.push_back({0, 1, bad});
  mesh.triangles.push_back({0, 1, bad + 1});
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({0, 1, -1});
  mesh.triangles.push_back({0, 1, bad + 2});
  EXPECT_EQ(self_intersections(mesh.positions, mesh.triangles, progress), expected);
  // All in one point: every face degenerate.
  std::vector<Vec3> point(mesh.positions.size(), Vec3(1, 2, 3));
  EXPECT_TRUE(self_intersections(point, mesh.triangles, progress).empty());
}

TEST(SelfIntersection, CanBeCancelled) {
  const SurfaceMesh mesh = icosphere(4);
  Progress progress([](double, const char*) { return false; }, {Stage::report});
  EXPECT_THROW(self_intersections(mesh.position, mesh.triangles(), progress), Cancelled);
}

TEST(SelfIntersection, NewlyMeetingFacesAreOfNewPairs) {
  KeptMeetings before, now;
  before.pairs = {{0, 5}, {2, 3}};
  before.faces = {0, 2, 3, 5};
  now.pairs = {{0, 5}, {0, 7}, {8, 9}};
  now.faces = {0, 5, 7, 8, 9};
  EXPECT_EQ(newly_meeting_faces(before, now), (std::vector<Index>{0, 7, 8, 9}));
  EXPECT_TRUE(newly_meeting_faces(now, now).empty());
  before.has_all_pairs = false;  // then 0 7 may have been there
  EXPECT_EQ(newly_meeting_faces(before, now), (std::vector<Index>{7, 8, 9}));
}

}  // namespace
}  // namespace shrinkwrap
