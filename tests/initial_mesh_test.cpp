// The winding number, the voxel solid, and the initial mesh made of them.
#include "initial_mesh/initial_mesh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "expect_mesh.h"
#include "initial_mesh/voxel_solid.h"
#include "orientation/winding_number.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

InitialMesh initial_mesh_of(const PointCloud& samples, const InitialMeshOptions& options = {}) {
  Progress silent;
  return make_initial_mesh(samples, options, silent);
}

TEST(WindingNumber, IsOneInsideAndZeroOutside) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::torus, ShapeKind::bowl}) {
    const Shape shape = shape_of(kind);
    SCOPED_TRACE(shape.name);
    const PointCloud samples = oriented_cloud(sample_shape_blue_noise(kind, 6000, 1));
    const WindingNumber winding(samples);
    const double spacing = samples.frame.to_input_length(samples.spacing);
    Random random(2);
    int looked_at = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = 1.2 * shape.radius * random.in_cube();
      const double distance = shape.implicit(p);
      if (std::abs(distance) < 1.5 * spacing) continue;
      ++looked_at;
      EXPECT_NEAR(winding.at(samples.frame.to_unit(p)), distance < 0.0 ? 1.0 : 0.0, 0.12);
    }
    EXPECT_GT(looked_at, 500);
  }
}

TEST(WindingNumber, FarAwayItFallsToZero) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::sphere, 500, 3));
  const WindingNumber winding(samples);
  EXPECT_NEAR(winding.at(Vec3(1e3, 0, 0)), 0.0, 1e-4);
  EXPECT_NEAR(winding.at(Vec3(1e9, -1e9, 1e9)), 0.0, 1e-9);
}

TEST(WindingNumber, FallsSmoothlyAcrossAnOpening) {
  const PointCloud samples =
      oriented_cloud(sample_shape_blue_noise(ShapeKind::hemisphere, 4000, 4));
  const WindingNumber winding(samples);
  Vec3 centre = Vec3::Zero();  // of the rim: below the cap along its axis
  for (const Vec3& p : samples.position) centre += p;
  centre /= samples.size();
  const Vec3 down = (samples.frame.to_unit(Vec3::Zero()) - centre).normalized();
  double last = winding.at(centre);
  EXPECT_GT(last, 0.4);
  for (int i = 1; i <= 40; ++i) {
    const double value = winding.at(centre + 0.1 * i * down);
    EXPECT_LT(value, last + 1e-6);
    last = value;
  }
  EXPECT_LT(last, 0.1);
}

TEST(VoxelSolid, HoldsWhatIsDeepInside) {
  const Shape shape = shape_of(ShapeKind::torus);
  const PointCloud samples = oriented_cloud(sample_shape_blue_noise(ShapeKind::torus, 5000, 5));
  const WindingNumber winding(samples);
  Progress silent;
  const InitialMeshOptions options;
  const VoxelSolid solid = make_voxel_solid(samples, winding, options, silent);
  const double spacing = samples.frame.to_input_length(samples.spacing);
  Random random(6);
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p = 1.1 * shape.radius * random.in_cube();
    const double distance = shape.implicit(p);
    if (std::abs(distance) < 2.0 * spacing) continue;
    EXPECT_EQ(solid.contains(samples.frame.to_unit(p)), distance < 0.0) << p.transpose();
  }
}

class InitialMeshOf : public ::testing::TestWithParam<ShapeKind> {};

TEST_P(InitialMeshOf, HasTheTopologyOfTheShapeAndLiesOnIt) {
  const Shape shape = shape_of(GetParam());
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const PointCloud samples =
        oriented_cloud(sample_shape(GetParam(), 8000, seed, {0.0, 0.0, true}));
    const InitialMesh initial = initial_mesh_of(samples);
    expect_closed_manifold(initial.mesh, shape.components, shape.genus);
    EXPECT_GT(signed_volume(initial.mesh), 0.0);
    EXPECT_GT(initial.report.samples_with_solid_behind, 0.99);
    EXPECT_EQ(initial.report.components, shape.components);
    double sum = 0.0;
    for (const Vec3& p : initial.mesh.position)
      sum += std::sqrt(samples.search.nearest(p).squared_distance);
    EXPECT_LT(sum / initial.mesh.vertex_count(), 0.8 * samples.spacing);
  }
}
INSTANTIATE_TEST_SUITE_P(Shapes, InitialMeshOf, ::testing::ValuesIn(closed_shapes()),
                         [](const auto& test) { return shape_of(test.param).name; });

