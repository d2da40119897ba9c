// Flips of single edges: what they may do, and what is known of the mesh after them.
#include "edge_optimisation/hinge_flips.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_pairs;
using testing::expect_closed_manifold;
using testing::icosphere;
using testing::Random;

constexpr std::int64_t kManyTests = 100000000;
constexpr FlipLimits kNoLimits{-1.0, 0.0};
constexpr std::ptrdiff_t kManyPairs = 1000000;

std::ptrdiff_t any_number(const HingeShape&, const HingeShape&) {
  return kManyPairs;
}

// A mesh with what its flips need.
struct Flipped {
  explicit Flipped(SurfaceMesh m, std::vector<Index> fixed = {})
      : mesh(std::move(m)), fixed_faces(std::move(fixed)), meetings(mesh, kManyTests, progress) {}

  Index edge(Index a, Index b) const {
    for (Index h = 0; h < 3 * mesh.face_slots(); ++h)
      if (mesh.origin(h) == a && mesh.target(h) == b) return h;
    ADD_FAILURE() << "no edge " << a << ", " << b;
    return 0;
  }

  Progress progress;
  SurfaceMesh mesh;
  std::vector<Index> fixed_faces;
  FaceMeetings meetings;
  HingeFlips hinges{mesh, meetings, fixed_faces};
};

