// Sets of faces of small meshes.
#include "mesh/face_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::icosphere;
using testing::torus_mesh;

bool share_vertex(const SurfaceMesh& mesh, Index f, Index g) {
  const Triangle s = mesh.triangle(f), t = mesh.triangle(g);
  return std::any_of(s.begin(), s.end(),
                     [&](Index v) { return std::find(t.begin(), t.end(), v) != t.end(); });
}

TEST(FacePatches, RingsGrowByTheFacesThatShareAVertex) {
  const SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> one = {100};
  EXPECT_EQ(faces_near(mesh, one, 0), one);
  std::vector<Index> expected;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (share_vertex(mesh, f, 100)) expected.push_back(f);
  EXPECT_EQ(faces_near(mesh, one, 1), expected);
  EXPECT_EQ(faces_near(mesh, one, 2), faces_near(mesh, expected, 1));
  EXPECT_EQ(faces_around(mesh, corners_of(mesh, one)), expected);
  EXPECT_EQ(corners_of(mesh, one).size(), 3u);
}

TEST(FacePatches, EdgesAreToldOnce) {
  const SurfaceMesh mesh = icosphere(2);
  std::vector<Index> all;
  for (Index f = 0; f < mesh.face_slots(); ++f) all.push_back(f);
  const std::vector<Index> edges = edges_of(mesh, all);
  EXPECT_EQ(2 * edges.size(), 3 * all.size());
  for (const Index h : edges) EXPECT_LT(h, mesh.twin(h));
  EXPECT_EQ(edges_of(mesh, {5}).size(), 3u);
}

TEST(FacePatches, BordersAreLoopsAroundASet) {
  const SurfaceMesh mesh = torus_mesh(40, 20);
  std::vector<char> is_in(static_cast<std::size_t>(mesh.face_slots()), 1);
  EXPECT_TRUE(border_loops_of(mesh, is_in).empty());
  // But for what is around one ring of vertices around the tube.
  std::vector<Index> ring(20);
  std::iota(ring.begin(), ring.end(), 0);
  for (const Index f : faces_around(mesh, ring)) is_in[f] = 0;
  const auto borders = border_loops_of(mesh, is_in);
  ASSERT_EQ(borders.size(), 2u);
  for (const auto& loop : borders) {
    EXPECT_EQ(loop.size(), 20u);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      EXPECT_EQ(mesh.target(loop[k]), mesh.origin(loop[(k + 1) % loop.size()]));
      EXPECT_TRUE(is_in[SurfaceMesh::face(loop[k])]);
      EXPECT_FALSE(is_in[SurfaceMesh::face(mesh.twin(loop[k]))]);
    }
  }
}

TEST(FacePatches, BordersPassNoVertexTwice) {
  // Some discs around two vertices touch at vertices between them, and so does what is around both.
  const SurfaceMesh mesh = icosphere(3);
  for (Index other = 1; other < mesh.vertex_slots(); ++other)
    for (const char is_disc : {0, 1}) {
      std::vector<char> is_in(static_cast<std::size_t>(mesh.face_slots()), !is_disc);
      std::size_t sides = 0;
      for (const Index f : faces_around(mesh, {0, other})) is_in[f] = is_disc;
      for (Index h = 0; h < mesh.halfedge_slots(); ++h)
        sides += is_in[SurfaceMesh::face(h)] && !is_in[SurfaceMesh::face(mesh.twin(h))];
      for (const auto& loop : border_loops_of(mesh, is_in)) {
        std::set<Index> passed;
        for (const Index h : loop) EXPECT_TRUE(passed.insert(mesh.origin(h)).second) << other;
        sides -= loop.size();
      }
      EXPECT_EQ(sides, 0u) << other;
    }
}

TEST(FacePatches, ClustersAreSetsThatDoNotTouch) {
  const SurfaceMesh mesh = torus_mesh(40, 20);
  std::vector<Index> faces;  // every seventh: some touch others, some do not
  for (Index f = 0; f < mesh.face_slots(); f += 7) faces.push_back(f);
  const auto clusters = clusters_of(mesh, faces);
  ASSERT_GT(clusters.size(), 1u);
  std::vector<Index> all;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    EXPECT_TRUE(std::is_sorted(clusters[i].begin(), clusters[i].end()));
    if (i > 0) {
      EXPECT_LE(clusters[i - 1].size(), clusters[i].size());
    }
    all.insert(all.end(), clusters[i].begin(), clusters[i].end());
    for (std::size_t j = 0; j < i; ++j)
      for (const Index f : clusters[i])
        for (const Index g : clusters[j]) EXPECT_FALSE(share_vertex(mesh, f, g));
    // Each is connected: what is reached from its first face is all of it.
    std::set<Index> reached = {clusters[i].front()};
    for (std::size_t before = 0; before != reached.size();) {
      before = reached.size();
      for (const Index f : clusters[i])
        if (std::any_of(reached.begin(), reached.end(),
                        [&](Index g) { return share_vertex(mesh, f, g); }))
          reached.insert(f);
    }
    EXPECT_EQ(reached.size(), clusters[i].size());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, faces);
}

TEST(FacePatches, LinkedFacesAreInOneCluster) {
  const SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> faces = {0, 600, 900}, none, to_last = {900, 901};
  EXPECT_EQ(clusters_of(mesh, faces).size(), 3u);
  const auto linked = [&](Index f) -> const std::vector<Index>& { return f == 0 ? to_last : none; };
  EXPECT_EQ(clusters_of(mesh, faces, linked), (std::vector<std::vector<Index>>{{600}, {0, 900}}));
}

}  // namespace
}  // namespace shrinkwrap