TEST(InitialMesh, ClosesAnOpeningWithoutFoam) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::hemisphere, 6000, 9));
  const InitialMesh initial = initial_mesh_of(samples);
  expect_closed_manifold(initial.mesh, 1, 0);
  // Half a ball, or thereabouts, and not the shell of the cap alone.
  const double unit = samples.frame.to_input_length(1.0);
  EXPECT_GT(signed_volume(initial.mesh) * unit * unit * unit, 1.0);
  EXPECT_LT(signed_volume(initial.mesh) * unit * unit * unit, 4.5);
}

TEST(InitialMesh, InnerWallBecomesACavity) {
  // Two concentric spheres: the inner one is the wall of a cavity.
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, 6000, 10);
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, 1500, 11))
    points.push_back(0.5 * p);
  const PointCloud samples = oriented_cloud(points);
  const InitialMesh initial = initial_mesh_of(samples);
  expect_closed_manifold(initial.mesh, 2, 0);
  EXPECT_EQ(initial.report.cavities, 1);
}

TEST(InitialMesh, SamplesFourteenTimesAsFarApartAsMostHaveNoHolesBetweenThem) {
  const PointCloud samples = oriented_cloud(testing::sample_spiked_ball(1000, 14.0));
  Index sparse = 0;
  for (const float spacing : samples.local_spacing) sparse += spacing > 10.0 * samples.spacing;
  EXPECT_GT(sparse, 500);
  EXPECT_LT(sparse, samples.size() / 3);
  expect_closed_manifold(initial_mesh_of(samples).mesh, 1, 0);
}

// Planes of dense samples reach as far as the larger voxels need.
TEST(InitialMesh, LargerVoxelsAreSolidBehindDenseSamples) {
  const InitialMesh initial =
      initial_mesh_of(oriented_cloud(testing::sample_spiked_ball(1000, 20.0)));
  ASSERT_TRUE(initial.report.voxels_are_larger);
  EXPECT_GT(initial.report.samples_with_solid_behind, 0.999);
}

InitialMeshOptions without_detail() {
  InitialMeshOptions options;
  options.voxel_ratio_for_detail = 0.0;
  return options;
}

double voxels_of(const PointCloud& cloud, const InitialMeshOptions& options = {}) {
  Progress silent;
  return make_voxel_solid(cloud, WindingNumber(cloud), options, silent).lattice.size /
         cloud.spacing;
}

// Three in five samples are five times as close as the others: in squares of their spacing, these
// are ten per sample.
TEST(VoxelSolid, VoxelsOfUnevenCloudsAreLarger) {
  Random random(8);
  std::vector<Vec3> points;
  for (Index i = 0; i < 6000; ++i) {
    const bool is_dense = i % 5 < 3;
    const double low = is_dense ? 0.4 : 0.0, high = is_dense ? 0.65 : 1.0;
    points.push_back({random.uniform(low, high), random.uniform(low, high), 0.0});
    points.back().z() = 0.1 * std::sin(5.0 * points.back().x());
  }
  const PointCloud cloud = oriented_cloud(points);
  InitialMeshOptions options = without_detail();
  EXPECT_EQ(voxels_of(cloud, options), options.voxel_size) << "there are few squares in all";
  options.many_squares = 0.0;
  const double size = voxels_of(cloud, options);
  EXPECT_GT(size, 1.2 * options.voxel_size);
  EXPECT_LT(size, 2.0 * options.voxel_size);
  Progress silent;
  const InitialMesh initial = make_initial_mesh(cloud, options, silent);
  EXPECT_NEAR(initial.report.spacing, size / options.voxel_size, 1e-9);
  EXPECT_FALSE(initial.report.voxels_are_larger);
  EXPECT_GT(initial.report.samples_with_solid_behind, 0.999);
  options.voxel_size *= 0.7;
  EXPECT_NEAR(voxels_of(cloud, options), 0.7 * size, 1e-9);
}

