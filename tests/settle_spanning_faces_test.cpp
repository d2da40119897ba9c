#include "complete_matching/settle_spanning_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "reconstruct.h"

namespace shrinkwrap::testing {
namespace {

constexpr Index kAround = 24;
constexpr double kHeight = 3.0;

// A drum: two rings with their middles, and a band between them that spans, all of whose faces fan
// out from two samples, one of either ring.
CompleteMatching fanned_drum() {
  std::vector<Vec3> positions;
  for (const double z : {0.0, kHeight})
    for (Index i = 0; i < kAround; ++i)
      positions.emplace_back(std::cos(2.0 * kPi * i / kAround), std::sin(2.0 * kPi * i / kAround),
                             z);
  positions.emplace_back(0.0, 0.0, 0.0);
  positions.emplace_back(0.0, 0.0, kHeight);
  const auto low = [](Index i) { return (i + kAround) % kAround; };
  const auto high = [&](Index i) { return kAround + low(i); };
  std::vector<Triangle> triangles;
  for (Index i = 0; i < kAround; ++i) {
    triangles.push_back({2 * kAround, low(i + 1), low(i)});
    triangles.push_back({2 * kAround + 1, high(i), high(i + 1)});
  }
  CompleteMatching matching;
  const auto span = [&](Triangle t) {
    matching.spanning_faces.push_back(static_cast<Index>(triangles.size()));
    triangles.push_back(t);
  };
  // A quarter of the lower ring from above its middle, and of the upper one from below; elsewhere
  // straight.
  const Index fan = kAround / 4;
  for (Index i = 0; i < fan; ++i) span({low(i), low(i + 1), high(0)});
  for (Index i = 0; i < fan; ++i) span({high(i + 1), high(i), low(fan)});
  for (Index i = fan; i < kAround; ++i) {
    span({low(i), low(i + 1), high(i)});
    span({high(i + 1), high(i), low(i + 1)});
  }
  matching.mesh = SurfaceMesh::from_triangles(std::move(positions), triangles);
  return matching;
}

double longest_edge(const SurfaceMesh& mesh) {
  double longest = 0.0;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    longest =
        std::max(longest, (mesh.position[mesh.target(h)] - mesh.position[mesh.origin(h)]).norm());
  return longest;
}

Index settle(CompleteMatching& matching, const std::vector<Index>& fixed = {},
             const SettlingOptions& options = {}) {
  Progress silent;
  return settle_spanning_faces(matching, fixed, options, silent);
}

const double kStraight = std::hypot(kHeight, 2.0 * std::sin(kPi / kAround)) + 1e-9;

TEST(SettleSpanningFaces, FansBecomeStraight) {
  CompleteMatching matching = fanned_drum();
  ASSERT_GT(longest_edge(matching.mesh), kStraight);
  const std::vector<Triangle> before = matching.mesh.triangles();
  EXPECT_GT(settle(matching), 0);
  EXPECT_LE(longest_edge(matching.mesh), kStraight);
  EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
  expect_closed_manifold(matching.mesh, 1, 0);
  for (Index f = 0; f < matching.spanning_faces.front(); ++f)
    EXPECT_EQ(matching.mesh.triangle(f), before[f]);
  EXPECT_EQ(settle(matching), 0);
}

TEST(SettleSpanningFaces, WhatIsFixedOrOpenStays) {
  const CompleteMatching drum = fanned_drum();
  CompleteMatching fixed = drum, open = drum;
  open.opening_faces = open.spanning_faces;
  EXPECT_EQ(settle(fixed, drum.spanning_faces), 0);
  EXPECT_EQ(settle(open), 0);
}

TEST(SettleSpanningFaces, TheOthersFlipWhereSomeAreFixed) {
  CompleteMatching matching = fanned_drum();
  const std::vector<Triangle> before = matching.mesh.triangles();
  const std::vector<Index> fixed(matching.spanning_faces.begin(),
                                 matching.spanning_faces.begin() + 2);
  EXPECT_GT(settle(matching, fixed), 0);
  for (const Index f : fixed) EXPECT_EQ(matching.mesh.triangle(f), before[f]);
}

// A kite of two spanning faces, whose other diagonal is Delaunay, and longer than its sides.
TEST(SettleSpanningFaces, NoEdgeBecomesLongerThanTheLongest) {
  const std::vector<Vec3> positions = {
      {-1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.5, 0.0}, {0.0, -1.9, 0.0}, {0.0, -0.5, -9.0}};
  CompleteMatching matching;
  matching.mesh = SurfaceMesh::from_triangles(
      positions, {{0, 1, 2}, {1, 0, 3}, {2, 1, 4}, {0, 2, 4}, {3, 0, 4}, {1, 3, 4}});
  matching.spanning_faces = {0, 1};
  EXPECT_EQ(settle(matching), 0);
  matching.spanning_faces = {0, 1, 5};
  EXPECT_EQ(settle(matching), 1) << "there is a longer one";
}

// A pentagon of three spanning faces, whose middle one has both inner edges, among triangles that
// are obtuse at their outer corners, so that every edge of the rim would flip. A flip of one inner
// edge turns the other half-edges of its faces by one place.
TEST(SettleSpanningFaces, TheRimStaysWhateverTheOrder) {
  constexpr Index kSides = 5, kApex = 2 * kSides;
  std::vector<Vec3> positions(2 * kSides + 1, Vec3(0.0, 0.0, -5.0));
  for (Index i = 0; i < kSides; ++i) {
    const auto on_ellipse = [](double turns) {
      return Vec3(1.5 * std::cos(2.0 * kPi * turns), std::sin(2.0 * kPi * turns), 0.0);
    };
    positions[i] = on_ellipse(i / 5.0);
    positions[kSides + i] =
        0.52 * (positions[i] + on_ellipse((i + 1) / 5.0)) - Vec3(0.0, 0.0, 0.001);
  }
  Index flips = 0;
  for (Index turn = 0; turn < kSides; ++turn)  // the corner that the three have in common
    for (int rotations = 0; rotations < 27; ++rotations)
      for (int order = 0; order < 3; ++order) {
        const auto rim = [&](Index i) { return (i + turn) % kSides; };
        const auto rotated = [](Triangle t, int by) {
          return Triangle{t[by % 3], t[(by + 1) % 3], t[(by + 2) % 3]};
        };
        std::vector<Triangle> triangles = {rotated({rim(0), rim(1), rim(2)}, rotations),
                                           rotated({rim(0), rim(2), rim(3)}, rotations / 3),
                                           rotated({rim(0), rim(3), rim(4)}, rotations / 9)};
        std::rotate(triangles.begin(), triangles.begin() + order, triangles.begin() + 3);
        for (Index i = 0; i < kSides; ++i) {
          const Index next = (i + 1) % kSides, outer = kSides + i;
          triangles.push_back({next, i, outer});
          triangles.push_back({outer, i, kApex});
          triangles.push_back({next, outer, kApex});
        }
        CompleteMatching matching;
        matching.mesh = SurfaceMesh::from_triangles(positions, triangles);
        matching.spanning_faces = {0, 1, 2};
        flips += settle(matching);
        for (std::size_t f = 3; f < triangles.size(); ++f)
          EXPECT_EQ(matching.mesh.triangle(static_cast<Index>(f)), triangles[f]);
      }
  EXPECT_GT(flips, 0);
}

TEST(SettleSpanningFaces, NothingFlipsBeyondTheTests) {
  CompleteMatching matching = fanned_drum();
  SettlingOptions options;
  options.max_tests = 4;
  EXPECT_EQ(settle(matching, {}, options), 0);
}

// Between the flat fan and the round there is a small body: it is in the way of straight faces,
// unless it is to be dropped.
TEST(SettleSpanningFaces, NothingIsCut) {
  const CompleteMatching drum = fanned_drum();
  std::vector<Vec3> positions = drum.mesh.position;
  std::vector<Triangle> triangles = drum.mesh.triangles();
  const auto first_vertex = static_cast<Index>(positions.size());
  const auto first_face = static_cast<Index>(triangles.size());
  // A small tetrahedron astride the round, outside of the flat fan.
  const Vec3 middle = 0.999 * Vec3(std::cos(kPi / 4.0), std::sin(kPi / 4.0), 0.5 * kHeight / 0.999);
  for (const Vec3& offset : {Vec3(0.01, 0.01, 0.01), Vec3(0.01, -0.01, -0.01),
                             Vec3(-0.01, 0.01, -0.01), Vec3(-0.01, -0.01, 0.01)})
    positions.push_back(middle + offset);
  for (const Triangle& t :
       {Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 3, 1}, Triangle{1, 3, 2}})
    triangles.push_back({first_vertex + t[0], first_vertex + t[1], first_vertex + t[2]});
  CompleteMatching matching = drum;
  matching.mesh = SurfaceMesh::from_triangles(std::move(positions), triangles);
  ASSERT_EQ(count_meeting_faces(matching.mesh), 0) << "the fan cuts already";
  CompleteMatching dropped = matching;
  for (Index f = first_face; f < dropped.mesh.face_slots(); ++f) dropped.opening_faces.push_back(f);
  settle(matching);
  EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
  EXPECT_GT(longest_edge(matching.mesh), kStraight);
  settle(dropped);
  EXPECT_LE(longest_edge(dropped.mesh), kStraight);
}

// A capsule without samples between its two halves, those of one right above those of the other.
TEST(Reconstruction, OfAGapBetweenTwoRingsIsStraight) {
  constexpr Index kMeridians = 100, kRings = 25;
  std::vector<Vec3> points = {{0.0, 0.0, 1.5}, {0.0, 0.0, -1.5}};
  for (const double side : {1.0, -1.0})
    for (Index ring = 0; ring < kRings; ++ring)
      for (Index i = 0; i < kMeridians; ++i) {
        const double up = 0.5 * kPi * ring / kRings, around = 2.0 * kPi * i / kMeridians;
        points.emplace_back(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                            side * (0.5 + std::sin(up)));
      }
  Progress silent;
  const Reconstruction result = reconstruct(points, {}, silent);
  EXPECT_TRUE(result.report.complete_matching());
  EXPECT_EQ(result.report.self_intersecting_faces, 0);
  ASSERT_GT(result.openings.spanned, 0);
  double longest = 0.0;
  for (const Triangle& t : result.mesh.triangles)
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest, (result.mesh.position[t[k]] - result.mesh.position[t[(k + 1) % 3]]).norm());
  EXPECT_LE(longest, std::hypot(1.0, 2.0 * std::sin(kPi / kMeridians)) + 1e-6);
}

}  // namespace
}  // namespace shrinkwrap::testing
