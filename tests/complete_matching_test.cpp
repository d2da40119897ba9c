// Complete matching by re-tiling: every sample a vertex, every vertex a sample, on a mesh that
// stays a closed 2-manifold whatever the samples.
#include "complete_matching.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include "close_openings.h"
#include "expect_mesh.h"
#include "openings.h"
#include "oriented_cloud.h"
#include "self_intersection.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::expect_closed_manifold;
using testing::expect_complete_matching;
using testing::expect_same_mesh;
using testing::oriented_cloud;
using testing::Random;
using testing::ShapeKind;
using Openings = CompleteMatchingOptions::Openings;

// The mesh in the frame of the cloud, in canonical order: as the stage before would hand it over.
SurfaceMesh surface_for(const PointCloud& cloud, SurfaceMesh mesh) {
  for (Vec3& p : mesh.position) p = cloud.frame.to_unit(p);
  mesh.compact();
  return mesh;
}

// The radial projection of an icosphere onto a shape that its centre sees all of.
SurfaceMesh star_shaped(ShapeKind kind, int subdivisions) {
  const testing::Shape shape = testing::shape_of(kind);
  SurfaceMesh mesh = testing::icosphere(subdivisions);
  for (Vec3& p : mesh.position) {
    double inside = 0.0, outside = 2.0;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (inside + outside);
      (shape.implicit(middle * p) < 0.0 ? inside : outside) = middle;
    }
    p *= inside;
  }
  return mesh;
}

CompleteMatching match(const PointCloud& cloud, const SurfaceMesh& surface,
                       const CompleteMatchingOptions& options = {}) {
  Progress silent;
  return match_samples(surface_for(cloud, surface), cloud, options, silent);
}

Index self_intersecting_faces(const SurfaceMesh& mesh) {
  Progress silent;
  return static_cast<Index>(
      intersecting_faces(self_intersections(mesh.position, mesh.triangles(), silent)).size());
}

struct Case {
  const char* name;
  ShapeKind kind;
  Index samples;
  int subdivisions;  // of the surface: from a hundredth to four times the vertices
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Retiling : public ::testing::TestWithParam<Case> {};

TEST_P(Retiling, MakesEverySampleAVertex) {
  const auto [name, kind, samples, subdivisions] = GetParam();
  const testing::Shape shape = testing::shape_of(kind);
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE(seed);
    const PointCloud cloud = oriented_cloud(testing::sample_shape(kind, samples, seed));
    const SurfaceMesh surface = kind == ShapeKind::torus
                                    ? testing::torus_mesh(12 << subdivisions, 4 << subdivisions)
                                    : star_shaped(kind, subdivisions);
    const CompleteMatching matching = match(cloud, surface);
    expect_closed_manifold(matching.mesh, shape.components, shape.genus);
    expect_complete_matching(matching, cloud);
    EXPECT_EQ(matching.report.extra_vertices, 0);
    EXPECT_EQ(matching.report.membranes, 0);
    EXPECT_EQ(matching.mesh.vertex_count(), cloud.size());
    EXPECT_GT(signed_volume(matching.mesh), 0.0);
    for (Index i = 0; i < cloud.size(); ++i) ASSERT_EQ(matching.sample_of_vertex[i], to_sample(i));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Retiling,
                         ::testing::Values(Case{"sphere", ShapeKind::sphere, 3000, 4},
                                           Case{"sphere_in_few_faces", ShapeKind::sphere, 3000, 1},
                                           Case{"sphere_in_many_faces", ShapeKind::sphere, 600, 4},
                                           Case{"four_samples", ShapeKind::sphere, 4, 2},
                                           Case{"torus", ShapeKind::torus, 3000, 3},
                                           Case{"torus_in_few_faces", ShapeKind::torus, 3000, 1},
                                           Case{"box", ShapeKind::box, 3000, 4},
                                           Case{"blob", ShapeKind::blob, 3000, 4}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(Retiling, FollowsTheShape) {
  const PointCloud cloud =
      oriented_cloud(testing::sample_shape_blue_noise(ShapeKind::blob, 4000, 3));
  const CompleteMatching matching = match(cloud, star_shaped(ShapeKind::blob, 5));
  EXPECT_EQ(self_intersecting_faces(matching.mesh), 0);
  EXPECT_EQ(matching.report.forced_removals, 0);
  EXPECT_LT(matching.report.max_foot_distance, 0.5);
  EXPECT_GT(
      testing::normal_consistency(matching.mesh, testing::shape_of(ShapeKind::blob), cloud.frame),
      0.99);
}

TEST(Retiling, TellsTheSidesOfAThinPlateApart) {
  // The samples of either side are nearer to the other side of a surface that lies a little off.
  const testing::Shape plate = testing::shape_of(ShapeKind::thin_plate);
  const PointCloud cloud = oriented_cloud(testing::sample_shape_blue_noise(plate.kind, 6000, 4));
  SurfaceMesh surface = star_shaped(ShapeKind::box, 5);
  const SurfaceMesh target = star_shaped(plate.kind, 5);
  surface.position = target.position;
  for (Vec3& p : surface.position)
    p += 0.05 * plate.normal(p).cwiseAbs().maxCoeff() * Vec3(0, 0, 1);
  const CompleteMatching matching = match(cloud, surface);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);
  EXPECT_GT(testing::normal_consistency(matching.mesh, plate, cloud.frame), 0.8);
}

TEST(Retiling, SurvivesFeetThatCoincide) {
  // Samples beyond a corner of a tetrahedron: the foot of most of them is the corner itself.
  Random random(5);
  std::vector<Vec3> points = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0), Vec3(0, 0, 4)};
  for (int i = 0; i < 1500; ++i) points.push_back(Vec3(0, 0, 5) + 0.5 * random.in_cube());
  const PointCloud cloud = oriented_cloud(points);
  const SurfaceMesh tetrahedron = SurfaceMesh::from_triangles(
      {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0), Vec3(0, 0, 4)},
      {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{1, 2, 3}, Triangle{0, 3, 2}});
  const CompleteMatching matching = match(cloud, tetrahedron);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);
}