TEST(VoxelSolid, VoxelsAreNoLargerForSomeStrays) {
  Random random(9);
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 20000, 3);
  for (int i = 0; i < 20; ++i) points.push_back(50.0 * random.in_cube());
  EXPECT_EQ(voxels_of(oriented_cloud(points)), InitialMeshOptions().voxel_size);
}

TEST(InitialMesh, WhereNothingIsInsideTheSolidIsWhatIsNearTheSamples) {
  InitialMeshOptions options;
  options.level = 2.0;
  options.second_voxel_ratio = options.voxel_ratio_for_detail = 0.0;
  Progress silent;
  const InitialMesh initial =
      make_initial_mesh(oriented_cloud(sample_shape(ShapeKind::sphere, 2000, 3)), options, silent);
  EXPECT_GT(initial.mesh.face_count(), 0);
  EXPECT_GT(initial.report.samples_with_solid_behind, 0.9);
}

TEST(InitialMesh, TheBoundingBoxStartTellsWhatGoesOn) {
  std::string last;
  Progress progress(
      [&](double, const char* stage) {
        last = stage;
        return true;
      },
      {Stage::samples, Stage::initial_mesh});
  progress.begin(Stage::samples);
  InitialMeshOptions options;
  options.start = InitialMeshOptions::Start::bounding_box;
  make_initial_mesh(oriented_cloud(sample_shape(ShapeKind::sphere, 500, 3)), options, progress);
  EXPECT_EQ(last, stage_name(Stage::initial_mesh));
}

TEST(InitialMesh, ClumpsOfStrayPointsAreNoBodies) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 4000, 12);
  Random random(13);
  for (int i = 0; i < 12; ++i) points.push_back(Vec3(3, 0, 0) + 0.02 * random.in_cube());
  expect_closed_manifold(initial_mesh_of(oriented_cloud(points)).mesh, 1, 0);
}

TEST(InitialMesh, TheSmallestBodyMayBeOfMoreThanAHundredthOfTheSamples) {
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, 4000, 9);
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, 160, 10))
    points.push_back(0.2 * p + Vec3(2.0, 0.0, 0.0));
  const PointCloud samples = oriented_cloud(points);
  InitialMeshOptions options;
  EXPECT_EQ(initial_mesh_of(samples, options).report.dropped, 0);
  options.min_component_samples = 250;
  EXPECT_EQ(initial_mesh_of(samples, options).report.dropped, 1);
}

// Of many small bodies one has twice as many samples: the others are no debris of it.
TEST(InitialMesh, SmallBodiesStayWhereAllAreSmall) {
  constexpr Index kBodies = 400;
  std::vector<Vec3> points;
  for (Index body = 0; body < kBodies; ++body)
    for (const Vec3& p :
         sample_shape_blue_noise(ShapeKind::sphere, body == 0 ? 40 : 17, unsigned(body)))
      points.push_back(p + 10.0 * Vec3(body % 20, body / 20, 0));
  const InitialMesh initial = initial_mesh_of(oriented_cloud(points));
  EXPECT_GT(initial.report.components, 0.98 * kBodies);
}

TEST(InitialMesh, VoxelsTooSmallForThePlanesOfSamplesAreRefused) {
  const PointCloud cloud = oriented_cloud(sample_shape(ShapeKind::sphere, 800, 1));
  InitialMeshOptions options;
  Progress silent;
  for (const double size : {0.0, 0.05, -1.0, std::nan("")}) {
    options.voxel_size = size;
    EXPECT_THROW(make_initial_mesh(cloud, options, silent), InvalidInput) << size;
  }
  options.voxel_size = 0.25;
  EXPECT_EQ(make_initial_mesh(cloud, options, silent).report.genus, 0);
}

