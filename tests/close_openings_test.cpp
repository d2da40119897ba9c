// Openings closed by removing the vertices that are no samples, with and without cuts.
#include "complete_matching/close_openings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "complete_matching/openings.h"
#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_meeting_faces;
using testing::expect_closed_manifold;
using testing::oriented_cloud;
using testing::Random;
using testing::ShapeKind;

// A sphere of which a part of the vertices, drawn at random, are no samples.
SurfaceMesh sphere_with_extra_vertices(double part, unsigned seed, Index& first_extra) {
  SurfaceMesh mesh = testing::icosphere(3);
  Random random(seed);
  std::vector<char> is_extra(mesh.position.size());
  for (char& extra : is_extra) extra = random.uniform() < part;
  std::vector<Index> new_index(mesh.position.size());
  Index count = 0;
  for (std::size_t v = 0; v < is_extra.size(); ++v)
    if (!is_extra[v]) new_index[v] = count++;
  first_extra = count;
  for (std::size_t v = 0; v < is_extra.size(); ++v)
    if (is_extra[v]) new_index[v] = count++;
  mesh.renumber(new_index);
  return mesh;
}

// Once the faces of openings are dropped, each vertex has one fan of faces, and each sample a face.
void expect_simple_borders(const CompleteMatching& matching, Index samples) {
  const SurfaceMesh& mesh = matching.mesh;
  std::vector<char> stays(static_cast<std::size_t>(mesh.face_slots()), 1);
  for (const Index f : matching.opening_faces) stays[f] = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    Index fans = 0, faces = 0;
    mesh.for_each_outgoing(v, [&](Index h) {
      faces += stays[SurfaceMesh::face(h)];
      fans += stays[SurfaceMesh::face(h)] && !stays[SurfaceMesh::face(mesh.twin(h))];
    });
    EXPECT_LE(fans, 1) << "vertex " << v;
    if (v < samples) {
      EXPECT_GT(faces, 0) << "sample " << v;
    }
  }
}

TEST(Openings, HaveBordersWithoutPinchesAndLoseNoSample) {
  Index kept_in_all = 0;
  for (const double part : {0.02, 0.1, 0.3, 0.6, 0.9})
    for (const unsigned seed : {1u, 2u, 3u}) {
      SCOPED_TRACE(::testing::Message() << "part " << part << ", seed " << seed);
      Index first_extra = 0;
      CompleteMatching matching;
      matching.mesh = sphere_with_extra_vertices(part, seed, first_extra);
      PointCloud cloud;  // of no spacing: no notch is narrow enough to be filled
      cloud.position.resize(static_cast<std::size_t>(first_extra));
      cloud.local_spacing.resize(static_cast<std::size_t>(first_extra), 0.0f);
      Progress silent;
      leave_openings(matching, cloud, silent);
      expect_simple_borders(matching, first_extra);
      if (part < 0.05) {
        EXPECT_GT(matching.opening_faces.size(), 0u);
      }
      // Where samples are few, some extra vertices had to stay, lest one be lost that nothing joins
      // to a border. These go to their neighbours.
      const auto extra = [&] {
        return extra_vertices_kept(matching.mesh, first_extra, matching.opening_faces);
      };
      const Index before = extra();
      if (part < 0.8) {
        EXPECT_EQ(before, 0);
      }
      kept_in_all += before;
      matching.sample_of_vertex.assign(matching.mesh.position.size(), SampleId::none);
      close_openings(matching, first_extra, silent);
      EXPECT_LE(extra(), before / 2);
      expect_simple_borders(matching, first_extra);
      expect_closed_manifold(matching.mesh, 1, 0);
      std::vector<Triangle> kept;
      for (Index f = 0; f < matching.mesh.face_slots(); ++f)
        if (!std::binary_search(matching.opening_faces.begin(), matching.opening_faces.end(), f))
          kept.push_back(matching.mesh.triangle(f));
      EXPECT_EQ(self_intersecting_faces(matching.mesh.position, kept, silent).size(), 0u);
    }
  EXPECT_GT(kept_in_all, 0) << "nothing to close";
}

TEST(Openings, AreClosedWithoutCuttingAnything) {
  for (const double part : {0.05, 0.3, 0.6})
    for (const unsigned seed : {1u, 2u, 3u}) {
      SCOPED_TRACE(::testing::Message() << "part " << part << ", seed " << seed);
      Index first_extra = 0;
      SurfaceMesh mesh = sphere_with_extra_vertices(part, seed, first_extra);
      Progress silent;
      const std::vector<char> spans = close_openings(mesh, first_extra, silent).spans;
      ASSERT_EQ(static_cast<Index>(spans.size()), mesh.face_slots());
      EXPECT_EQ(mesh.vertex_count(), first_extra);
      mesh.compact();
      expect_closed_manifold(mesh, 1, 0);
      EXPECT_EQ(count_meeting_faces(mesh), 0);
    }
}

