// Membranes of a parametric surface, stretched between their rims.
#include "stop_at_surface/membrane_stretching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "meeting_pairs.h"
#include "mesh/face_patches.h"
#include "mesh/self_intersection.h"
#include "open_scan.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

SurfaceMesh ball(const Vec3& centre, double radius, int subdivisions) {
  return placed(icosphere(subdivisions), radius, centre);
}

// The torus without samples over an angle around its axis.
OpenScan open_torus(double angle) {
  return OpenScan(torus_mesh(150, 50), [angle](const Vec3& p) {
    return std::abs(std::atan2(p.y(), p.x())) < 0.5 * angle;
  });
}

TEST(MembraneStretching, AMembraneIsStretchedFlat) {
  OpenScan scan = open_sphere();
  const OpenScan before = open_sphere();
  scan.stretch();
  ASSERT_TRUE(scan.membranes[0].is_stretched);
  const double spacing = scan.cloud.frame.to_input_length(scan.cloud.spacing);
  for (const Index v : scan.membranes[0].vertices) {
    EXPECT_NEAR(scan.at(v).z(), 0.5, spacing);
    EXPECT_LT(std::hypot(scan.at(v).x(), scan.at(v).y()), 0.9);
  }
  Index moved = 0;
  for (Index v = 0; v < scan.surface.vertex_slots(); ++v) {
    const double way = (scan.at(v) - before.at(v)).norm();
    EXPECT_TRUE(way == 0.0 || before.at(v).z() > 0.5 - spacing);
    moved += way > 0.0;
  }
  EXPECT_GT(moved, static_cast<Index>(scan.membranes[0].vertices.size()))
      << "the rim is smoothed too";
  EXPECT_EQ(count_pairs(scan.surface), 0);
}

// A sphere, open above, and small balls within or on it.
OpenScan with_balls(const std::vector<Vec3>& centres, double rim = 0.5, int subdivisions = 5) {
  std::vector<SurfaceMesh> bodies = {icosphere(subdivisions)};
  for (const Vec3& centre : centres) bodies.push_back(ball(centre, 0.05, 2));
  return OpenScan(joined(bodies),
                  [rim](const Vec3& p) { return p.z() > rim && std::abs(p.norm() - 1.0) < 1e-6; });
}

double top_of(const OpenScan& scan) {
  double top = -1.0;
  for (const Index v : scan.membranes[0].vertices) top = std::max(top, scan.at(v).z());
  return top;
}

TEST(MembraneStretching, GoesBackWhereItWouldMeetSomething) {
  // Where the membrane would pass when flat, or halfway and three quarters of the way back.
  const Vec3 flat(0.0, 0.0, 0.5), halfway(0.0, 0.0, 0.74), farther(0.0, 0.0, 0.85);
  for (const int subdivisions : {5, 6}) {
    SCOPED_TRACE(subdivisions);
    OpenScan once = with_balls({flat}, 0.5, subdivisions),
             thrice = with_balls({flat, halfway, farther}, 0.5, subdivisions),
             beside = with_balls({{0.5, 0.0, 0.5}}, 0.5, subdivisions);
    for (OpenScan* scan : {&once, &thrice, &beside}) {
      ASSERT_EQ(scan->openings(), 1);
      scan->stretch();
      EXPECT_TRUE(scan->membranes[0].is_stretched);
      EXPECT_EQ(count_pairs(scan->surface), 0);
      // Flat far away, and not steep on the way there, however many edges that is.
      const double centre = scan == &beside ? 0.5 : 0.0;
      Index far_away = 0;
      for (const Index v : scan->membranes[0].vertices)
        if (std::hypot(scan->at(v).x() - centre, scan->at(v).y()) > 0.7) {
          EXPECT_NEAR(scan->at(v).z(), 0.5, 0.03);
          ++far_away;
        }
      EXPECT_GT(far_away, 100);
      for (const Index f : faces_around(scan->surface, scan->membranes[0].vertices))
        EXPECT_GT(scan->surface.area_vector(f).normalized().z(), 0.25);
    }
    EXPECT_NEAR(top_of(once), 0.75, 0.03);
    EXPECT_NEAR(top_of(thrice), 1.0, 0.01) << "all of the way";
    EXPECT_LT(top_of(beside), 0.75);
  }
}

