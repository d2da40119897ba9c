#include "mesh/spanning_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "edge_optimisation/intersection_repair.h"
#include "mesh/face_patches.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

TEST(SpanningFaces, AreToldAnewWhereFacesTookEachOthersSlots) {
  SurfaceMesh mesh = icosphere(1);
  std::vector<Index> spanning;
  const Index samples = mesh.vertex_slots() - 1;  // the last vertex is none
  const auto length = [&](Index f) {
    const Triangle t = mesh.triangle(f);
    const auto edge = [&](int i, int j) {
      return (mesh.position[t[i]] - mesh.position[t[j]]).norm();
    };
    return std::max({edge(0, 1), edge(1, 2), edge(2, 0)});
  };
  // Of two faces that hang together the one with the longer edges spans; others stay as they were.
  const Index f = 0, g = SurfaceMesh::face(mesh.twin(0)), far = mesh.face_slots() - 1;
  const Triangle t = mesh.triangle(g);
  mesh.position[t[0]] *= 1.5;
  if (length(f) >= length(g)) mesh.position[t[2]] *= 2.0;
  ASSERT_LT(length(f), length(g));
  const std::vector<Index> changed = {std::min(f, g), std::max(f, g)};
  spanning = {f, far};
  restore_spanning_faces(mesh, {changed}, {samples}, spanning);
  EXPECT_EQ(spanning, (std::vector<Index>{g, far}));
  restore_spanning_faces(mesh, {{f}}, {samples}, spanning);
  EXPECT_EQ(spanning, (std::vector<Index>{g, far}));
  // Where both span, or none, nothing is to be told.
  spanning = changed;
  restore_spanning_faces(mesh, {changed}, {samples}, spanning);
  EXPECT_EQ(spanning, changed);
  spanning = {far};
  restore_spanning_faces(mesh, {changed}, {samples}, spanning);
  EXPECT_EQ(spanning, std::vector<Index>{far});
  // A face with a vertex that is no sample spans before any other.
  std::vector<Index> star;
  mesh.for_each_outgoing(samples, [&](Index h) { star.push_back(SurfaceMesh::face(h)); });
  std::vector<Index> all(static_cast<std::size_t>(mesh.face_slots()));
  std::iota(all.begin(), all.end(), 0);
  std::sort(star.begin(), star.end());
  std::vector<Index> others;
  std::set_difference(all.begin(), all.end(), star.begin(), star.end(), std::back_inserter(others));
  spanning.assign(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(star.size()));
  restore_spanning_faces(mesh, {all}, {samples}, spanning);
  EXPECT_EQ(spanning, star);
}

// Of a flip at the rim both faces have the vertex that is no sample then.
TEST(SpanningFaces, AllFacesWithAVertexThatIsNoSampleAreAmongThem) {
  const SurfaceMesh mesh = icosphere(1);
  const Index samples = mesh.vertex_slots() - 1;
  std::vector<Index> star;
  mesh.for_each_outgoing(samples, [&](Index h) { star.push_back(SurfaceMesh::face(h)); });
  std::sort(star.begin(), star.end());
  std::vector<Index> spanning = {star.front()};
  restore_spanning_faces(mesh, {star}, {samples}, spanning);
  EXPECT_EQ(spanning, star);
}

// Copies of samples come after the vertices that are none.
TEST(SpanningFaces, SamplesBeyondTheExtraVerticesAreSamples) {
  const SurfaceMesh mesh = icosphere(1);
  const Index last = mesh.vertex_slots() - 1;
  std::vector<Index> star;
  mesh.for_each_outgoing(last, [&](Index h) { star.push_back(SurfaceMesh::face(h)); });
  std::sort(star.begin(), star.end());
  std::vector<Index> spanning = {star.front()};
  restore_spanning_faces(mesh, {star}, {last, last}, spanning);
  EXPECT_EQ(spanning.size(), 1u);
  restore_spanning_faces(mesh, {star}, {last, last + 1}, spanning);
  EXPECT_EQ(spanning, star);
}

// Those of one half of a torus, the longer one, whose vertices were shaken until faces met.
TEST(SpanningFaces, HangTogetherAfterARepair) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SurfaceMesh mesh = torus_mesh(60, 24);
    std::vector<Index> spanning;
    for (Index f = 0; f < mesh.face_slots(); ++f)
      if (mesh.position[mesh.triangle(f)[0]].x() > 0.0) spanning.push_back(f);
    const std::size_t count = spanning.size();
    Random random(seed);
    const double edge = (mesh.position[mesh.target(0)] - mesh.position[mesh.origin(0)]).norm();
    for (Vec3& p : mesh.position) {
      if (p.x() > 0.0) p.x() *= 4.0;
      p += 0.6 * edge * random.in_cube();
    }
    Progress silent;
    repair_self_intersections(mesh, {}, silent, {}, &spanning);
    EXPECT_EQ(spanning.size(), count);
    EXPECT_TRUE(std::is_sorted(spanning.begin(), spanning.end()));
    EXPECT_EQ(clusters_of(mesh, spanning).size(), 1u);
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
