// Smaller voxels where samples are dense, and the boundary of voxels of two sizes.
#include "initial_mesh/voxel_refinement.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "expect_mesh.h"
#include "initial_mesh/initial_mesh.h"
#include "initial_mesh/voxel_boundary.h"
#include "oriented_cloud.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

InitialMesh initial_mesh_of(const PointCloud& cloud, double dense_spacing) {
  Progress silent;
  InitialMeshOptions options;
  options.dense_spacing = dense_spacing;
  options.voxel_ratio_for_detail = 0.0;
  return make_initial_mesh(cloud, options, silent);
}

constexpr double kDefault = InitialMeshOptions().dense_spacing;
constexpr double kNever = 0.0;

void add_ball(std::vector<Vec3>& points, const Vec3& centre, double radius, Index count,
              unsigned seed) {
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, count, seed))
    points.push_back(centre + radius * p);
}

// A large ball, and beside it two small ones, sampled three times as densely, that are apart by
// less than two of their own spacings, which is half of the large one's.
std::vector<Vec3> balls() {
  std::vector<Vec3> points;
  add_ball(points, Vec3::Zero(), 1.0, 4000, 1);
  add_ball(points, {1.6, 0.115, 0.0}, 0.1, 400, 2);
  add_ball(points, {1.6, -0.115, 0.0}, 0.1, 400, 3);
  return points;
}

// A large ball, and beside it a small torus, sampled four times as densely, whose hole is as wide
// as two and a half spacings of the ball; with noise, x spacing of the torus.
std::vector<Vec3> ball_and_torus(double noise) {
  std::vector<Vec3> points;
  add_ball(points, Vec3::Zero(), 1.0, 4000, 1);
  Random random(3);
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::torus, 600, 2)) {
    Vec3 moved = Vec3(1.6, 0.0, 0.0) + 0.14 * p;
    for (int axis = 0; axis < 3; ++axis) moved[axis] += 0.0154 * noise * random.gaussian();
    points.push_back(moved);
  }
  return points;
}

TEST(VoxelRefinement, KeepsDensePartsApart) {
  const PointCloud cloud = oriented_cloud(balls());
  const InitialMesh coarse = initial_mesh_of(cloud, kNever);
  EXPECT_EQ(coarse.report.refined_parts, 0);
  EXPECT_EQ(coarse.report.components, 2) << "the test is of no use";
  const InitialMesh mesh = initial_mesh_of(cloud, kDefault);
  EXPECT_EQ(mesh.report.refined_parts, 1);
  EXPECT_EQ(mesh.report.components, 3);
  expect_closed_manifold(mesh.mesh, 3, 0);
  // Where nothing is dense the mesh is not finer.
  const auto of_large_ball = [](const InitialMesh& initial, const PointCloud& samples) {
    return std::count_if(initial.mesh.position.begin(), initial.mesh.position.end(),
                         [&](const Vec3& p) {
                           return (p - samples.frame.to_unit(Vec3::Zero())).norm() <
                                  samples.frame.to_unit(Vec3(1.2, 0, 0)).norm();
                         });
  };
  EXPECT_NEAR(of_large_ball(mesh, cloud), of_large_ball(coarse, cloud),
              0.01 * coarse.mesh.vertex_count());
}

// The same where the small balls have most of the samples, and voxels suit a wider spacing.
TEST(VoxelRefinement, KeepsDensePartsApartThatHaveMostSamples) {
  std::vector<Vec3> points;
  add_ball(points, Vec3::Zero(), 1.0, 700, 1);
  add_ball(points, {1.6, 0.14, 0.0}, 0.1, 400, 2);
  add_ball(points, {1.6, -0.14, 0.0}, 0.1, 400, 3);
  const PointCloud cloud = oriented_cloud(points);
  InitialMeshOptions options;
  options.voxel_ratio_for_detail = options.voxel_ratio_for_bodies = options.many_squares = 0.0;
  options.dense_spacing = kNever;
  Progress silent;
  const InitialMesh coarse = make_initial_mesh(cloud, options, silent);
  EXPECT_GT(coarse.report.spacing, 2.0);
  EXPECT_EQ(coarse.report.components, 2) << "the test is of no use";
  options.dense_spacing = kDefault;
  const InitialMesh mesh = make_initial_mesh(cloud, options, silent);
  EXPECT_EQ(mesh.report.refined_parts, 1);
  expect_closed_manifold(mesh.mesh, 3, 0);
}

