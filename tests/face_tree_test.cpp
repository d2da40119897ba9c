// The nearest face by the tree, against all faces.
#include "mesh/face_tree.h"

#include <gtest/gtest.h>

#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::Random;

const auto any = [](Index) { return true; };
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

double squared_distance(const SurfaceMesh& mesh, Index f, const Vec3& query) {
  const Triangle t = mesh.triangle(f);
  return foot_on_triangle(query, mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]])
      .squared_distance;
}

TEST(FaceTree, FindsTheNearestFace) {
  const SurfaceMesh mesh = testing::icosphere(3);
  Progress silent;
  const FaceTree tree(mesh, silent);
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 query = 2.0 * random.in_cube();
    double least = kUnlimited;
    for (Index f = 0; f < mesh.face_slots(); ++f)
      least = std::min(least, squared_distance(mesh, f, query));
    const FaceTree::Hit hit = tree.nearest(query, kUnlimited, kNone, any);
    EXPECT_EQ(hit.squared_distance, least);
    EXPECT_EQ(squared_distance(mesh, hit.face, query), least);
  }
}

// Queries that lie this densely about the centre of a bumpy sphere, and some elsewhere.
std::int64_t expect_same_with_anchor(double radius) {
  Random random(2);
  SurfaceMesh mesh = testing::icosphere(4);
  for (Vec3& p : mesh.position) p *= 1.0 + 0.01 * random.uniform();
  Progress silent;
  const FaceTree tree(mesh, silent);
  FaceTree::Anchor anchor;
  constexpr int kQueries = 200;
  for (int i = 0; i < kQueries; ++i) {
    const Vec3 query = (i % 50 == 49 ? 1.0 : radius) * random.in_cube();
    const Index hint = i % 2 == 0 ? kNone : random.below(mesh.face_slots());
    const auto accept = [&](Index f) { return i % 3 != 0 || f % 2 == 0; };
    const double limit = i % 5 == 0 ? 1.03 * 1.03 : kUnlimited;
    const FaceTree::Hit expected = tree.nearest(query, limit, hint, accept);
    const FaceTree::Hit hit = tree.nearest(query, limit, hint, accept, anchor);
    EXPECT_EQ(hit.face, expected.face);
    EXPECT_EQ(hit.squared_distance, expected.squared_distance);
    EXPECT_EQ(hit.weight_b, expected.weight_b);
    EXPECT_EQ(hit.weight_c, expected.weight_c);
  }
  return anchor.looks() / kQueries;
}

TEST(FaceTree, AnAnchorSparesLooksWithoutAnotherAnswer) {
  const std::int64_t faces = testing::icosphere(4).face_slots();
  EXPECT_LT(expect_same_with_anchor(1e-5), faces / 8);
  EXPECT_LT(expect_same_with_anchor(1e-3), faces / 3);
  expect_same_with_anchor(0.1);
  expect_same_with_anchor(1.0);
}

}  // namespace
}  // namespace shrinkwrap