TEST(InitialMesh, FourPointsMakeOne) {
  const PointCloud samples = oriented_cloud({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  expect_closed_manifold(initial_mesh_of(samples).mesh, 1, 0);
}

TEST(InitialMesh, IsTheSameForAnyNumberOfThreads) {
  const PointCloud samples = oriented_cloud(sample_shape(ShapeKind::double_torus, 20000, 14));
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return initial_mesh_of(samples).mesh;
  };
  expect_same_mesh(with_threads(1), with_threads(2));
}

// A cone whose samples are the denser the nearer they are to its tip, by eight powers of ten.
TEST(VoxelSolid, BricksAreNoMoreThanAFewTimesTheSamples) {
  Random random(20);
  std::vector<Vec3> points;
  for (int i = 0; i < 5000; ++i) {
    const double turn = random.uniform(0.0, 2.0 * kPi), r = std::pow(10.0, -8.0 * random.uniform());
    points.push_back(r * Vec3(std::cos(turn), std::sin(turn), 2.0));
  }
  const PointCloud samples = oriented_cloud(points);
  Progress silent;
  const VoxelSolid solid = make_voxel_solid(samples, WindingNumber(samples), {}, silent);
  EXPECT_LT(solid.image.bricks.size(), 30 * samples.size());
  const InitialMesh mesh = initial_mesh_of(samples);
  EXPECT_TRUE(mesh.report.voxels_are_larger);
  EXPECT_EQ(mesh.report.refined_parts, 0);
  EXPECT_GT(mesh.report.voxel_size, 2.0 * InitialMeshOptions().voxel_size);
  const InitialMesh usual =
      initial_mesh_of(oriented_cloud(sample_shape(ShapeKind::sphere, 500, 3)));
  EXPECT_FALSE(usual.report.voxels_are_larger);
}

TEST(InitialMesh, SmallerVoxelsPartBodiesThatAreClose) {
  // Eight balls at the corners of a cube, of which some are turned, two spacings apart.
  constexpr Index kSamples = 80;
  const double distance = 2.0 + 2.0 * std::sqrt(4.0 * kPi / kSamples);
  Index bodies = 0, bodies_without = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Vec3> points;
    for (unsigned corner = 0; corner < 8; ++corner)
      for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, kSamples, 8 * seed + corner))
        points.push_back(p + distance * Vec3(corner & 1, corner >> 1 & 1, corner >> 2));
    if (seed % 2 == 1)
      for (Vec3& p : points) p = {0.8 * p.x() - 0.6 * p.y(), 0.6 * p.x() + 0.8 * p.y(), p.z()};
    const PointCloud cloud = oriented_cloud(points);
    InitialMeshOptions one_size = without_detail();
    one_size.voxel_ratio_for_bodies = 0.0;
    const InitialMesh mesh = initial_mesh_of(cloud, without_detail()),
                      without = initial_mesh_of(cloud, one_size);
    EXPECT_EQ(mesh.report.components, 8);
    EXPECT_EQ(mesh.report.genus, 0);
    EXPECT_EQ(mesh.report.bodies_parted, mesh.report.components - without.report.components);
    EXPECT_EQ(without.report.bodies_parted, 0);
    bodies += mesh.report.components;
    bodies_without += without.report.components;
  }
  EXPECT_LE(bodies_without, bodies - 5) << "the cases are too easy";
}

// In a cubic grid that is turned at random.
std::vector<Vec3> balls(Index count, Index samples, double distance, unsigned seed,
                        std::vector<Vec3> (*sampled)(ShapeKind, Index, unsigned,
                                                     const SampleDefects&)) {
  Random random(seed);
  const Vec3 along = random.direction(), across = along.cross(random.direction()).normalized(),
             up = along.cross(across);
  std::vector<Vec3> points;
  for (Index ball = 0; ball < count; ++ball)
    for (const Vec3& p :
         sampled(ShapeKind::sphere, samples, 100 * seed + static_cast<unsigned>(ball), {}))
      points.push_back(p + distance * (ball % 3 * along + ball / 3 % 3 * across + ball / 9 * up));
  return points;
}