TEST(VoxelRefinement, LeavesEvenCloudsAlone) {
  for (const ShapeKind kind : {ShapeKind::double_torus, ShapeKind::thin_plate, ShapeKind::blob}) {
    SCOPED_TRACE(shape_of(kind).name);
    const PointCloud cloud = oriented_cloud(sample_shape(kind, 8000, 4));
    const InitialMesh mesh = initial_mesh_of(cloud, kDefault);
    EXPECT_EQ(mesh.report.refined_parts, 0);
    expect_same_mesh(mesh.mesh, initial_mesh_of(cloud, kNever).mesh);
  }
}

// The same balls, with normals of the dense part reversed at random.
TEST(VoxelRefinement, LeavesPartsThatTheSamplesDoNotBearOut) {
  PointCloud cloud = oriented_cloud(balls());
  Random random(5);
  for (Index i = 0; i < cloud.size(); ++i)
    if (cloud.frame.to_input(cloud.position[i]).x() > 1.2 && random.uniform() < 0.1)
      cloud.normal[i] = -cloud.normal[i];
  EXPECT_EQ(initial_mesh_of(cloud, kDefault).report.refined_parts, 0);
}

TEST(VoxelRefinement, DecidesOnEachPart) {
  std::vector<Vec3> points = balls();
  for (const Vec3& p : ball_and_torus(0.5))
    if (p.x() > 1.2) points.push_back(-p);
  const InitialMesh mesh = initial_mesh_of(oriented_cloud(points), kDefault);
  EXPECT_EQ(mesh.report.refined_parts, 1);
  expect_closed_manifold(mesh.mesh, 4, 0);
}

TEST(VoxelRefinement, ShowsHandlesThatTheSamplesShow) {
  const PointCloud cloud = oriented_cloud(ball_and_torus(0.0));
  EXPECT_EQ(initial_mesh_of(cloud, kNever).report.genus, 0) << "the test is of no use";
  const InitialMesh mesh = initial_mesh_of(cloud, kDefault);
  EXPECT_EQ(mesh.report.refined_parts, 1);
  expect_closed_manifold(mesh.mesh, 2, 1);
}

TEST(VoxelRefinement, LeavesPartsWhoseHandlesTheSamplesDoNotShow) {
  const PointCloud cloud = oriented_cloud(ball_and_torus(0.5));
  const WindingNumber winding(cloud);
  Progress silent;
  VoxelSolid solid = make_voxel_solid(cloud, winding, {}, silent);
  make_well_composed(solid.image, silent);
  const VoxelSolid before = solid;
  EXPECT_EQ(refine_dense_parts(solid, cloud, winding, {}, silent), 0);
  EXPECT_EQ(solid.lattice.size, before.lattice.size);
  EXPECT_EQ(solid.image.mask, before.image.mask);
  EXPECT_TRUE(solid.image.in_blocks.empty());
  expect_closed_manifold(initial_mesh_of(cloud, kDefault).mesh, 2, 0);
}

// A ball in a hollow ball, along scan lines, which are dense about the poles.
TEST(VoxelRefinement, GapsBetweenScanLinesAreNoHandles) {
  for (const unsigned seed : {0u, 4u}) {
    std::vector<Vec3> points = sample_sphere_on_scan_lines(800, seed);
    for (const Vec3& p : sample_sphere_on_scan_lines(392, seed + 50)) points.push_back(0.7 * p);
    for (const Vec3& p : sample_sphere_on_scan_lines(98, seed + 90)) points.push_back(0.35 * p);
    EXPECT_EQ(initial_mesh_of(oriented_cloud(points), kDefault).report.genus, 0);
  }
}

