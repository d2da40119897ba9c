// Boxes of faces: what may meet a triangle is found, and what lies beside it is passed over.
#include "mesh/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mesh/triangle_pair.h"
#include "shapes.h"

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

TEST(BoxTree, OfAPartFindsTheSameWithinItsBox) {
  const Faces faces = small_and_long_faces(4);
  Progress silent;
  BoxTree whole(faces.positions, faces.triangles, silent);
  const std::vector<Triangle> patch(faces.triangles.begin() + faces.small + 10,
                                    faces.triangles.begin() + faces.small + 12);
  const BoxTree::Box box = whole.box_of(faces.positions, patch);
  BoxTree part(whole, box);
  const auto overlapping = [&](const BoxTree& tree, const BoxTree::Box& within) {
    std::vector<Index> found;
    tree.for_each_overlap(within, [&](Index f) { found.push_back(f); });
    return found;
  };
  const auto expect_same = [&] {
    EXPECT_EQ(overlapping(part, box), overlapping(whole, box)) << "in the same order";
    for (Index f = 0; f < static_cast<Index>(faces.triangles.size()); ++f) {
      const BoxTree::Box of_face = whole.box_of(faces.positions, faces.triangles[f]);
      const bool is_within = of_face[0] >= box[0] && of_face[1] >= box[1] && of_face[2] >= box[2] &&
                             of_face[3] <= box[3] && of_face[4] <= box[4] && of_face[5] <= box[5];
      if (!is_within) continue;
      EXPECT_EQ(overlapping(part, of_face), overlapping(whole, of_face));
    }
  };
  const std::size_t count = overlapping(whole, box).size();
  ASSERT_GT(count, 100u);
  ASSERT_LT(2 * count, faces.triangles.size());
  expect_same();
  // Faces of the part take each other's boxes.
  const std::vector<Index> found = overlapping(part, box);
  for (std::size_t i = 0; i < 50; ++i) {
    const BoxTree::Box moved =
        whole.box_of(faces.positions, faces.triangles[found[found.size() - 1 - i]]);
    whole.set_box(found[i], moved);
    part.set_box(found[i], moved);
  }
  expect_same();
  EXPECT_TRUE(overlapping(BoxTree(whole, {1e9f, 1e9f, 1e9f, 2e9f, 2e9f, 2e9f}), box).empty());
}

TEST(BoxTree, BoxesThatTouchOverlap) {
  const BoxTree::Box box = {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f};
  EXPECT_TRUE(BoxTree::overlap(box, box));
  for (int axis = 0; axis < 3; ++axis) {
    BoxTree::Box beside = box;
    beside[axis] = 1.0f;
    beside[axis + 3] = 2.0f;
    EXPECT_TRUE(BoxTree::overlap(box, beside) && BoxTree::overlap(beside, box));
    beside[axis] = 1.5f;
    EXPECT_FALSE(BoxTree::overlap(box, beside) || BoxTree::overlap(beside, box));
  }
}

}  // namespace
}  // namespace shrinkwrap