// Which is no handle: nothing else asks for smaller voxels.
TEST(InitialMesh, SmallerVoxelsPartTwoBodiesThatHaveGrownTogether) {
  constexpr Index kSamples = 120;
  const double distance = 2.0 + 2.5 * std::sqrt(4.0 * kPi / kSamples);
  Index grown_together = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const PointCloud cloud =
        oriented_cloud(balls(2, kSamples, distance, seed, sample_shape_blue_noise));
    InitialMeshOptions one_size;
    one_size.voxel_ratio_for_bodies = 0.0;
    const InitialMeshReport without = initial_mesh_of(cloud, one_size).report;
    const InitialMesh mesh = initial_mesh_of(cloud);
    expect_closed_manifold(mesh.mesh, 2, 0);
    EXPECT_EQ(mesh.report.bodies_parted, 2 - without.components);
    if (without.components == 1) {
      EXPECT_GT(without.grown_together, 0.0);
    }
    grown_together += without.components == 1;
  }
  EXPECT_GE(grown_together, 5) << "the cases are too easy";
}

// Of so few samples each that voxels are of detail size from the start.
TEST(InitialMesh, VoxelsBecomeSmallerAsLongAsThatPartsBodies) {
  struct Crowd {
    Index samples;
    double gap;  // x spacing
    Index least_bodies;
  };
  double smallest = 1.0;
  // Of the first, 97 bodies come out in one step, and 94 if no sample may lose the solid behind it;
  // of the second, 50 if planes count as much beside their samples as across.
  for (const Crowd& crowd : {Crowd{34, 2.0, 103}, Crowd{20, 3.5, 82}}) {
    const double distance = 2.0 + crowd.gap * std::sqrt(4.0 * kPi / crowd.samples);
    Index bodies = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const InitialMesh mesh =
          initial_mesh_of(oriented_cloud(balls(27, crowd.samples, distance, seed, sample_shape)));
      bodies += mesh.report.components;
      smallest = std::min(smallest, mesh.report.voxel_size / InitialMeshOptions().voxel_size);
    }
    EXPECT_GE(bodies, crowd.least_bodies) << "of " << 6 * 27;
  }
  EXPECT_LT(smallest, 0.7 * 0.7 * 0.75) << "detail size is one step: the cases are too easy";
}

TEST(InitialMesh, VoxelsAreSmallerWhereSamplesAreFewForTheShape) {
  // Walls of 0.08: one spacing.
  Index false_handles = 0, of_large_voxels = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const PointCloud cloud =
        cloud_with_askew_normals(sample_shape(ShapeKind::thin_plate, 700, seed), 3);
    const InitialMesh mesh = initial_mesh_of(cloud),
                      large = initial_mesh_of(cloud, without_detail());
    EXPECT_GT(mesh.report.sharp, InitialMeshOptions().least_sharp);
    EXPECT_TRUE(mesh.report.is_of_detail_size);
    EXPECT_LE(mesh.report.voxel_size, 0.7001 * InitialMeshOptions().voxel_size);
    EXPECT_EQ(mesh.report.genus, 0);
    EXPECT_FALSE(large.report.is_of_detail_size);
    false_handles += mesh.report.false_handles;
    of_large_voxels += large.report.false_handles;
  }
  EXPECT_GE(of_large_voxels, 15) << "there is little to do better: this test tests little";
  EXPECT_LE(2 * false_handles, of_large_voxels);
}

TEST(InitialMesh, VoxelsAreNoSmallerWhereSamplesAreMany) {
  const PointCloud cloud = oriented_cloud(sample_shape(ShapeKind::blob, 8000, 4));
  const InitialMesh mesh = initial_mesh_of(cloud);
  EXPECT_FALSE(mesh.report.is_of_detail_size);
  EXPECT_EQ(mesh.report.grown_together, 0.0);
  EXPECT_LE(mesh.report.sharp, InitialMeshOptions().least_sharp);
  expect_same_mesh(mesh.mesh, initial_mesh_of(cloud, without_detail()).mesh);
}