TEST(MembraneStretching, AFaceThatMetSomethingMeetsNothingElse) {
  OpenScan before = open_sphere(), after = open_sphere();
  after.stretch();
  const auto centre_of = [](const OpenScan& scan, Index f) {
    const auto [a, b, c] = scan.surface.triangle(f);
    return Vec3((scan.at(a) + scan.at(b) + scan.at(c)) / 3.0);
  };
  Index top = before.surface.face_slots() - 1;
  for (const Index f : faces_around(before.surface, before.membranes[0].vertices))
    if (centre_of(before, f).z() > centre_of(before, top).z()) top = f;
  // A ball in a face, and another where that face would be.
  OpenScan scan(joined({icosphere(4), ball(centre_of(before, top), 0.008, 1),
                        ball(centre_of(after, top), 0.006, 1)}),
                [](const Vec3& p) { return p.z() > 0.5 && std::abs(p.norm() - 1.0) < 1e-6; });
  ASSERT_EQ(scan.openings(), 1);
  const auto met = [&](Index first, Index count) {
    Index pairs = 0;
    for (const auto& [f, g] :
         self_intersections(scan.surface.position, scan.surface.triangles(), scan.silent))
      pairs += g >= first && g < first + count;
    return pairs;
  };
  const Index sphere = before.surface.face_count(), one = icosphere(1).face_count();
  ASSERT_GT(met(sphere, one), 0);
  ASSERT_EQ(met(sphere + one, one), 0);
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  EXPECT_EQ(met(sphere + one, one), 0);
}

TEST(MembraneStretching, NeighboursDoNotDependOnTheirOrder) {
  // Two halves of an opening, on either side of a strip that is the rim of both.
  const auto stretched = [](const std::vector<Vec3>& balls, bool is_reversed) {
    OpenScan scan = with_balls(balls);
    std::vector<SurfaceMembrane> halves(2, scan.membranes[0]);
    for (int side = 0; side < 2; ++side) {
      std::vector<Index>& vertices = halves[side].vertices;
      vertices.erase(std::remove_if(vertices.begin(), vertices.end(),
                                    [&](Index v) {
                                      const double x = scan.at(v).x();
                                      return side == 0 ? x < 0.03 : x > -0.03;
                                    }),
                     vertices.end());
    }
    if (is_reversed) std::swap(halves[0], halves[1]);
    scan.membranes = halves;
    scan.stretch();
    EXPECT_TRUE(scan.membranes[0].is_stretched && scan.membranes[1].is_stretched);
    EXPECT_EQ(count_pairs(scan.surface), 0);
    return scan.surface.position;
  };
  // Balls in the way of one of them, near the strip.
  const std::vector<Vec3> balls = {{0.2, 0.0, 0.85}, {0.25, 0.3, 0.75}};
  const std::vector<Vec3> free = stretched({}, false), held = stretched(balls, false);
  Index held_back = 0;
  for (std::size_t v = 0; v < free.size(); ++v) held_back += (held[v] - free[v]).norm() > 0.01;
  ASSERT_GT(held_back, 100);
  EXPECT_EQ(held, stretched(balls, true));
}

