// Names of faces after a removal, and the vertices that are held in the next trial.
#include "mesh/removed_vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::icosphere;

TEST(RemovedVertices, FacesAreNamedAsTheyAreThen) {
  const std::vector<Triangle> faces = {{0, 1, 2}, {1, 3, 5}, {2, 5, 6}, {0, 2, 9}, {4, 6, 9}};
  EXPECT_EQ(without_vertices(faces, {3, 4}),
            (std::vector<Triangle>{{0, 1, 2}, {2, 3, 4}, {0, 2, 7}}));
  EXPECT_EQ(without_vertices(faces, {}), faces);
  EXPECT_TRUE(without_vertices({}, {1}).empty());
}

// A sphere, and the same with the hats at the outermost vertices along x cut off: each is spanned
// by a fan from one corner of the rim.
class HarmOfRemovals : public ::testing::Test {
 protected:
  HarmOfRemovals() : before_(icosphere(3)) {
    const auto along_x = [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); };
    const auto ends =
        std::minmax_element(before_.position.begin(), before_.position.end(), along_x);
    low_ = static_cast<Index>(ends.first - before_.position.begin());
    high_ = static_cast<Index>(ends.second - before_.position.begin());
    removed_ = {std::min(low_, high_), std::max(low_, high_)};
    std::vector<Triangle> faces = without_vertices(before_.triangles(), removed_);
    for (const Index v : removed_) {
      std::vector<Triangle> fan;
      Index first = kNone;
      before_.for_each_outgoing(v, [&](Index h) {
        const Index edge = SurfaceMesh::next(h);
        if (first == kNone) first = before_.origin(edge);
        if (before_.origin(edge) != first && before_.target(edge) != first)
          fan.push_back({first, before_.origin(edge), before_.target(edge)});
      });
      for (const Triangle& t : without_vertices(fan, removed_)) faces.push_back(t);
    }
    std::vector<Vec3> position;
    for (Index v = 0; v < before_.vertex_slots(); ++v)
      if (v != low_ && v != high_) position.push_back(before_.position[v]);
    after_ = SurfaceMesh::from_triangles(std::move(position), faces);
  }

  // The faces of a mesh that lie beyond so much along x, on the side of its sign.
  static std::vector<Index> faces_beyond(const SurfaceMesh& mesh, double x) {
    std::vector<Index> faces;
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      double least = 1.0;
      for (const Index v : mesh.triangle(f))
        least = std::min(least, x < 0.0 ? -mesh.position[v].x() : mesh.position[v].x());
      if (least > std::abs(x)) faces.push_back(f);
    }
    return faces;
  }
  std::vector<Index> to_blame(const std::vector<Index>& faces_before,
                              const std::vector<Index>& faces_after) const {
    Progress silent;
    return removed_nearest_to(before_, faces_before, removed_, after_, faces_after, silent);
  }

  SurfaceMesh before_, after_;
  Index low_ = 0, high_ = 0;
  std::vector<Index> removed_;
};

TEST_F(HarmOfRemovals, IsOfTheVertexThatWasNearest) {
  const std::vector<Index> at_low = faces_beyond(after_, -0.8), at_high = faces_beyond(after_, 0.8);
  ASSERT_FALSE(at_low.empty());
  ASSERT_FALSE(at_high.empty());
  EXPECT_EQ(to_blame({}, at_low), std::vector<Index>{low_});
  EXPECT_EQ(to_blame({}, at_high), std::vector<Index>{high_});
  std::vector<Index> both = at_low;
  both.insert(both.end(), at_high.begin(), at_high.end());
  EXPECT_EQ(to_blame({}, both), removed_);
  EXPECT_TRUE(to_blame({}, {}).empty());
}

TEST_F(HarmOfRemovals, FacesOfBeforeSayNothing) {
  const std::vector<Index> at_high = faces_beyond(after_, 0.8);
  const std::vector<Index> known = faces_beyond(before_, 0.8);
  EXPECT_EQ(to_blame(known, at_high), std::vector<Index>{high_}) << "those of the fan are new";

  // Those around the fan are the same faces, by other numbers.
  std::vector<Triangle> names;
  for (const Index f : known) names.push_back(ascending_corners(before_, f));
  names = without_vertices(std::move(names), removed_);
  std::vector<Index> around;
  for (const Index f : at_high)
    if (std::find(names.begin(), names.end(), ascending_corners(after_, f)) != names.end())
      around.push_back(f);
  ASSERT_FALSE(around.empty());
  EXPECT_TRUE(to_blame(known, around).empty());
}

}  // namespace
}  // namespace shrinkwrap
