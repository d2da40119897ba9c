#include "parametric_surface/control_mesh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

ControlMesh simplify(const SurfaceMesh& mesh, Index target, bool area_weighted = true) {
  ControlMeshOptions options;
  options.target_vertices = target;
  options.area_weighted = area_weighted;
  Progress silent;
  return make_control_mesh(mesh, 0, options, silent);
}

// Greatest distance of vertices from the unit cube's surface.
double distance_from_cube(const SurfaceMesh& mesh) {
  double greatest = 0.0;
  for (const Vec3& p : mesh.position)
    greatest = std::max(greatest, std::abs(p.cwiseAbs().maxCoeff() - 1.0));
  return greatest;
}

// The sphere pushed out onto the cube [-1, 1]^3: sharp edges amid many faces.
SurfaceMesh cube_mesh(int subdivisions) {
  SurfaceMesh mesh = icosphere(subdivisions);
  for (Vec3& p : mesh.position) p /= p.cwiseAbs().maxCoeff();
  return mesh;
}

TEST(ControlVertices, AreThoseOfTheTables) {
  EXPECT_EQ(control_vertices_for(12321, 2, 1), 772);
  EXPECT_EQ(control_vertices_for(34267, 2, 1), 2144);
  EXPECT_EQ(control_vertices_for(34267, -6, 1), 2136) << "genus 4";
  EXPECT_EQ(control_vertices_for(4, 2, 1), 4);
  EXPECT_GE(control_vertices_for(40, 20, 10), 40) << "4 for each component";
}

TEST(ControlMesh, ReachesTheTargetAndKeepsTheTopology) {
  for (const bool area_weighted : {true, false}) {
    const ControlMesh sphere = simplify(icosphere(4), 100, area_weighted);
    expect_closed_manifold(sphere.mesh, 1, 0);
    EXPECT_EQ(sphere.mesh.vertex_count(), 100);
    EXPECT_EQ(sphere.report.vertices, 100);
    EXPECT_EQ(sphere.report.vertices_before, 2562);
    for (const Vec3& p : sphere.mesh.position) EXPECT_NEAR(p.norm(), 1.0, 0.06);

    const ControlMesh torus = simplify(torus_mesh(60, 30), 120, area_weighted);
    expect_closed_manifold(torus.mesh, 1, 1);
    EXPECT_EQ(torus.mesh.vertex_count(), 120);
    const Shape shape = shape_of(ShapeKind::torus);
    for (const Vec3& p : torus.mesh.position) EXPECT_NEAR(shape.implicit(p), 0.0, 0.05);
  }
}

TEST(ControlMesh, PutsItsVerticesOnSharpEdges) {
  const SurfaceMesh cube = cube_mesh(6);
  const ControlMesh control = simplify(cube, 60);
  expect_closed_manifold(control.mesh, 1, 0);
  EXPECT_LT(distance_from_cube(control.mesh), 0.02);
  Index at_corners = 0;
  for (const Vec3& p : control.mesh.position) at_corners += p.cwiseAbs().minCoeff() > 0.9;
  EXPECT_GE(at_corners, 8);
}

TEST(ControlMesh, FlatPartsCostNothing) {
  // Where every contraction costs zero, thin or turned faces must not come of it.
  const ControlMesh control = simplify(cube_mesh(5), 200);
  expect_closed_manifold(control.mesh, 1, 0);
  EXPECT_GT(signed_volume(control.mesh), 7.6);
  EXPECT_LT(signed_volume(control.mesh), 8.4);
}

TEST(ControlMesh, LeavesASmallMeshAlone) {
  const SurfaceMesh mesh = icosphere(2);
  expect_same_mesh(simplify(mesh, mesh.vertex_count()).mesh, mesh);
  expect_same_mesh(simplify(mesh, 5000).mesh, mesh);
}

TEST(ControlMesh, StopsWhereNoLegalContractionIsLeft) {
  const ControlMesh torus = simplify(torus_mesh(20, 10), 4);
  expect_closed_manifold(torus.mesh, 1, 1);
  EXPECT_GE(torus.report.vertices, 7) << "no triangulated torus has fewer";
  EXPECT_EQ(torus.report.vertices, torus.mesh.vertex_count());
}

TEST(ControlMesh, CoincidentVerticesDoNoHarm) {
  SurfaceMesh mesh = icosphere(3);
  for (std::size_t v = 0; v < mesh.position.size(); v += 2) mesh.position[v] = mesh.position[0];
  expect_closed_manifold(simplify(mesh, 50).mesh, 1, 0);
  for (Vec3& p : mesh.position) p = Vec3(0.25, 0.5, 0.75);
  expect_closed_manifold(simplify(mesh, 50).mesh, 1, 0);
}

TEST(ControlMesh, IsTheSameForAnyNumberOfThreads) {
  SurfaceMesh mesh = torus_mesh(240, 100);
  Random random(3);
  for (Vec3& p : mesh.position) p += 0.002 * random.in_cube();
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return simplify(mesh, 1500).mesh;
  };
  expect_same_mesh(with_threads(1), with_threads(2));
}

TEST(ControlMesh, CanBeCancelled) {
  Progress progress([](double, const char*) { return false; }, {Stage::control_mesh});
  EXPECT_THROW(make_control_mesh(icosphere(5), 0, {}, progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap::testing
