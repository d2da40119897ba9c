// Notches in the border of an opening: filled where the surface goes on across them, and nowhere
// else.
#include "complete_matching/border_notches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"

namespace shrinkwrap {
namespace {

constexpr Index kCorners = 12;
constexpr double kPi = 3.14159265358979323846;

// A star of samples in the plane z = 0: its centre, then its outline, whose odd corners lie at
// `inner_radius` and whose even ones are lifted. Below it one vertex that is no sample, as the
// membrane.
SurfaceMesh star(double inner_radius, double lift) {
  std::vector<Vec3> position = {Vec3::Zero()};
  std::vector<Triangle> triangles;
  const Index membrane = kCorners + 1;
  for (Index i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners, radius = i % 2 ? inner_radius : 1.0;
    position.push_back({radius * std::cos(angle), radius * std::sin(angle), i % 2 ? 0.0 : lift});
    const Index corner = 1 + i, next = 1 + (i + 1) % kCorners;
    triangles.push_back({0, corner, next});
    triangles.push_back({membrane, next, corner});
  }
  position.push_back({0.0, 0.0, -1.0});
  return SurfaceMesh::from_triangles(std::move(position), triangles);
}

Index fill(SurfaceMesh& mesh, double local_spacing, Index samples, Progress& progress) {
  PointCloud cloud;
  cloud.position.assign(mesh.position.begin(), mesh.position.begin() + samples);
  cloud.local_spacing.assign(static_cast<std::size_t>(samples), static_cast<float>(local_spacing));
  std::vector<char> is_dropped(static_cast<std::size_t>(mesh.face_slots()), 0);
  const auto is_membrane = [&](Index f) {
    const Triangle t = mesh.triangle(f);
    return std::max({t[0], t[1], t[2]}) >= samples;
  };
  for (Index f = 0; f < mesh.face_slots(); ++f) is_dropped[f] = is_membrane(f);
  const Index filled = fill_border_notches(mesh, cloud, is_dropped, progress);
  for (Index f = 0; f < mesh.face_slots(); ++f)
    EXPECT_EQ(is_dropped[f] != 0, is_membrane(f)) << "face " << f;
  return filled;
}

Index fill(SurfaceMesh& mesh, double local_spacing) {
  Progress silent;
  return fill(mesh, local_spacing, kCorners + 1, silent);
}

TEST(BorderNotches, AreFilled) {
  SurfaceMesh mesh = star(0.7, 0.0);
  EXPECT_EQ(fill(mesh, 0.5), kCorners / 2);
  testing::expect_closed_manifold(mesh, 1, 0);
  for (Index v = 1; v <= kCorners; ++v)
    EXPECT_EQ(mesh.find_halfedge(v, kCorners + 1) == kNone, v % 2 == 0) << v;
  // The outline is the hexagon of the outer corners, all faces of samples lie in the plane.
  double area = 0.0;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    const Triangle t = mesh.triangle(f);
    if (std::max({t[0], t[1], t[2]}) <= kCorners) area += 0.5 * mesh.area_vector(f).z();
  }
  EXPECT_NEAR(area, 1.5 * std::sqrt(3.0), 1e-9);
}

TEST(BorderNotches, AreNotSeenInAConvexBorder) {
  SurfaceMesh mesh = star(1.0, 0.0);
  const std::vector<Triangle> before = mesh.triangles();
  EXPECT_EQ(fill(mesh, 0.5), 0);
  EXPECT_EQ(mesh.triangles(), before);
}

TEST(BorderNotches, AreLeftWhereAFaceWouldBeLong) {
  SurfaceMesh mesh = star(0.7, 0.0);  // the outer corners are 1 apart
  EXPECT_EQ(fill(mesh, 0.2), 0);
  EXPECT_EQ(fill(mesh, 0.3), kCorners / 2);
}

TEST(BorderNotches, AreLeftWhereTheSurfaceTurns) {
  SurfaceMesh mesh = star(0.3, 3.0);  // a crown: what would fill a notch stands across
  EXPECT_EQ(fill(mesh, 4.0), 0);
}

// A round hole, all around which the surface goes on: a ring of samples about it, closed from
// below. `dent`: part by which its first corner lies nearer to the middle.
SurfaceMesh plate_with_hole(Index corners, double dent, Index& samples) {
  std::vector<Vec3> position;
  std::vector<Triangle> triangles;
  for (const double radius : {1.0, 2.0})
    for (Index i = 0; i < corners; ++i) {
      const double angle = 2.0 * kPi * i / corners;
      position.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
    }
  position[0] *= 1.0 + dent;
  const Index below = static_cast<Index>(position.size()), membrane = below + 1;
  position.push_back({0.0, 0.0, -3.0});
  position.push_back({0.0, 0.0, -0.5});
  samples = membrane;
  for (Index i = 0; i < corners; ++i) {
    const Index j = (i + 1) % corners;
    triangles.push_back({i, corners + i, corners + j});
    triangles.push_back({i, corners + j, j});
    triangles.push_back({below, corners + j, corners + i});
    triangles.push_back({membrane, i, j});
  }
  return SurfaceMesh::from_triangles(std::move(position), triangles);
}

TEST(BorderNotches, OfARoundHoleAreNone) {
  for (const Index corners : {4, 5, 6, 8, 10, 13, 20}) {
    SCOPED_TRACE(corners);
    Index samples = 0;
    SurfaceMesh mesh = plate_with_hole(corners, 0.0, samples);
    const std::vector<Triangle> before = mesh.triangles();
    Progress silent;
    EXPECT_EQ(fill(mesh, 10.0, samples, silent), 0);
    EXPECT_EQ(mesh.triangles(), before);
  }
}

TEST(BorderNotches, OfAHoleThatIsNotRoundAreFilled) {
  Index samples = 0;
  SurfaceMesh mesh = plate_with_hole(10, 0.4, samples);
  Progress silent;
  EXPECT_EQ(fill(mesh, 10.0, samples, silent), 1);
  EXPECT_EQ(mesh.find_halfedge(0, samples), kNone);
  testing::expect_closed_manifold(mesh, 1, 0);
}

TEST(BorderNotches, ThatCannotBeFilledChangeNothing) {
  // A notch at sample 0 between samples 1 and 2 that are joined on the far side too: the first of
  // the two flips is possible, the second is not.
  SurfaceMesh mesh = SurfaceMesh::from_triangles(
      {Vec3(0, 0, 0), Vec3(1, -0.3, 0), Vec3(1, 0.3, 0), Vec3(-1, 0, 0), Vec3(2, 0, -1),
       Vec3(1.2, -0.1, 0), Vec3(1.2, 0.1, 0)},
      {Triangle{0, 1, 5}, Triangle{0, 5, 6}, Triangle{0, 6, 2}, Triangle{0, 2, 3},
       Triangle{0, 3, 1}, Triangle{1, 3, 2}, Triangle{1, 2, 4}, Triangle{4, 2, 6},
       Triangle{4, 6, 5}, Triangle{4, 5, 1}});
  const std::vector<Triangle> before = mesh.triangles();
  Progress silent;
  EXPECT_EQ(fill(mesh, 10.0, 5, silent), 0);
  EXPECT_EQ(mesh.triangles(), before);
  EXPECT_TRUE(mesh.is_consistent());
}

TEST(BorderNotches, FillingCanBeCancelled) {
  SurfaceMesh mesh = star(0.7, 0.0);
  Progress progress([](double, const char*) { return false; }, {Stage::complete_matching});
  EXPECT_THROW(fill(mesh, 0.5, kCorners + 1, progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
