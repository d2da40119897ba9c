// Pairs of faces kept up to date, against pairs found anew.
#include "mesh/face_meetings.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "expect_mesh.h"
#include "mesh/self_intersection.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::faces_of_pairs;
using testing::icosphere;
using testing::Random;

using Pairs = std::vector<FaceMeetings::Pair>;

constexpr std::int64_t kManyTests = 100000000;

Pairs found_anew(const SurfaceMesh& mesh) {
  Progress progress;
  return self_intersections(mesh.position, mesh.triangles(), progress);
}

SurfaceMesh shaken_sphere(Random& random) {
  SurfaceMesh mesh = icosphere(3);
  const double edge = (mesh.position[mesh.target(0)] - mesh.position[mesh.origin(0)]).norm();
  for (Vec3& p : mesh.position) p += 0.7 * edge * random.in_cube();
  return mesh;
}

void flip(SurfaceMesh& mesh, Index h, FaceMeetings& meetings) {
  mesh.flip(h);
  const Index f = SurfaceMesh::face(h), g = SurfaceMesh::face(mesh.twin(h));
  Pairs pairs;
  if (meetings.meet(mesh.triangle(f), mesh.triangle(g))) pairs.emplace_back(f, g);
  const auto skip = [&](Index other) { return other == f || other == g; };
  EXPECT_TRUE(meetings.find(mesh.triangle(f), f, 1000, skip, pairs));
  EXPECT_TRUE(meetings.find(mesh.triangle(g), g, 1000, skip, pairs));
  meetings.update_boxes({f, g});
  meetings.replace({f, g}, pairs);
}

TEST(FaceMeetings, AreThoseOfTheMeshAfterEveryChange) {
  Random random(1);
  SurfaceMesh mesh = shaken_sphere(random);
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  for (int change = 0; change < 100; ++change) {
    const Pairs expected = found_anew(mesh);
    ASSERT_GT(expected.size(), 10u);
    ASSERT_EQ(meetings.pair_count(), static_cast<Index>(expected.size()));
    ASSERT_EQ(meetings.faces(), faces_of_pairs(expected));
    ASSERT_EQ(meetings.pairs_of(meetings.faces()), expected);

    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_flip_legal(h)) continue;
    flip(mesh, h, meetings);
  }
}

TEST(FaceMeetings, APatchHasAnAccountOfItsOwn) {
  Random random(5);
  SurfaceMesh mesh = shaken_sphere(random);
  Progress progress;
  std::vector<Index> absent;
  for (Index f = 3; f < mesh.face_slots(); f += 7) absent.push_back(f);
  FaceMeetings whole(mesh, kManyTests, progress, absent);
  std::vector<Index> patch;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (mesh.position[mesh.triangle(f)[0]].z() > 0.6) patch.push_back(f);
  FaceMeetings part(whole, patch, 1000000);
  EXPECT_EQ(part.pairs_of(patch), whole.pairs_of(patch));
  const Pairs at_first = whole.pairs_of(patch);
  int flips = 0;
  for (int change = 0; change < 1000; ++change) {
    const Index h = random.below(mesh.halfedge_slots());
    const Index f = SurfaceMesh::face(h), g = SurfaceMesh::face(mesh.twin(h));
    const auto may_change = [&](Index face) {
      return std::binary_search(patch.begin(), patch.end(), face) &&
             !std::binary_search(absent.begin(), absent.end(), face);
    };
    if (!may_change(f) || !may_change(g) || !mesh.is_flip_legal(h)) continue;
    flip(mesh, h, part);
    ++flips;
  }
  ASSERT_GT(flips, 20);
  part.update_boxes(patch);
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    if (!BoxTree::overlap(whole.box_around({f}), whole.box_around(patch))) continue;
    const std::vector<Index> found = part.faces_around({mesh.triangle(f)});
    EXPECT_NE(std::binary_search(absent.begin(), absent.end(), f),
              std::count(found.begin(), found.end(), f) == 1)
        << "absent faces have no box, nor take that of another";
  }
  EXPECT_EQ(whole.pairs_of(patch), at_first) << "it knows nothing of that yet";
  ASSERT_NE(part.pairs_of(patch), at_first);
  EXPECT_GT(part.tests(), 0);
  whole.take_over(patch, part);
  EXPECT_EQ(whole.tests(), part.tests());
  FaceMeetings anew(mesh, kManyTests, progress, absent);
  EXPECT_EQ(whole.pair_count(), anew.pair_count());
  EXPECT_EQ(whole.pairs_of(whole.faces()), anew.pairs_of(anew.faces()));
  // The boxes, too, are those of now.
  for (const Index f : patch) {
    Pairs found, expected;
    const auto skip = [&](Index other) { return other == f; };
    EXPECT_TRUE(whole.find(mesh.triangle(f), f, 1000, skip, found));
    EXPECT_TRUE(anew.find(mesh.triangle(f), f, 1000, skip, expected));
    std::sort(found.begin(), found.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(found, expected);
    Pairs of_part;
    EXPECT_TRUE(part.find(mesh.triangle(f), f, 1000, skip, of_part));
    std::sort(of_part.begin(), of_part.end());
    EXPECT_EQ(of_part, expected);
  }
}

