// Edge optimisation, last step: where the diagonals are far apart, the nearer to the surface.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "edge_optimisation/edge_optimisation.h"
#include "expect_mesh.h"
#include "mesh/delaunay_flips.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::expect_closed_manifold;
using testing::expect_same_mesh;
using testing::Random;

// Vertices on a torus (radii 0.75 and 0.25) at uneven distances, their triangles Delaunay.
SurfaceMesh uneven_torus(int around, int along, unsigned seed) {
  Random random(seed);
  SurfaceMesh mesh = testing::torus_mesh(around, along);
  for (Vec3& p : mesh.position) {
    p += 1.5 / around * random.in_cube();
    const Vec3 ring = 0.75 * Vec3(p.x(), p.y(), 0.0).normalized();
    p = ring + 0.25 * (p - ring).normalized();
  }
  Progress progress;
  make_delaunay(mesh, VertexBlocks(mesh.position, progress), progress);
  return mesh;
}

double mean_distance_of_edges_to_torus(const SurfaceMesh& mesh) {
  double sum = 0.0;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
    const Vec3 p = 0.5 * (mesh.position[mesh.origin(h)] + mesh.position[mesh.target(h)]);
    const Vec3 ring = 0.75 * Vec3(p.x(), p.y(), 0.0).normalized();
    sum += std::abs((p - ring).norm() - 0.25);
  }
  return sum / mesh.halfedge_slots();
}

double greatest_sum_of_opposite_angles(const SurfaceMesh& mesh) {
  double greatest = 0.0;
  const auto opposite_angle = [&](Index h) {
    const Vec3& apex = mesh.position[mesh.opposite(h)];
    const Vec3 u = mesh.position[mesh.origin(h)] - apex, v = mesh.position[mesh.target(h)] - apex;
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    greatest = std::max(greatest, opposite_angle(h) + opposite_angle(mesh.twin(h)));
  return greatest;
}

TEST(LeastGap, TheLowerTheNearerToTheSurface) {
  const SurfaceMesh delaunay = uneven_torus(60, 24, 15);
  std::array<double, 3> distance, angles;
  for (int k = 0; k < 3; ++k) {
    EdgeOptimisationOptions options;
    options.least_gap = std::array<double, 3>{0.0, 0.03, 1.0}[k];
    options.gap_over_median = options.largest_gaps = 0.0;
    SurfaceMesh mesh = delaunay;
    Progress progress;
    optimise_edges(mesh, options, progress);
    EXPECT_EQ(mesh.position, delaunay.position);
    expect_closed_manifold(mesh, 1, 1);
    distance[k] = mean_distance_of_edges_to_torus(mesh);
    angles[k] = greatest_sum_of_opposite_angles(mesh);
  }
  EXPECT_LT(distance[0], 0.995 * distance[1]);  // most edges have no other choice
  EXPECT_LT(distance[1], 0.998 * distance[2]);
  // Flips make up to 260 degrees; those beside them add some.
  EXPECT_LT(angles[0], 280.0 * kPi / 180.0);
}

TEST(LeastGap, IsThatOfNoiseWhereThereIsNoise) {
  SurfaceMesh noisy = testing::icosphere(4);
  Random random(16);
  for (Vec3& p : noisy.position) p *= 1.0 + 0.01 * random.uniform(-1.0, 1.0);
  const auto flips = [&](double least_gap, double gap_over_median) {
    EdgeOptimisationOptions options;
    options.least_gap = least_gap;
    options.gap_over_median = gap_over_median;
    options.largest_gaps = 0.0;
    SurfaceMesh mesh = noisy;
    Progress progress;
    return optimise_edges(mesh, options, progress).flips;
  };
  const EdgeOptimisationOptions by_default;
  const Index others = flips(1.0, 0.0);
  EXPECT_GT(flips(by_default.least_gap, 0.0) - others, 200);
  EXPECT_LT(flips(by_default.least_gap, by_default.gap_over_median) - others, 20);
}

TEST(LeastGap, IsNotAskedOfTheLargestGaps) {
  const SurfaceMesh delaunay = uneven_torus(240, 96, 17);  // all below the least gap
  const auto optimised = [&](const EdgeOptimisationOptions& options) {
    SurfaceMesh mesh = delaunay;
    Progress progress;
    optimise_edges(mesh, options, progress);
    return mesh;
  };
  EdgeOptimisationOptions options;
  options.least_gap = 1.0;
  const SurfaceMesh nowhere = optimised(options);
  options.least_gap = 0.0;
  const SurfaceMesh everywhere = optimised(options);
  options = {};
  options.largest_gaps = 0.0;
  expect_same_mesh(optimised(options), nowhere);
  options.largest_gaps = 1.0;
  expect_same_mesh(optimised(options), everywhere);
  options.largest_gaps = 0.5;
  const double distance = mean_distance_of_edges_to_torus(optimised(options));
  EXPECT_LT(distance, 0.95 * mean_distance_of_edges_to_torus(nowhere));
  EXPECT_GT(distance, 1.02 * mean_distance_of_edges_to_torus(everywhere));
}

TEST(LeastGap, DoesNotDependOnThreadsAndLeavesFixedFacesAlone) {
  SurfaceMesh one = uneven_torus(220, 100, 18);  // several blocks
  const std::vector<Triangle> before = one.triangles();
  std::vector<Index> fixed;
  for (Index f = 0; f < one.face_slots(); f += 7) fixed.push_back(f);
  EdgeOptimisationOptions options;
  options.least_gap = 0.0;
  SurfaceMesh two = one;
  Progress progress;
  for (SurfaceMesh* mesh : {&one, &two}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    mesh == &one ? 1 : 4);
    EXPECT_GT(optimise_edges(*mesh, options, progress, fixed).flips, 1000);
  }
  expect_same_mesh(one, two);
  for (const Index f : fixed) EXPECT_EQ(one.triangle(f), before[f]);
}

}  // namespace
}  // namespace shrinkwrap