TEST(Openings, AreClosedWhereTheRimIsNoFanFromAnyCorner) {
  // A comb in the plane, a sample below it, and what is no sample above.
  constexpr Index kTeeth = 12;
  std::vector<Vec3> positions;
  for (Index i = 0; i < kTeeth; ++i) {
    positions.push_back({1.0 * i, 4.0, 0.0});
    positions.push_back({i + 0.5, i + 1 < kTeeth ? 0.5 : 4.0, 0.0});
  }
  positions.push_back({kTeeth - 0.5, 0.0, 0.0});
  positions.push_back({0.0, 0.0, 0.0});
  const Index rim = static_cast<Index>(positions.size());
  positions.push_back({0.5 * kTeeth, 0.2, -1.0});
  positions.push_back({0.5 * kTeeth, 0.2, 1.0});
  std::vector<Triangle> triangles;
  for (Index i = 0; i < rim; ++i) {
    triangles.push_back({rim, i, (i + 1) % rim});
    triangles.push_back({rim + 1, (i + 1) % rim, i});
  }
  SurfaceMesh mesh = SurfaceMesh::from_triangles(positions, triangles);
  ASSERT_EQ(count_meeting_faces(mesh), 0);
  Progress silent;
  close_openings(mesh, rim + 1, silent);
  EXPECT_EQ(mesh.vertex_count(), rim + 1);
  mesh.compact();
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(count_meeting_faces(mesh), 0);
}

TEST(Openings, ThatAreLeftOpenStayOpen) {
  Index first_extra = 0;
  CompleteMatching matching;
  matching.mesh = sphere_with_extra_vertices(0.3, 4, first_extra);
  SurfaceMesh& mesh = matching.mesh;
  matching.sample_of_vertex.assign(mesh.position.size(), SampleId::none);
  const Index kept = first_extra + 5;
  const Vec3 place = mesh.position[kept];
  mesh.for_each_outgoing(kept,
                         [&](Index h) { matching.opening_faces.push_back(SurfaceMesh::face(h)); });
  std::sort(matching.opening_faces.begin(), matching.opening_faces.end());
  matching.spanning_faces = matching.opening_faces;
  Progress silent;
  const ClosingOfMatching closing = close_openings(matching, first_extra, silent);
  EXPECT_FALSE(closing.removed.empty());
  EXPECT_GT(closing.tests, 0);
  // All others are of faces that stay.
  EXPECT_EQ(mesh.vertex_count(), first_extra + 1);
  EXPECT_EQ(static_cast<Index>(matching.sample_of_vertex.size()), mesh.vertex_count());
  EXPECT_GE(matching.opening_faces.size(), 3u);
  for (const Index f : matching.opening_faces) {
    const Triangle t = mesh.triangle(f);
    EXPECT_TRUE(
        std::any_of(t.begin(), t.end(), [&](Index v) { return mesh.position[v] == place; }));
    EXPECT_TRUE(
        std::binary_search(matching.spanning_faces.begin(), matching.spanning_faces.end(), f));
  }
  expect_simple_borders(matching, first_extra);
  expect_closed_manifold(mesh, 1, 0);
}

// An icosahedron, its last corner extra, and a needle inside that stands below that corner: any
// face between the neighbours of the corner would cut the needle.
SurfaceMesh icosahedron_with_needle() {
  const SurfaceMesh icosahedron = testing::icosphere(0);
  const Vec3 tip = icosahedron.position.back(), across = tip.unitOrthogonal() * 0.01;
  std::vector<Vec3> positions = {0.9 * tip, -0.5 * tip, -0.5 * tip + across,
                                 -0.5 * tip + tip.cross(across)};
  std::vector<Triangle> triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  positions.insert(positions.end(), icosahedron.position.begin(), icosahedron.position.end());
  for (Triangle t : icosahedron.triangles()) {
    for (Index& v : t) v += 4;
    triangles.push_back(t);
  }
  return SurfaceMesh::from_triangles(positions, triangles);
}