SurfaceMesh tetrahedron() {
  return SurfaceMesh::from_triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                     {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

// Corner i is at the bits of i; its faces are parted by a diagonal.
SurfaceMesh cube() {
  std::vector<Vec3> corners;
  for (Index i = 0; i < 8; ++i) corners.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  return SurfaceMesh::from_triangles(corners, {{0, 2, 3},
                                               {0, 3, 1},
                                               {4, 5, 7},
                                               {4, 7, 6},
                                               {0, 1, 5},
                                               {0, 5, 4},
                                               {2, 6, 7},
                                               {2, 7, 3},
                                               {0, 4, 6},
                                               {0, 6, 2},
                                               {1, 3, 7},
                                               {1, 7, 5}});
}

// A tetrahedron with a vertex, the last, in the middle of the edge from 0 to 1.
SurfaceMesh tetrahedron_with_split_edge() {
  return SurfaceMesh::from_triangles(
      {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0}},
      {{0, 2, 4}, {4, 2, 1}, {0, 4, 3}, {4, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

TEST(HingeFlips, ShapeIsOfTheTwoTrianglesAndTheirFiveEdges) {
  Flipped flipped(cube());
  const HingeFlips& hinges = flipped.hinges;
  const Index diagonal = flipped.edge(0, 3);
  for (const Hinge& hinge : {hinges.hinge_at(diagonal), hinges.flipped_hinge_at(diagonal)}) {
    const HingeShape shape = hinges.shape_of(diagonal, hinge);
    EXPECT_NEAR(shape.bending, 4.0, 1e-12) << "four edges of a right angle, and a flat one";
    EXPECT_NEAR(shape.sharpest, 0.0, 1e-12);
    EXPECT_NEAR(shape.least_height, 0.5, 1e-12);
  }
  const Index edge = flipped.edge(0, 1);
  const HingeShape now = hinges.shape_of(edge, hinges.hinge_at(edge));
  EXPECT_NEAR(now.bending, 1.0 + 2.0, 1e-12) << "itself, and the two that are no diagonals";
  const HingeShape then = hinges.shape_of(edge, hinges.flipped_hinge_at(edge));
  EXPECT_GT(then.bending, now.bending);
  EXPECT_TRUE(bends_less(now, then));
  EXPECT_FALSE(bends_less(then, now));
  EXPECT_FALSE(bends_less(now, now)) << "not by rounding alone";
}

TEST(HingeFlips, OnlyWhatLeavesAManifold) {
  Flipped flipped(tetrahedron());
  for (Index h = 0; h < 12; ++h) {
    EXPECT_FALSE(flipped.hinges.may_flip(h)) << "the other two vertices have an edge";
    EXPECT_FALSE(flipped.hinges.try_flip(h, kNoLimits, any_number));
  }
  EXPECT_EQ(flipped.mesh.triangles(), tetrahedron().triangles());
}

TEST(HingeFlips, FixedFacesStay) {
  const SurfaceMesh sphere = icosphere(1);
  Flipped free(sphere), fixed(sphere, {5, 9});
  for (Index h = 0; h < 3 * sphere.face_slots(); ++h) {
    const Index f = SurfaceMesh::face(h), g = SurfaceMesh::face(sphere.twin(h));
    EXPECT_TRUE(free.hinges.may_flip(h));
    EXPECT_EQ(fixed.hinges.may_flip(h), f != 5 && f != 9 && g != 5 && g != 9) << f << ", " << g;
  }
  EXPECT_FALSE(fixed.hinges.try_flip(3 * 9, kNoLimits, any_number));
  EXPECT_EQ(fixed.mesh.triangles(), sphere.triangles());
}

TEST(HingeFlips, MakesNoFaceDegenerate) {
  Flipped flipped(tetrahedron_with_split_edge());
  const Index h = flipped.edge(4, 2);
  ASSERT_TRUE(flipped.hinges.may_flip(h));
  EXPECT_FALSE(flipped.hinges.try_flip(h, kNoLimits, any_number));
  EXPECT_EQ(flipped.mesh.triangles(), tetrahedron_with_split_edge().triangles());
}

TEST(HingeFlips, StaysWithinTheLimitsUnlessItWasAsBad) {
  Flipped flipped(cube());
  const Index h = flipped.edge(0, 3);
  // Nobody asks for more than there was.
  EXPECT_TRUE(flipped.hinges.try_flip(h, {0.5, 0.9}, any_number));
  Flipped sharp(cube());
  const Index edge = sharp.edge(0, 1);
  const Hinge then = sharp.hinges.flipped_hinge_at(edge);
  const HingeShape shape = sharp.hinges.shape_of(edge, then);
  ASSERT_LT(shape.sharpest, -0.1) << "no case of a fold";
  EXPECT_FALSE(sharp.hinges.try_flip(edge, {shape.sharpest + 0.01, 0.0}, any_number));
  EXPECT_TRUE(sharp.hinges.try_flip(edge, {shape.sharpest - 0.01, 0.0}, any_number));

  Flipped round(icosphere(1));
  const Index e = 0;
  const HingeShape wide = round.hinges.shape_of(e, round.hinges.flipped_hinge_at(e));
  EXPECT_FALSE(round.hinges.try_flip(e, {-1.0, wide.least_height + 0.01}, any_number));
  EXPECT_TRUE(round.hinges.try_flip(e, {-1.0, wide.least_height - 0.01}, any_number));
}

TEST(HingeFlips, TheTwoTrianglesMayMeetEachOther) {
  // A pyramid over a flat dart, of which the other diagonal lies outside.
  const SurfaceMesh pyramid = SurfaceMesh::from_triangles(
      {{0, 0, 0}, {0, 2, 0}, {-1, -1, 0}, {1, -1, 0}, {0, 0.5, 1}},
      {{0, 1, 3}, {0, 2, 1}, {1, 2, 4}, {3, 1, 4}, {0, 3, 4}, {2, 0, 4}});
  ASSERT_EQ(count_pairs(pyramid), 0);
  Flipped flipped(pyramid);
  const Index h = flipped.edge(0, 1);
  EXPECT_FALSE(flipped.hinges.try_flip(
      h, kNoLimits, [](const HingeShape&, const HingeShape&) { return std::ptrdiff_t{0}; }));
  EXPECT_EQ(flipped.mesh.triangles(), pyramid.triangles());
  EXPECT_TRUE(flipped.hinges.try_flip(h, kNoLimits, any_number));
  EXPECT_GT(count_pairs(flipped.mesh), 0);
  EXPECT_EQ(flipped.meetings.pair_count(), count_pairs(flipped.mesh));
}

TEST(HingeFlips, KnowsHowManyPairsThereAreThen) {
  Random random(1);
  SurfaceMesh mesh = icosphere(2);
  for (Vec3& p : mesh.position) p += 0.3 * random.in_cube();
  Flipped flipped(mesh);
  Index more = 0, fewer = 0;
  for (Index h = 0; h < 3 * mesh.face_slots(); h += 7) {
    SCOPED_TRACE("edge " + std::to_string(h));
    if (!flipped.hinges.may_flip(h)) continue;
    const Index before = count_pairs(flipped.mesh);
    const std::vector<Triangle> triangles = flipped.mesh.triangles();
    const std::ptrdiff_t here = flipped.hinges.pair_count_at(h);
    ASSERT_EQ(flipped.meetings.pair_count(), before);
    SurfaceMesh then = flipped.mesh;
    then.flip(h);
    const std::ptrdiff_t added = count_pairs(then) - before;
    const auto at_most = [&](std::ptrdiff_t most) {
      return [most](const HingeShape&, const HingeShape&) { return most; };
    };
    EXPECT_FALSE(flipped.hinges.try_flip(h, kNoLimits, at_most(here + added - 1)));
    EXPECT_FALSE(flipped.hinges.try_flip(h, kNoLimits, at_most(-1)));
    EXPECT_EQ(flipped.mesh.triangles(), triangles);
    EXPECT_TRUE(flipped.hinges.try_flip(h, kNoLimits, at_most(here + added)));
    EXPECT_EQ(flipped.meetings.pair_count(), before + added);
    (added > 0 ? more : fewer) += added != 0 ? 1 : 0;
  }
  EXPECT_GT(more, 5);
  EXPECT_GT(fewer, 5);
  EXPECT_EQ(flipped.meetings.pair_count(), count_pairs(flipped.mesh));
  expect_closed_manifold(flipped.mesh, 1, 0);
}

}  // namespace
}  // namespace shrinkwrap