TEST(Retiling, SurvivesSamplesAtCornersAndOnEdges) {
  const SurfaceMesh surface = testing::icosphere(3);
  std::vector<Vec3> points = surface.position;
  for (Index h = 0; h < surface.halfedge_slots(); ++h)
    if (h < surface.twin(h) && h % 2 == 0)
      points.push_back(0.5 *
                       (surface.position[surface.origin(h)] + surface.position[surface.target(h)]));
  const PointCloud cloud = oriented_cloud(points);
  const CompleteMatching matching = match(cloud, surface);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);
  EXPECT_EQ(matching.report.extra_vertices, 0);
}

TEST(Retiling, SurvivesUnevenDensity) {
  Random random(6);
  std::vector<Vec3> points = testing::sample_shape(ShapeKind::sphere, 300, 6);
  for (int i = 0; i < 4000; ++i)  // a scan line and a spot
    points.push_back(Vec3(1, 0.001 * i, 0.3).normalized());
  for (int i = 0; i < 4000; ++i)
    points.push_back((Vec3(0, 0, 1) + 0.02 * random.in_cube()).normalized());
  const PointCloud cloud = oriented_cloud(points);
  CompleteMatchingOptions options;
  options.membrane_low = options.membrane_high = 1e9;  // spacing says nothing here
  const CompleteMatching matching = match(cloud, testing::icosphere(2), options);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);
  EXPECT_EQ(matching.report.extra_vertices, 0);
}

TEST(Retiling, SurvivesADegenerateSurface) {
  const PointCloud cloud = oriented_cloud(testing::sample_shape(ShapeKind::sphere, 500, 7));
  SurfaceMesh surface = testing::icosphere(2);
  Random random(7);
  for (int i = 0; i < 60; ++i)
    surface.position[random.below(surface.vertex_slots())] =
        surface.position[random.below(surface.vertex_slots())];
  CompleteMatching matching = match(cloud, surface);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);

  for (Vec3& p : surface.position) p = Vec3(0.1, 0.2, 0.3);  // a point
  CompleteMatchingOptions options;
  options.membrane_low = options.membrane_high = 1e9;
  matching = match(cloud, surface, options);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud);
}

TEST(Retiling, KeepsVerticesWithoutWhichThereIsNoManifold) {
  // Two spheres; a few samples on the second, or none. Fewer than four cannot make a closed mesh.
  for (const Index others : {0, 1, 2, 3, 4, 5}) {
    SCOPED_TRACE(others);
    std::vector<Vec3> points = testing::sample_shape(ShapeKind::sphere, 500, 8);
    const std::vector<Vec3> second = testing::sample_shape(ShapeKind::sphere, 50, 9);
    for (Index i = 0; i < others; ++i) points.push_back(second[i] + Vec3(5, 0, 0));
    const PointCloud cloud = oriented_cloud(points);
    SurfaceMesh one = testing::icosphere(2);
    std::vector<Vec3> positions = one.position;
    std::vector<Triangle> triangles = one.triangles();
    for (const Vec3& p : one.position) positions.push_back(p + Vec3(5, 0, 0));
    for (Triangle t : one.triangles()) {
      for (Index& v : t) v += one.vertex_slots();
      triangles.push_back(t);
    }
    CompleteMatchingOptions options;
    options.membrane_low = options.membrane_high = 1e9;
    const CompleteMatching matching =
        match(cloud, SurfaceMesh::from_triangles(positions, triangles), options);
    expect_closed_manifold(matching.mesh, others == 0 ? 1 : 2, 0);
    expect_complete_matching(matching, cloud);
    EXPECT_EQ(matching.report.extra_vertices, others == 0 ? 0 : std::max(0, 4 - others));
  }
}

