// Boxes of faces: what may meet a triangle is found, and what lies beside it is passed over.
#include "box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"
#include "triangle_pair.h"

namespace shrinkwrap {
namespace {

using testing::Random;

// Small faces all over a box, then long thin ones across it.
struct Faces {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  Index small = 0;
};

Faces small_and_long_faces(unsigned seed) {
  Faces faces;
  Random random(seed);
  const auto add = [&](const Vec3& centre, const Vec3& along, double size) {
    const Index v = static_cast<Index>(faces.positions.size());
    faces.positions.push_back(centre - along + size * random.in_cube());
    faces.positions.push_back(centre + along + size * random.in_cube());
    faces.positions.push_back(centre + size * random.in_cube());
    faces.triangles.push_back({v, v + 1, v + 2});
  };
  for (Index i = 0; i < 4000; ++i)
    add(Vec3(50.0, 7.0, -3.0) + random.in_cube(), Vec3::Zero(), 0.03);
  faces.small = static_cast<Index>(faces.triangles.size());
  for (Index i = 0; i < 60; ++i)
    add(Vec3(50.0, 7.0, -3.0) + 0.2 * random.in_cube(), random.in_cube(), 0.03);
  return faces;
}

TEST(BoxTree, FindsAllThatATriangleMeets) {
  for (const unsigned seed : {1u, 2u}) {
    const Faces faces = small_and_long_faces(seed);
    Progress silent;
    const BoxTree tree(faces.positions, faces.triangles, silent);
    const TrianglePairs pairs(faces.positions);
    Index met = 0, looked_at = 0, boxes = 0;
    for (Index g = 0; g < static_cast<Index>(faces.triangles.size());
         g += g < faces.small ? 10 : 1) {
      const Triangle& t = faces.triangles[g];
      std::vector<Index> found;
      EXPECT_FALSE(tree.any_near(faces.positions, t, [&](Index f) {
        found.push_back(f);
        return false;
      }));
      std::sort(found.begin(), found.end());
      for (Index f = 0; f < static_cast<Index>(faces.triangles.size()); ++f) {
        if (f == g || !pairs.meet(t, faces.triangles[f])) continue;
        ++met;
        EXPECT_TRUE(std::binary_search(found.begin(), found.end(), f));
      }
      if (g < faces.small) continue;
      looked_at += static_cast<Index>(found.size());
      tree.for_each_overlap(tree.box_of(faces.positions, t), [&](Index) { ++boxes; });
    }
    EXPECT_GT(met, 100);
    EXPECT_LT(5 * looked_at, boxes) << "what lies beside a long triangle is passed over";
  }
}

TEST(BoxTree, StopsAtTheFirstOneWanted) {
  const Faces faces = small_and_long_faces(3);
  Progress silent;
  const BoxTree tree(faces.positions, faces.triangles, silent);
  int calls = 0;
  EXPECT_TRUE(
      tree.any_near(faces.positions, faces.triangles.back(), [&](Index) { return ++calls == 2; }));
  EXPECT_EQ(calls, 2);
  EXPECT_FALSE(
      BoxTree().any_near(faces.positions, faces.triangles.back(), [](Index) { return true; }));
}

}  // namespace
}  // namespace shrinkwrap
