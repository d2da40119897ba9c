// Notches in the border of an opening: filled where the surface goes on across them, and nowhere
// else.
#include "border_notches.h"

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

Index fill(SurfaceMesh& mesh, double local_spacing) {
  PointCloud cloud;
  cloud.local_spacing.assign(kCorners + 1, static_cast<float>(local_spacing));
  Progress silent;
  return fill_border_notches(mesh, cloud, kCorners + 1, silent);
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

}  // namespace
}  // namespace shrinkwrap