TEST(Retiling, DoesNotDependOnThreads) {
  const PointCloud cloud = oriented_cloud(testing::sample_shape(ShapeKind::blob, 20000, 10));
  const SurfaceMesh surface = star_shaped(ShapeKind::blob, 5);
  CompleteMatching one, two;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = match(cloud, surface);
  }
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
    two = match(cloud, surface);
  }
  expect_same_mesh(one.mesh, two.mesh);
  expect_complete_matching(one, cloud);
}

TEST(Retiling, CanBeCancelled) {
  const PointCloud cloud = oriented_cloud(testing::sample_shape(ShapeKind::sphere, 2000, 11));
  Progress cancelled([](double, const char*) { return false; }, {Stage::complete_matching});
  EXPECT_THROW(match_samples(surface_for(cloud, testing::icosphere(4)), cloud, {}, cancelled),
               Cancelled);
}

TEST(Retiling, RefusesASurfaceWithoutFaces) {
  const PointCloud cloud = oriented_cloud(testing::sample_shape(ShapeKind::sphere, 100, 12));
  Progress silent;
  EXPECT_THROW(match_samples(SurfaceMesh(), cloud, {}, silent), InvalidInput);
}

// Half a sphere of samples, and the whole sphere as the surface.
class Hemisphere : public ::testing::Test {
 protected:
  CompleteMatching match_with(Openings openings) {
    CompleteMatchingOptions options;
    options.openings = openings;
    return match(cloud_, testing::icosphere(4), options);
  }
  PointCloud cloud_ =
      oriented_cloud(testing::sample_shape_blue_noise(ShapeKind::hemisphere, 1500, 13));
};

TEST_F(Hemisphere, IsClosedByItsSamplesAlone) {
  const CompleteMatching matching = match_with(Openings::close);
  expect_closed_manifold(matching.mesh, 1, 0);
  expect_complete_matching(matching, cloud_);
  EXPECT_EQ(matching.report.membranes, 1);
  EXPECT_EQ(matching.report.extra_vertices, 0);
  EXPECT_TRUE(matching.opening_faces.empty());
  EXPECT_FALSE(matching.spanning_faces.empty());
  EXPECT_EQ(self_intersecting_faces(matching.mesh), 0);
}

TEST_F(Hemisphere, IsLeftOpenWithACleanBorder) {
  const CompleteMatching matching = match_with(Openings::leave_open);
  expect_closed_manifold(matching.mesh, 1, 0);
  EXPECT_FALSE(matching.opening_faces.empty());
  EXPECT_TRUE(std::is_sorted(matching.opening_faces.begin(), matching.opening_faces.end()));
  std::vector<char> is_dropped(static_cast<std::size_t>(matching.mesh.face_slots()), 0);
  for (const Index f : matching.opening_faces) is_dropped[f] = 1;
  std::vector<Index> faces(static_cast<std::size_t>(cloud_.size()), 0);
  Index border = 0, extra = 0;
  for (Index h = 0; h < matching.mesh.halfedge_slots(); ++h) {
    if (is_dropped[SurfaceMesh::face(h)]) continue;
    border += is_dropped[SurfaceMesh::face(matching.mesh.twin(h))];
    const Index v = matching.mesh.origin(h);
    if (matching.sample_of_vertex[v] == SampleId::none)
      ++extra;
    else
      ++faces[to_index(matching.sample_of_vertex[v])];
  }
  EXPECT_EQ(std::count(faces.begin(), faces.end(), 0), 0) << "samples without a face";
  EXPECT_GT(border, 30);
  EXPECT_EQ(extra, 0);
  EXPECT_EQ(matching.report.extra_vertices, 0);
}

TEST_F(Hemisphere, HasABorderWithoutNotchesWhereSamplesAreIrregular) {
  for (const unsigned seed : {14u, 15u, 16u}) {
    SCOPED_TRACE(seed);
    cloud_ = oriented_cloud(testing::sample_shape(ShapeKind::hemisphere, 1500, seed));
    const CompleteMatching matching = match_with(Openings::leave_open);
    const std::vector<Index>& dropped = matching.opening_faces;
    double length = 0.0;
    for (const Index f : dropped)
      for (Index h = 3 * f; h < 3 * f + 3; ++h)
        if (!std::binary_search(dropped.begin(), dropped.end(),
                                SurfaceMesh::face(matching.mesh.twin(h))))
          length += (matching.mesh.position[matching.mesh.target(h)] -
                     matching.mesh.position[matching.mesh.origin(h)])
                        .norm();
    // The rim is a circle of radius 1, and the samples lie at some distance from it.
    EXPECT_LT(cloud_.frame.to_input_length(length), 6.42);
  }
}

