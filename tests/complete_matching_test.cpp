// Complete matching by re-tiling: every sample a vertex, every vertex a sample, on a mesh that
// stays a closed 2-manifold whatever the samples.
#include "complete_matching/complete_matching.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_meeting_faces;
using testing::expect_closed_manifold;
using testing::expect_complete_matching;
using testing::expect_same_mesh;
using testing::oriented_cloud;
using testing::Random;
using testing::ShapeKind;
using testing::signed_volume;
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
  EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
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
    const SurfaceMesh one = testing::icosphere(2);
    CompleteMatchingOptions options;
    options.membrane_low = options.membrane_high = 1e9;
    const CompleteMatching matching =
        match(cloud, testing::joined({one, testing::placed(one, 1.0, Vec3(5, 0, 0))}), options);
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
  EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
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
  EXPECT_EQ(along.report.extra_vertices, 0);
  EXPECT_EQ(open.report.extra_vertices, 0);
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
  EXPECT_EQ(count_meeting_faces(closed.mesh), 0);
}

}  // namespace
}  // namespace shrinkwrap
