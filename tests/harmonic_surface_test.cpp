// Patches stretched between what surrounds them.
#include "mesh/harmonic_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

std::vector<Index> vertices_above(const SurfaceMesh& mesh, double z) {
  std::vector<Index> vertices;
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    if (mesh.position[v].z() > z) vertices.push_back(v);
  return vertices;
}

bool holds(const std::vector<Index>& vertices, Index v) {
  return std::binary_search(vertices.begin(), vertices.end(), v);
}

// The pull of its neighbours on a vertex, by cotangents of the mesh as it was, as a part of the sum
// of what each pulls.
double imbalance(const SurfaceMesh& before, const SurfaceMesh& mesh, Index v) {
  const auto cotangent = [&](Index h) {
    const Vec3& apex = before.position[before.opposite(h)];
    const Vec3 a = before.position[before.origin(h)] - apex;
    const Vec3 b = before.position[before.target(h)] - apex;
    return a.dot(b) / a.cross(b).norm();
  };
  Vec3 sum = Vec3::Zero();
  double all = 0.0;
  mesh.for_each_outgoing(v, [&](Index h) {
    const Vec3 pull = (cotangent(h) + cotangent(mesh.twin(h))) *
                      (mesh.position[mesh.target(h)] - mesh.position[v]);
    sum += pull;
    all += pull.norm();
  });
  return sum.norm() / all;
}

TEST(HarmonicSurface, IsFlatWithinAFlatRim) {
  Progress silent;
  for (const int subdivisions : {2, 6}) {
    SurfaceMesh mesh = icosphere(subdivisions);
    const std::vector<Index> cap = vertices_above(mesh, 0.5);
    double radius = 0.0;
    for (Index v = 0; v < mesh.vertex_slots(); ++v) {
      Vec3& p = mesh.position[v];
      bool is_rim = false;
      mesh.for_each_outgoing(v, [&](Index h) { is_rim |= holds(cap, mesh.target(h)); });
      if (holds(cap, v) || !is_rim) continue;
      p.z() = 0.5;
      radius = std::max(radius, p.norm());
    }
    const SurfaceMesh before = mesh;
    ASSERT_TRUE(make_harmonic(mesh, cap, silent));
    double nearest_to_axis = 1.0;
    for (Index v = 0; v < mesh.vertex_slots(); ++v) {
      const Vec3& p = mesh.position[v];
      if (!holds(cap, v)) {
        EXPECT_EQ(p, before.position[v]);
        continue;
      }
      EXPECT_NEAR(p.z(), 0.5, 1e-4);
      EXPECT_LT(p.norm(), radius);
      nearest_to_axis = std::min(nearest_to_axis, std::hypot(p.x(), p.y()));
    }
    EXPECT_LT(nearest_to_axis, 0.2) << "over all of the opening";
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      if (!holds(cap, mesh.triangle(f)[0])) continue;
      EXPECT_GT(mesh.area_vector(f).z(), 0.0) << "no fold";
    }
  }
}

TEST(HarmonicSurface, IsInBalance) {
  Progress silent;
  // Where the membrane energy is least, whose second derivatives are the cotangents.
  SurfaceMesh mesh = icosphere(3);
  Random random(1);
  for (Vec3& p : mesh.position) p = p.cwiseProduct(Vec3(1.0, 1.1, 0.95)) + 0.01 * random.in_cube();
  const SurfaceMesh before = mesh;
  const std::vector<Index> cap = vertices_above(mesh, 0.2);
  ASSERT_TRUE(make_harmonic(mesh, cap, silent));
  double greatest_before = 0.0;
  for (const Index v : cap) {
    EXPECT_LT(imbalance(before, mesh, v), 1e-4);
    greatest_before = std::max(greatest_before, imbalance(before, before, v));
  }
  EXPECT_GT(greatest_before, 0.1);
}

TEST(HarmonicSurface, SeveralPatchesAtOnceAndOneByOne) {
  Progress silent;
  const SurfaceMesh sphere = icosphere(3);
  const std::vector<Index> top = vertices_above(sphere, 0.7);
  std::vector<Index> bottom, both;
  for (Index v = 0; v < sphere.vertex_slots(); ++v)
    if (sphere.position[v].z() < -0.8) bottom.push_back(v);
  std::set_union(top.begin(), top.end(), bottom.begin(), bottom.end(), std::back_inserter(both));
  SurfaceMesh at_once = sphere, one_by_one = sphere;
  ASSERT_TRUE(make_harmonic(at_once, both, silent));
  ASSERT_TRUE(make_harmonic(one_by_one, top, silent) && make_harmonic(one_by_one, bottom, silent));
  for (Index v = 0; v < sphere.vertex_slots(); ++v)
    EXPECT_LT((at_once.position[v] - one_by_one.position[v]).norm(), 1e-4);
}

TEST(HarmonicSurface, FacesOfNoAreaDoNoHarm) {
  Progress silent;
  SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> cap = vertices_above(mesh, 0.5);
  for (std::size_t i = 0; i < cap.size(); i += 2) mesh.position[cap[i]] = Vec3(0.0, 0.0, 0.9);
  ASSERT_TRUE(make_harmonic(mesh, cap, silent));
  for (const Index v : cap) {
    EXPECT_TRUE(mesh.position[v].allFinite());
    EXPECT_LT(mesh.position[v].norm(), 1.0);
  }
}

TEST(HarmonicSurface, WhatIsFlatStays) {
  // In a plane through the origin two coordinates have next to nothing to go.
  Progress silent;
  SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> cap = vertices_above(mesh, 0.3);
  for (Vec3& p : mesh.position) p = Vec3(1e-17 * p.z(), p.x(), p.y());
  ASSERT_TRUE(make_harmonic(mesh, cap, silent));
  for (const Index v : cap) {
    EXPECT_LT(std::abs(mesh.position[v].x()), 1e-16);
    EXPECT_LT(mesh.position[v].norm(), 1.0);
  }
}

TEST(HarmonicSurface, CanBeCancelled) {
  SurfaceMesh mesh = icosphere(3);
  Progress refused([](double, const char*) { return false; }, {Stage::parametric_surface});
  EXPECT_THROW(refused.begin(Stage::parametric_surface), Cancelled);
  EXPECT_THROW(make_harmonic(mesh, vertices_above(mesh, 0.5), refused), Cancelled);
  EXPECT_EQ(mesh.position, icosphere(3).position);
}

TEST(HarmonicSurface, NothingToMove) {
  Progress silent;
  SurfaceMesh mesh = icosphere(1);
  EXPECT_TRUE(make_harmonic(mesh, {}, silent));
  EXPECT_EQ(mesh.position, icosphere(1).position);
}

}  // namespace
}  // namespace shrinkwrap::testing