// A lens, its back two spacings below the samples, all of which are on the front.
class Sheet : public ::testing::Test {
 protected:
  static constexpr double kFlatness = 0.05;
  static std::vector<Vec3> front() {
    std::vector<Vec3> points;
    for (const Vec3& p : testing::sample_shape_blue_noise(ShapeKind::hemisphere, 1500, 17))
      if (p.z() > 0.0) points.push_back({p.x(), p.y(), kFlatness * p.z()});
    return points;
  }
  CompleteMatching match_with(Openings openings, bool backs_are_openings = true) {
    SurfaceMesh lens = testing::icosphere(4);
    for (Vec3& p : lens.position) p.z() *= kFlatness;
    CompleteMatchingOptions options;
    options.openings = openings;
    options.backs_are_openings = backs_are_openings;
    return match(cloud_, lens, options);
  }
  PointCloud cloud_ = oriented_cloud(front());
};

TEST_F(Sheet, HasABackThatNoSampleHoldsHoweverNear) {
  ASSERT_GT(cloud_.normal[0].z(), 0.0f);
  const CompleteMatching both = match_with(Openings::close, false);
  EXPECT_EQ(both.report.membranes, 0);
  EXPECT_GT(both.report.backs, 500);
  EXPECT_TRUE(both.spanning_faces.empty());
  // Along the surface it is an opening, which is left open.
  const CompleteMatching along = match_with(Openings::leave_open, false);
  EXPECT_EQ(along.report.membranes, 1);
  EXPECT_LT(along.report.backs, both.report.backs / 4);
  EXPECT_GT(along.opening_faces.size(), 100u);
  const CompleteMatching open = match_with(Openings::leave_open);
  EXPECT_EQ(open.report.membranes, 1);
  EXPECT_EQ(open.report.backs, 0);
  EXPECT_LE(along.report.extra_vertices, open.report.extra_vertices);
  EXPECT_GT(open.opening_faces.size(), 100u);
  Index front = 0, back = 0;  // at the rim the surface turns
  for (Index f = 0; f < open.mesh.face_slots(); ++f)
    if (!std::binary_search(open.opening_faces.begin(), open.opening_faces.end(), f))
      ++(open.mesh.area_vector(f).z() > 0.0 ? front : back);
  EXPECT_GT(front, cloud_.size());
  EXPECT_LT(back, front / 20);
  const CompleteMatching closed = match_with(Openings::close);
  EXPECT_EQ(closed.report.membranes, 1);
  expect_closed_manifold(closed.mesh, 1, 0);
  EXPECT_EQ(self_intersecting_faces(closed.mesh), 0);
}

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
      // Some extra vertices had to stay, lest a sample be lost. Where samples are no islands, these
      // go to their neighbours.
      const auto extra = [&] {
        return extra_vertices_kept(matching.mesh, first_extra, matching.opening_faces);
      };
      const Index before = extra();
      if (part > 0.2) {
        EXPECT_GT(before, 0);
      }
      matching.sample_of_vertex.assign(matching.mesh.position.size(), SampleId::none);
      close_openings(matching, first_extra, silent);
      EXPECT_LE(extra(), part < 0.2 ? 0 : before / 2);
      expect_simple_borders(matching, first_extra);
      expect_closed_manifold(matching.mesh, 1, 0);
      std::vector<Triangle> kept;
      for (Index f = 0; f < matching.mesh.face_slots(); ++f)
        if (!std::binary_search(matching.opening_faces.begin(), matching.opening_faces.end(), f))
          kept.push_back(matching.mesh.triangle(f));
      EXPECT_EQ(self_intersecting_faces(matching.mesh.position, kept, silent).size(), 0u);
    }
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
      EXPECT_EQ(self_intersecting_faces(mesh), 0);
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
  ASSERT_EQ(self_intersecting_faces(mesh), 0);
  Progress silent;
  close_openings(mesh, rim + 1, silent);
  EXPECT_EQ(mesh.vertex_count(), rim + 1);
  mesh.compact();
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(self_intersecting_faces(mesh), 0);
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
  const Index removed = close_openings(matching, first_extra, silent);
  EXPECT_GT(removed, 0);
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
  EXPECT_EQ(self_intersecting_faces(mesh), 0);

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
    EXPECT_EQ(self_intersecting_faces(mesh), most_cuts >= 3 ? 4 : 0);
  }
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
  EXPECT_EQ(self_intersecting_faces(mesh), 0);
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