TEST(FaceMeetings, AbsentFacesMeetNothing) {
  Random random(3);
  const SurfaceMesh mesh = shaken_sphere(random);
  Progress progress;
  const Pairs all = found_anew(mesh);
  std::vector<Index> absent;
  for (Index f = 0; f < mesh.face_slots(); f += 3) absent.push_back(f);
  Pairs expected;
  for (const auto& [f, g] : all)
    if (f % 3 != 0 && g % 3 != 0) expected.emplace_back(f, g);
  ASSERT_GT(expected.size(), 10u);
  ASSERT_LT(expected.size(), all.size());
  const FaceMeetings meetings(mesh, kManyTests, progress, absent);
  EXPECT_EQ(meetings.pairs_of(meetings.faces()), expected);
  EXPECT_EQ(meetings.all_faces(progress), faces_of_pairs(expected));
  for (const auto& [f, g] : all) {
    if (f % 3 == 0 || g % 3 > 0) continue;
    Pairs pairs;
    EXPECT_TRUE(meetings.find(
        mesh.triangle(f), f, 1000, [&](Index) { return false; }, pairs));
    for (const auto& pair : pairs) EXPECT_NE(pair.second % 3, 0);
  }
}

TEST(FaceMeetings, MoreThanAskedForAreNotFound) {
  Random random(2);
  const SurfaceMesh mesh = shaken_sphere(random);
  Progress progress;
  const FaceMeetings meetings(mesh, kManyTests, progress);
  const Index f = meetings.faces().front();
  const std::size_t count = meetings.faces_met_by(f).size();
  const auto skip = [&](Index g) { return g == f; };
  Pairs pairs;
  EXPECT_TRUE(meetings.find(mesh.triangle(f), f, count, skip, pairs));
  EXPECT_EQ(pairs.size(), count);
  pairs.clear();
  EXPECT_FALSE(meetings.find(mesh.triangle(f), f, count - 1, skip, pairs));
}

TEST(FaceMeetings, TestsEndAtTheirBound) {
  Random random(3);
  const SurfaceMesh mesh = shaken_sphere(random);
  Progress progress;
  const FaceMeetings meetings(mesh, 100, progress);
  EXPECT_EQ(meetings.tests(), 0);
  const auto skip = [](Index) { return false; };
  bool was_refused = false;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    Pairs pairs;
    const bool is_known = meetings.find(mesh.triangle(f), f, 1000, skip, pairs);
    EXPECT_FALSE(is_known && was_refused) << "no test is left";
    was_refused = !is_known;
  }
  EXPECT_TRUE(was_refused);
  EXPECT_EQ(meetings.tests(), 100);
  EXPECT_FALSE(meetings.has_tests_left());
}

TEST(FaceMeetings, KeepNoMorePairsThanTheMeshHasRoomForButCountAllFaces) {
  // A heap, in which each face meets hundreds, and a sphere that is fit for repair.
  Random random(4);
  SurfaceMesh heap = icosphere(3);
  for (Vec3& p : heap.position) p = random.in_cube();
  const Index heap_faces = heap.face_slots();
  const SurfaceMesh mesh =
      testing::joined({heap, testing::placed(shaken_sphere(random), 1.0, Vec3(4.0, 0.0, 0.0))});
  const Pairs all = found_anew(mesh);
  const std::size_t bound =
      std::max(FaceMeetings::kPairsPerFace * static_cast<std::size_t>(mesh.face_slots()),
               FaceMeetings::kLeastPairs);
  ASSERT_GT(all.size(), 2 * bound);

  Pairs pairs[2];
  for (const int threads : {1, 2}) {
    tbb::task_arena arena(threads);
    arena.execute([&] {
      Progress progress;
      const FaceMeetings meetings(mesh, kManyTests, progress);
      EXPECT_FALSE(meetings.has_all_pairs());
      EXPECT_LE(static_cast<std::size_t>(meetings.pair_count()), bound);
      const std::vector<Index> faces = faces_of_pairs(all);
      EXPECT_EQ(meetings.all_faces(progress), faces);
      EXPECT_EQ(meetings.faces_at_first(), static_cast<Index>(faces.size()));
      pairs[threads - 1] = meetings.pairs_of(meetings.faces());
    });
  }
  EXPECT_EQ(pairs[0], pairs[1]);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), pairs[0].begin(), pairs[0].end()));
  // The heap takes nothing from the sphere, but for faces that share a cluster with it.
  const auto in_sphere = [&](const FaceMeetings::Pair& pair) { return pair.first >= heap_faces; };
  EXPECT_GT(std::count_if(pairs[0].begin(), pairs[0].end(), in_sphere),
            0.9 * std::count_if(all.begin(), all.end(), in_sphere));
}

}  // namespace
}  // namespace shrinkwrap