TEST(Openings, KeepAnExtraVertexThatCannotGo) {
  SurfaceMesh mesh = icosahedron_with_needle();
  Progress silent;
  const Closing closing = close_openings(mesh, mesh.vertex_slots() - 1, silent);
  EXPECT_EQ(mesh.vertex_count(), mesh.vertex_slots());
  EXPECT_EQ(closing.trials, 3) << "with faces that turn, and after a flip; then nothing changes";
  expect_closed_manifold(mesh, 2, 0);
  EXPECT_EQ(count_meeting_faces(mesh), 0);

  // Without the needle it goes.
  SurfaceMesh icosahedron = testing::icosphere(0);
  const Index last = icosahedron.vertex_slots() - 1;
  close_openings(icosahedron, last, silent);
  EXPECT_TRUE(icosahedron.is_removed_vertex(last));
}

// Three faces of the needle stand in the way of one of the three that close the corner.
TEST(Openings, LoseAnExtraVertexWithNoMoreCutsThanAllowed) {
  for (const Index most_cuts : {2, 3, 64}) {
    SCOPED_TRACE(most_cuts);
    SurfaceMesh mesh = icosahedron_with_needle();
    const Index last = mesh.vertex_slots() - 1;
    Progress silent;
    ClosingOptions options;
    options.most_cuts = most_cuts;
    close_openings(mesh, last, silent, {}, options);
    EXPECT_EQ(mesh.is_removed_vertex(last), most_cuts >= 3);
    mesh.compact();
    expect_closed_manifold(mesh, 2, 0);
    EXPECT_EQ(count_meeting_faces(mesh), most_cuts >= 3 ? 4 : 0);
  }
}

TEST(Openings, KeepTheVerticesThatAreHeld) {
  SurfaceMesh mesh = testing::icosphere(0);
  const Index last = mesh.vertex_slots() - 1;
  Progress silent;
  ClosingOptions options;
  options.held = {last};
  close_openings(mesh, last - 1, silent, {}, options);
  EXPECT_TRUE(mesh.is_removed_vertex(last - 1));
  EXPECT_FALSE(mesh.is_removed_vertex(last));
}

// A disc whose rim of samples has one vertex on either side, the last of which is no sample.
SurfaceMesh double_cone(Index rim) {
  constexpr double kTurn = 6.283185307179586;
  std::vector<Vec3> positions;
  for (Index i = 0; i < rim; ++i)
    positions.emplace_back(std::cos(kTurn * i / rim), std::sin(kTurn * i / rim), 0.0);
  positions.emplace_back(0.0, 0.0, -1.0);
  positions.emplace_back(0.0, 0.0, 0.5);
  std::vector<Triangle> triangles;
  for (Index i = 0; i < rim; ++i) {
    triangles.push_back({rim, (i + 1) % rim, i});
    triangles.push_back({rim + 1, i, (i + 1) % rim});
  }
  return SurfaceMesh::from_triangles(positions, triangles);
}

TEST(Openings, OfAFlatRimAreClosedWithoutATestOfEachPair) {
  constexpr Index kRim = 1000;
  SurfaceMesh mesh = double_cone(kRim);
  Progress silent;
  const Closing closing = close_openings(mesh, kRim + 1, silent);
  EXPECT_EQ(mesh.vertex_count(), kRim + 1);
  // The faces of a fan among themselves alone.
  EXPECT_LT(closing.tests, kRim * (kRim - 1) / 2);
  mesh.compact();
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(count_meeting_faces(mesh), 0);
}

TEST(Openings, AreClosedWithinTheTests) {
  constexpr Index kRim = 1000;
  for (const std::int64_t tests : {1, 1000, 5000}) {
    SurfaceMesh mesh = double_cone(kRim);
    Progress silent;
    ClosingOptions options;
    options.max_tests = tests;
    const Closing closing = close_openings(mesh, kRim + 1, silent, {}, options);
    EXPECT_EQ(mesh.vertex_count(), kRim + 2) << "what would cost more stays";
    EXPECT_LE(closing.tests, tests + 2 * kRim);
    expect_closed_manifold(mesh, 1, 0);
  }
}

TEST(Openings, CanBeCancelledWithinOneVertex) {
  constexpr Index kRim = 1000;
  SurfaceMesh mesh = double_cone(kRim);
  bool may_go_on = true;
  Progress progress([&](double, const char*) { return may_go_on; }, {Stage::complete_matching});
  progress.begin(Stage::complete_matching);
  may_go_on = false;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // lest the callback be spared
  EXPECT_THROW(close_openings(mesh, kRim + 1, progress), Cancelled);
  EXPECT_FALSE(mesh.is_removed_vertex(kRim + 1));
}

}  // namespace
}  // namespace shrinkwrap