TEST(MembraneStretching, AnOtherSideGoesBackAsAWhole) {
  // More of it than was seen: the half of the way is the same everywhere.
  OpenScan scan = with_balls({{0.0, 0.0, -0.2}}, -0.2);
  ASSERT_EQ(scan.openings(), 1);
  const std::vector<Vec3> before = scan.surface.position;
  OpenScan flat = with_balls({}, -0.2);
  flat.stretch();
  EXPECT_NEAR(top_of(flat), -0.2, 0.03);
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  EXPECT_EQ(count_pairs(scan.surface), 0);
  Index compared = 0;
  for (const Index v : scan.membranes[0].vertices) {
    const Vec3 at_first = scan.cloud.frame.to_input(before[v]);
    if (at_first.z() < 0.0) continue;
    EXPECT_NEAR(scan.at(v).z(), 0.5 * (at_first.z() - 0.2), 0.04);
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

// A sphere cut off at a height; in place of its top a bulge around an island of samples, which lies
// in the plane of the rim.
OpenScan around_an_island(double rim, double bulge) {
  const double edge = std::sqrt(1.0 - rim * rim), inner = 0.15;
  SurfaceMesh mesh = icosphere(5);
  for (Vec3& p : mesh.position) {
    if (p.z() <= rim) continue;
    // Even over the radius, from the pole to the rim.
    const double r = std::acos(p.z()) / std::acos(rim) * edge, scale = r / std::hypot(p.x(), p.y());
    if (r > 0.0) p.head<2>() *= scale;
    p.z() = rim;
    if (r > inner) p.z() += bulge * std::sin(kPi * (r - inner) / (edge - inner));
  }
  return OpenScan(mesh, [&](const Vec3& p) { return p.z() > rim; });
}

TEST(MembraneStretching, AnIslandOfSamplesIsNoReasonToStayBulging) {
  OpenScan scan = around_an_island(0.5, 0.35);
  ASSERT_EQ(scan.openings(), 1);
  EXPECT_NEAR(top_of(scan), 0.85, 0.01);
  const auto area = [&] {
    double sum = 0.0;
    for (const Index f : faces_around(scan.surface, scan.membranes[0].vertices))
      sum += scan.surface.area_vector(f).norm();
    return sum;
  };
  const double before = area();
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  EXPECT_NEAR(top_of(scan), 0.5, 0.03);
  EXPECT_LT(area(), 0.75 * before) << "as that of a neck would be";
}

TEST(MembraneStretching, AnOtherSideWithAnIslandStaysAsItIs) {
  OpenScan scan = around_an_island(-0.2, 0.9);
  ASSERT_EQ(scan.openings(), 1);
  const std::vector<Vec3> before = scan.surface.position;
  scan.stretch();
  EXPECT_FALSE(scan.membranes[0].is_stretched);
  EXPECT_EQ(scan.surface.position, before);
}

TEST(MembraneStretching, ATubeDoesNotBecomeAThread) {
  OpenScan narrow = open_torus(0.5), wide = open_torus(1.8);
  ASSERT_EQ(narrow.openings(), 1);
  ASSERT_EQ(wide.openings(), 1);
  narrow.stretch();
  EXPECT_TRUE(narrow.membranes[0].is_stretched);
  const std::vector<Vec3> before = wide.surface.position;
  wide.stretch();
  EXPECT_FALSE(wide.membranes[0].is_stretched);
  EXPECT_EQ(wide.surface.position, before);
}

TEST(MembraneStretching, WithoutARimNothingIsStretched) {
  // A body that no sample is on, beside one with an opening.
  OpenScan scan(joined({icosphere(4), ball({4.0, 0.0, 0.0}, 0.5, 2)}),
                [](const Vec3& p) { return p.x() > 2.0 || p.z() > 0.5; });
  ASSERT_EQ(scan.openings(), 2);
  const std::vector<Vec3> before = scan.surface.position;
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  EXPECT_FALSE(scan.membranes[1].is_stretched);
  for (const Index v : scan.membranes[1].vertices) EXPECT_EQ(scan.surface.position[v], before[v]);
}

TEST(MembraneStretching, FacesThatMeetAnywayAreNoReasonToGoBack) {
  // A fold of the fit, beside the rim.
  OpenScan scan = open_sphere();
  const std::vector<Index>& vertices = scan.membranes[0].vertices;
  Index v = vertices[0];
  scan.surface.for_each_outgoing(v, [&](Index h) {
    const Index u = scan.surface.target(h);
    if (!std::binary_search(vertices.begin(), vertices.end(), u)) v = u;
  });
  Index beyond = v;
  scan.surface.for_each_outgoing(v, [&](Index h) {
    const Index u = scan.surface.target(h);
    if (scan.at(u).z() < scan.at(beyond).z()) beyond = u;
  });
  Vec3& p = scan.surface.position[beyond];
  p += 3.0 * (scan.surface.position[v] - p);  // over its neighbour
  ASSERT_GT(count_pairs(scan.surface), 0);
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  for (const Index u : vertices) EXPECT_LT(scan.at(u).z(), 0.65);
}

}  // namespace
}  // namespace shrinkwrap::testing
