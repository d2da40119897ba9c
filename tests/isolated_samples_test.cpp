// Samples in the middle of openings, joined to the border by a face each.
#include "complete_matching/isolated_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "mesh/self_intersection.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::icosphere;

// A sphere, of which what lies above a height is dropped.
class IsolatedSamples : public ::testing::Test {
 protected:
  void open_above(double height) {
    is_dropped.assign(static_cast<std::size_t>(mesh.face_slots()), 0);
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      const Triangle t = mesh.triangle(f);
      is_dropped[f] =
          std::any_of(t.begin(), t.end(), [&](Index v) { return mesh.position[v].z() > height; });
    }
  }
  // Samples are numbered first: those up to the height, and those at these places.
  void number_samples(double height, const std::vector<Vec3>& places) {
    const auto is_sample = [&](Index v) {
      return mesh.position[v].z() <= height ||
             std::any_of(places.begin(), places.end(), [&](const Vec3& place) {
               return (mesh.position[v] - place).norm() < 1e-9;
             });
    };
    std::vector<Index> new_index(mesh.position.size());
    Index next = 0;
    for (const bool first : {true, false}) {
      for (Index v = 0; v < mesh.vertex_slots(); ++v)
        if (is_sample(v) == first) new_index[v] = next++;
      if (first) samples = next;
    }
    mesh.renumber(new_index);
    open_above(height);
  }
  Vec3 nearest_to(const Vec3& place) const {
    return *std::min_element(mesh.position.begin(), mesh.position.end(),
                             [&](const Vec3& a, const Vec3& b) {
                               return (a - place).squaredNorm() < (b - place).squaredNorm();
                             });
  }
  Index vertex_at(const Vec3& place) const {
    return static_cast<Index>(std::find(mesh.position.begin(), mesh.position.end(), place) -
                              mesh.position.begin());
  }
  std::vector<Index> join() {
    Progress silent;
    return join_isolated_samples(mesh, samples, is_dropped, silent);
  }
  Index faces_that_stay_at(Index v) const {
    Index count = 0;
    mesh.for_each_outgoing(v, [&](Index h) { count += !is_dropped[SurfaceMesh::face(h)]; });
    return count;
  }
  std::vector<Triangle> faces_that_stay() const {
    std::vector<Triangle> faces;
    for (Index f = 0; f < mesh.face_slots(); ++f)
      if (!is_dropped[f]) faces.push_back(ascending_corners(mesh, f));
    std::sort(faces.begin(), faces.end());
    return faces;
  }

  SurfaceMesh mesh = icosphere(4);
  std::vector<char> is_dropped;
  Index samples = 0;
};