// The boundary with large squares is that without, with fewer vertices.
TEST(VoxelBoundary, OfTwoSizesIsThatOfTheSmaller) {
  const PointCloud cloud = oriented_cloud(balls());
  const WindingNumber winding(cloud);
  Progress silent;
  VoxelSolid solid = make_voxel_solid(cloud, winding, {}, silent);
  const double whole = solid.lattice.size;
  ASSERT_EQ(refine_dense_parts(solid, cloud, winding, {}, silent), 1);
  EXPECT_EQ(solid.lattice.size, 0.5 * whole);
  make_well_composed(solid.image, silent);
  ASSERT_FALSE(solid.image.in_blocks.empty());
  // Blocks beside single voxels on all sides, and within the surface.
  Random random(6);
  for (int step = 0; step < 4; ++step) {
    const SurfaceMesh mesh = boundary_of(solid.image, solid.lattice, silent);
    VoxelImage fine = solid.image;
    fine.in_blocks.clear();
    const SurfaceMesh all = boundary_of(fine, solid.lattice, silent);
    expect_closed_manifold(mesh, 3, 0);
    expect_closed_manifold(all, 3, 0);
    EXPECT_LT(mesh.vertex_count(), step == 0 ? all.vertex_count() / 2 : all.vertex_count());
    EXPECT_NEAR(signed_volume(mesh), signed_volume(all), 1e-12 * signed_volume(all));
    const auto before = [](const Vec3& a, const Vec3& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    const std::set<Vec3, decltype(before)> corners(all.position.begin(), all.position.end(),
                                                   before);
    for (const Vec3& p : mesh.position) EXPECT_TRUE(corners.count(p)) << p.transpose();
    // No triangle has no area, and none cuts a corner: all lie in planes between voxels.
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      const Vec3 area = mesh.area_vector(f) / (solid.lattice.size * solid.lattice.size);
      EXPECT_GT(area.norm(), 0.4);
      EXPECT_LT(area.norm(), 4.1);
      EXPECT_NEAR(area.cwiseAbs().maxCoeff(), area.norm(), 1e-9);
    }
    for (char& in_blocks : solid.image.in_blocks) in_blocks &= random.uniform() < 0.6;
  }
}

TEST(VoxelBoundary, EulerCharacteristicIsTheSumOverBricks) {
  const PointCloud cloud =
      oriented_cloud(sample_shape_blue_noise(ShapeKind::double_torus, 4000, 7));
  Progress silent;
  VoxelSolid solid = make_voxel_solid(cloud, WindingNumber(cloud), {}, silent);
  make_well_composed(solid.image, silent);
  Index sum = 0;
  for (const Index part : euler_characteristics(solid.image, silent)) sum += part;
  EXPECT_EQ(sum, -2);
  EXPECT_EQ(boundary_of(solid.image, solid.lattice, silent).euler_characteristic(), -2);
}

TEST(VoxelRefinement, IsTheSameForAnyNumberOfThreads) {
  const PointCloud cloud = oriented_cloud(balls());
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return initial_mesh_of(cloud, kDefault).mesh;
  };
  expect_same_mesh(with_threads(1), with_threads(2));
}

TEST(Reconstruction, OfDensePartsKeepsThemApart) {
  Progress silent;
  const std::vector<Vec3> points = balls();
  const Reconstruction result = reconstruct(points, {}, silent);
  EXPECT_EQ(result.initial_mesh.refined_parts, 1);
  EXPECT_EQ(result.report.components, 3);
  EXPECT_EQ(result.report.genus, 0);
  EXPECT_EQ(result.report.self_intersecting_faces, 0);
  EXPECT_TRUE(result.report.complete_matching());
}

// Smaller voxels would show the noise.
TEST(Reconstruction, OfNoisyCloudsHasNoSmallerVoxels) {
  Progress silent;
  std::vector<Vec3> points = balls();
  Random random(8);
  for (Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += (p.x() > 1.2 ? 0.009 : 0.028) * random.gaussian();
  const Reconstruction result = reconstruct(points, {}, silent);
  EXPECT_GT(result.noise.median, NoiseOptions().high);
  EXPECT_EQ(result.initial_mesh.refined_parts, 0);
}

// Noise turns normals, so that samples count as sharp.
TEST(Reconstruction, OfNoisyCloudsHasNoVoxelsForDetail) {
  Progress silent;
  ReconstructionOptions options;
  const auto initial_mesh_of_plate = [&](double noise) {
    SampleDefects defects;
    defects.noise = noise;
    const Reconstruction result =
        reconstruct(sample_shape(ShapeKind::thin_plate, 4000, 4, defects), options, silent);
    EXPECT_FALSE(result.smoothing.is_taken);
    EXPECT_GT(result.initial_mesh.sharp, InitialMeshOptions().least_sharp);
    return result.initial_mesh;
  };
  EXPECT_TRUE(initial_mesh_of_plate(0.0).is_of_detail_size);
  EXPECT_FALSE(initial_mesh_of_plate(0.5).is_of_detail_size);
  options.stop_at_parametric_surface = true;
  EXPECT_TRUE(initial_mesh_of_plate(0.0).is_of_detail_size);
  EXPECT_FALSE(initial_mesh_of_plate(0.1).is_of_detail_size);
}

}  // namespace
}  // namespace shrinkwrap::testing