// Whose gaps are to be bridged.
TEST(InitialMesh, VoxelsOfSheetsAreNoSmaller) {
  PointCloud cloud = oriented_cloud(sample_shape(ShapeKind::thin_plate, 1000, 1));
  cloud.closedness = 0.4;
  const InitialMesh mesh = initial_mesh_of(cloud);
  EXPECT_GT(mesh.report.sharp, InitialMeshOptions().least_sharp);
  EXPECT_FALSE(mesh.report.is_of_detail_size);
}

TEST(InitialMesh, LargerVoxelsRefuteHandlesOfSmaller) {
  Index refuted = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const PointCloud cloud =
        cloud_with_askew_normals(sample_shape(ShapeKind::thin_plate, 800, seed), 2);
    const InitialMesh mesh = initial_mesh_of(cloud);
    EXPECT_EQ(mesh.report.genus, 0);
    if (mesh.report.is_of_detail_size) continue;
    EXPECT_GT(mesh.report.handles_refuted, 0);
    expect_same_mesh(mesh.mesh, initial_mesh_of(cloud, without_detail()).mesh);
    ++refuted;
  }
  EXPECT_GT(refuted, 0) << "this test tests nothing";
}

// A plate with nine holes, two and a quarter spacings wide and three deep: voxels of the usual size
// fill some.
TEST(InitialMesh, LargerVoxelsRefuteNoHolesThatAreClear) {
  constexpr Index kSamples = 3000, kHoles = 9;
  const double spacing = std::sqrt(2.0 * 1.8 * 1.8 / kSamples);
  const auto plate = [&](const Vec3& p) {
    double nearest = INFINITY;
    for (const double x : {-0.55, 0.0, 0.55})
      for (const double y : {-0.55, 0.0, 0.55})
        nearest = std::min(nearest, std::hypot(p.x() - x, p.y() - y));
    return std::max(box_distance(p, {0.9, 0.9, 1.5 * spacing}), 1.125 * spacing - nearest);
  };
  Index found = 0, of_large_voxels = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    const PointCloud cloud =
        oriented_cloud(sample_implicit_blue_noise(plate, {1.4, nullptr}, kSamples, random).points);
    const InitialMesh mesh = initial_mesh_of(cloud);
    expect_closed_manifold(mesh.mesh, 1, mesh.report.genus);
    found += mesh.report.genus;
    of_large_voxels += initial_mesh_of(cloud, without_detail()).report.genus;
  }
  EXPECT_LE(of_large_voxels, 4 * kHoles) << "little is refuted: this test tests little";
  EXPECT_GE(found, 5 * kHoles) << "of " << 6 * kHoles;
}

// Two hollow balls, one in the other: large voxels join their walls all over, and where the walls
// are joined there are pockets, more cavities than the two that smaller voxels show.
TEST(InitialMesh, PocketsBetweenWallsAreNoReasonToKeepHandles) {
  const double spacing = 0.044;
  std::vector<Vec3> points;
  for (const double radius : {1.0, 1.0 - 2.5 * spacing, 1.0 - 5.75 * spacing, 1.0 - 8.25 * spacing})
    for (const Vec3& p : spiral_sphere(radius, spacing)) points.push_back(p);
  const PointCloud cloud = oriented_cloud(points);
  InitialMeshOptions options;
  options.second_voxel_ratio = 0.0;
  const InitialMeshReport first = initial_mesh_of(cloud, options).report;
  const InitialMeshReport report = initial_mesh_of(cloud).report;
  EXPECT_GT(first.genus, 0) << "there is nothing to refute: this test tests nothing";
  EXPECT_GT(first.cavities, 2);
  EXPECT_EQ(report.genus, 0);
  EXPECT_EQ(report.components, 2);
  EXPECT_EQ(report.cavities, 2);
}

}  // namespace
}  // namespace shrinkwrap::testing