TEST_F(IsolatedSamples, GetAFaceAtTheBorder) {
  const Vec3 pole = nearest_to(Vec3::UnitZ()), beside = nearest_to(Vec3(0.3, 0.1, 0.95));
  number_samples(0.7, {pole, beside});
  ASSERT_EQ(faces_that_stay_at(vertex_at(pole)), 0);
  const std::vector<Triangle> before = faces_that_stay();
  const std::vector<Index> made = join();
  ASSERT_EQ(made.size(), 2u);
  EXPECT_TRUE(mesh.is_consistent());
  testing::expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(faces_that_stay_at(vertex_at(pole)), 1);
  EXPECT_GE(faces_that_stay_at(vertex_at(beside)), 1);
  std::vector<Triangle> expected = before;
  for (const Index f : made) {
    expected.push_back(ascending_corners(mesh, f));
    EXPECT_LT(expected.back()[2], samples) << "a corner that is no sample";
    Index at_border = 0;
    for (Index h = 3 * f; h < 3 * f + 3; ++h)
      at_border += !is_dropped[SurfaceMesh::face(mesh.twin(h))];
    EXPECT_GE(at_border, 1) << "not joined to what stays";
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(faces_that_stay(), expected) << "another face has changed";
}

TEST_F(IsolatedSamples, AreJoinedToTheSameEdgesAgain) {
  number_samples(0.7, {nearest_to(Vec3::UnitZ()), nearest_to(Vec3(0.3, 0.1, 0.95)),
                       nearest_to(Vec3(-0.5, 0.2, 0.82))});
  const std::vector<Index> made = join();
  ASSERT_EQ(made.size(), 3u);
  const std::vector<Triangle> stay = faces_that_stay(), all = mesh.triangles();
  for (const Index f : made) is_dropped[f] = 1;
  EXPECT_EQ(join(), made);
  EXPECT_EQ(faces_that_stay(), stay);
  EXPECT_EQ(mesh.triangles(), all);
}

// As far as borders are looked for, also among the last faces that are.
TEST_F(IsolatedSamples, FarFromTheBorderGetAFaceUnlessItIsTooFar) {
  const SurfaceMesh sphere = icosphere(5);
  for (const double height : {-0.81, -0.825, -0.835, -0.9}) {
    mesh = sphere;
    number_samples(height, {nearest_to(Vec3(0.1, 0.05, 1.0))});
    EXPECT_EQ(join().size(), height > -0.83 ? 1u : 0u) << height;
  }
}

TEST_F(IsolatedSamples, OthersHaveTheirFacesAlready) {
  number_samples(0.7, {});
  const std::vector<Triangle> before = mesh.triangles();
  EXPECT_TRUE(join().empty());
  EXPECT_EQ(mesh.triangles(), before);
}

TEST_F(IsolatedSamples, StayWithoutABorder) {
  number_samples(-2.0, {nearest_to(Vec3::UnitZ())});
  ASSERT_EQ(samples, 1);
  const std::vector<Triangle> before = mesh.triangles();
  EXPECT_TRUE(join().empty());
  EXPECT_EQ(mesh.triangles(), before);
  EXPECT_EQ(std::count(is_dropped.begin(), is_dropped.end(), 0), 0);
}

// Far from the border too: those near it come first, and bring it nearer to the others, whatever
// their numbers.
TEST_F(IsolatedSamples, AreAllJoinedAcrossAWideOpening) {
  mesh = icosphere(6);
  std::vector<Vec3> places;
  for (Index v = 0; v < mesh.vertex_slots(); v += 97)
    if (mesh.position[v].z() > -0.85) places.push_back(mesh.position[v]);
  std::sort(places.begin(), places.end(),
            [](const Vec3& a, const Vec3& b) { return a.z() > b.z(); });
  number_samples(-0.9, places);
  EXPECT_EQ(join().size(), places.size());
  EXPECT_TRUE(mesh.is_consistent());
  for (const Vec3& place : places) EXPECT_GT(faces_that_stay_at(vertex_at(place)), 0);
  std::vector<Index> made;
  Index components = 0;
  std::vector<char> is_seen = is_dropped;
  for (Index seed = 0; seed < mesh.face_slots(); ++seed) {
    if (is_seen[seed]) continue;
    ++components;
    is_seen[seed] = 1;
    made.assign(1, seed);
    for (std::size_t i = 0; i < made.size(); ++i)
      for (Index h = 3 * made[i]; h < 3 * made[i] + 3; ++h) {
        const Index f = SurfaceMesh::face(mesh.twin(h));
        if (!is_seen[f]) made.push_back(f);
        is_seen[f] = 1;
      }
  }
  EXPECT_EQ(components, 1);
  std::vector<Triangle> stay;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (!is_dropped[f]) stay.push_back(mesh.triangle(f));
  Progress silent;
  EXPECT_TRUE(self_intersecting_faces(mesh.position, stay, silent).empty());
}

TEST_F(IsolatedSamples, AreNotJoinedToWhatIsNoSample) {
  number_samples(0.6, {nearest_to(Vec3::UnitZ())});
  open_above(0.7);
  EXPECT_TRUE(join().empty());
}

// A ring of faces in the plane z = 0 around a hole, which a fan around a sample closes; below them
// one vertex more.
class SampleInAHole : public IsolatedSamples {
 protected:
  static constexpr Index kCorners = 12;

  explicit SampleInAHole(const Vec3& sample = Vec3::Zero()) {
    std::vector<Vec3> position;
    for (const double radius : {1.0, 2.0})
      for (Index i = 0; i < kCorners; ++i) {
        const double angle = 2.0 * kPi * (i + 0.5) / kCorners;
        position.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
      }
    position.push_back(sample);
    position.emplace_back(0.0, 0.0, -2.0);
    std::vector<Triangle> triangles;
    for (Index i = 0; i < kCorners; ++i) {
      const Index a = i, b = (i + 1) % kCorners, c = kCorners + a, d = kCorners + b;
      triangles.push_back({2 * kCorners, a, b});
      triangles.push_back({a, c, b});
      triangles.push_back({b, c, d});
      triangles.push_back({c, 2 * kCorners + 1, d});
    }
    mesh = SurfaceMesh::from_triangles(std::move(position), triangles);
    samples = mesh.vertex_slots();
    is_dropped.assign(static_cast<std::size_t>(mesh.face_slots()), 0);
    for (Index i = 0; i < kCorners; ++i) is_dropped[4 * i] = 1;
  }
  // The middle of the edge of the border that the sample is joined to.
  Vec3 edge_joined() {
    const std::vector<Index> made = join();
    EXPECT_EQ(made.size(), 1u);
    Vec3 sum = Vec3::Zero();
    if (made.empty()) return sum;
    for (const Index v : mesh.triangle(made.front()))
      if (v != 2 * kCorners) sum += mesh.position[v];
    return 0.5 * sum;
  }
};

TEST_F(SampleInAHole, IsJoinedToTheNearestEdge) {
  mesh.position[2 * kCorners] = Vec3(0.0, -0.5, 0.1);
  EXPECT_LT(edge_joined().y(), -0.9);
}

// Above a face beyond the nearest edge: a face there would lie back on it.
TEST_F(SampleInAHole, IsJoinedToAnEdgeThatItLiesBefore) {
  mesh.position[2 * kCorners] = Vec3(1.2, 0.0, 0.05);
  EXPECT_LT(edge_joined().x(), 0.9);
}

// From beyond the vertex below.
TEST_F(SampleInAHole, IsNotJoinedThroughFacesThatStay) {
  mesh.position[2 * kCorners].z() = -3.0;
  EXPECT_TRUE(join().empty());
  EXPECT_EQ(faces_that_stay_at(2 * kCorners), 0);
}

// Where the sample has an edge to both ends of that of the border, and a vertex between.
TEST_F(SampleInAHole, IsJoinedToAnotherEdgeWhereNoFlipsReachTheNearest) {
  mesh.position[2 * kCorners].z() = 0.5;
  const Index between = mesh.split_face(0, Vec3(0.9, 0.25, 0.0));
  // One face stays, that beyond the edge from corner 0 to corner 1; its corners and the sample are
  // numbered first.
  std::vector<Index> new_index(mesh.position.size(), kNone);
  samples = 0;
  for (const Index v : {Index{0}, Index{1}, kCorners, 2 * kCorners}) new_index[v] = samples++;
  Index next = samples;
  for (Index& index : new_index)
    if (index == kNone) index = next++;
  mesh.renumber(new_index);
  is_dropped.assign(static_cast<std::size_t>(mesh.face_slots()), 1);
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (ascending_corners(mesh, f) == Triangle{0, 1, 2}) is_dropped[f] = 0;
  ASSERT_NE(mesh.find_halfedge(3, new_index[between]), kNone);

  ASSERT_EQ(join().size(), 1u);
  EXPECT_TRUE(mesh.is_consistent());
  testing::expect_closed_manifold(mesh, 1, 0);
  const std::vector<Triangle> stay = faces_that_stay();
  ASSERT_EQ(stay.size(), 2u);
  EXPECT_EQ(stay[1][1], 2) << "not one of the other two edges of the face";
  EXPECT_EQ(stay[1][2], 3);
}

}  // namespace
}  // namespace shrinkwrap
