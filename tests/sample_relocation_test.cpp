// Samples that sit in the wrong place of a mesh.
#include "edge_optimisation/sample_relocation.h"

#include <gtest/gtest.h>

#include <algorithm>

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
constexpr double kLeastHeight = 1e-3;

// A sphere whose vertex 20 lies where the middle of a face is, a quarter of the way round.
constexpr Index kDisplaced = 20;
SurfaceMesh sphere_with_one_displaced() {
  SurfaceMesh mesh = icosphere(3);
  const Vec3 there = Vec3(mesh.position[kDisplaced].unitOrthogonal());
  Index nearest = 0;
  const auto middle = [&](Index f) {
    const Triangle t = mesh.triangle(f);
    return Vec3((mesh.position[t[0]] + mesh.position[t[1]] + mesh.position[t[2]]) / 3.0);
  };
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if ((middle(f) - there).norm() < (middle(nearest) - there).norm()) nearest = f;
  mesh.position[kDisplaced] = 1.02 * middle(nearest);
  return mesh;
}

TEST(SampleRelocation, PutsASampleWhereItBelongs) {
  SurfaceMesh mesh = sphere_with_one_displaced();
  const std::vector<Vec3> position = mesh.position;
  const Index before = count_pairs(mesh);
  ASSERT_GT(before, 3);
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  const std::vector<Index> changed =
      relocate_sample(mesh, meetings, kDisplaced, {}, {kLeastHeight});
  EXPECT_FALSE(changed.empty());
  EXPECT_EQ(count_pairs(mesh), 0);
  EXPECT_EQ(meetings.pair_count(), 0);
  EXPECT_EQ(mesh.valence(kDisplaced), 3);
  EXPECT_EQ(mesh.position, position);
  expect_closed_manifold(mesh, 1, 0);
}

TEST(SampleRelocation, LowersTheNumberOfPairsOrLeavesTheMeshAlone) {
  Random random(5);
  SurfaceMesh mesh = icosphere(3);
  const double edge = (mesh.position[mesh.target(0)] - mesh.position[mesh.origin(0)]).norm();
  for (Vec3& p : mesh.position) p += edge * random.in_cube();
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  int relocated = 0, left = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const std::vector<Triangle> before = mesh.triangles();
    const Index pairs_before = meetings.pair_count();
    const std::vector<Index> changed = relocate_sample(mesh, meetings, v, {}, {kLeastHeight});
    const std::vector<Triangle> after = mesh.triangles();
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      const bool has_changed = std::binary_search(changed.begin(), changed.end(), f);
      ASSERT_TRUE(has_changed || after[f] == before[f]) << "face " << f;
    }
    ASSERT_EQ(meetings.pair_count(), count_pairs(mesh)) << "vertex " << v;
    if (changed.empty()) {
      ++left;
    } else {
      ++relocated;
      ASSERT_LT(meetings.pair_count(), pairs_before);
    }
  }
  EXPECT_GT(relocated, 50);
  EXPECT_GT(left, 50);
  expect_closed_manifold(mesh, 1, 0);
}

TEST(SampleRelocation, FixedFacesStay) {
  SurfaceMesh mesh = sphere_with_one_displaced();
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  const Index one = SurfaceMesh::face(mesh.outgoing(kDisplaced));
  EXPECT_TRUE(relocate_sample(mesh, meetings, kDisplaced, {one}, {kLeastHeight}).empty());
  // All but the faces around the vertex: it has no place to go.
  std::vector<char> is_around(static_cast<std::size_t>(mesh.face_slots()), 0);
  mesh.for_each_outgoing(kDisplaced, [&](Index h) { is_around[SurfaceMesh::face(h)] = 1; });
  std::vector<Index> others;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (!is_around[f]) others.push_back(f);
  const std::vector<Triangle> before = mesh.triangles();
  relocate_sample(mesh, meetings, kDisplaced, others, {kLeastHeight});
  for (const Index f : others) EXPECT_EQ(mesh.triangle(f), before[f]);
  EXPECT_EQ(meetings.pair_count(), count_pairs(mesh));
}

TEST(SampleRelocation, StaysWithinAPatch) {
  SurfaceMesh mesh = sphere_with_one_displaced();
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  std::vector<Index> around;
  mesh.for_each_outgoing(kDisplaced, [&](Index h) { around.push_back(SurfaceMesh::face(h)); });
  std::sort(around.begin(), around.end());
  RelocationLimits limits{kLeastHeight};
  limits.patch = &around;
  limits.most_added = 100;
  const std::vector<Triangle> before = mesh.triangles();
  // A ring has no other place for its middle: the vertex comes back into one of its faces.
  const std::vector<Index> changed = relocate_sample(mesh, meetings, kDisplaced, {}, limits);
  EXPECT_TRUE(std::includes(around.begin(), around.end(), changed.begin(), changed.end()));
  for (Index f = 0; f < mesh.face_slots(); ++f)
    EXPECT_TRUE(mesh.triangle(f) == before[f] ||
                std::binary_search(around.begin(), around.end(), f))
        << "face " << f;
  EXPECT_EQ(meetings.pair_count(), count_pairs(mesh));
  const std::vector<Index> none;
  limits.patch = &none;
  EXPECT_TRUE(relocate_sample(mesh, meetings, kDisplaced, {}, limits).empty());
}

TEST(SampleRelocation, AddsNoMorePairsThanItMay) {
  Random random(6);
  SurfaceMesh mesh = icosphere(3);
  const double edge = (mesh.position[mesh.target(0)] - mesh.position[mesh.origin(0)]).norm();
  for (Vec3& p : mesh.position) p += 0.3 * edge * random.in_cube();
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  constexpr int kMost = 3;
  int more = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const Index before = meetings.pair_count();
    relocate_sample(mesh, meetings, v, {}, {kLeastHeight, kMost});
    ASSERT_LE(meetings.pair_count() - before, kMost);
    more += meetings.pair_count() > before;
  }
  EXPECT_GT(more, 10);
  EXPECT_EQ(meetings.pair_count(), count_pairs(mesh));
  expect_closed_manifold(mesh, 1, 0);
}

TEST(SampleRelocation, WithoutTestsNothingIsDone) {
  SurfaceMesh mesh = sphere_with_one_displaced();
  const std::vector<Triangle> before = mesh.triangles();
  Progress progress;
  for (const std::int64_t tests : {0, 3, 30}) {
    FaceMeetings meetings(mesh, tests, progress);
    EXPECT_TRUE(relocate_sample(mesh, meetings, kDisplaced, {}, {kLeastHeight}).empty());
    EXPECT_EQ(meetings.tests(), tests);
    EXPECT_EQ(mesh.triangles(), before);
  }
}

}  // namespace
}  // namespace shrinkwrap
