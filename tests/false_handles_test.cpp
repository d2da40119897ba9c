// Handles that no samples bear out.
#include "initial_mesh/false_handles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "expect_mesh.h"
#include "initial_mesh/initial_mesh.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

constexpr unsigned kSeeds = 20;  // of one scene: single ones tell little

// The initial mesh of one voxel size.
InitialMesh initial_mesh_of(const PointCloud& cloud, bool is_cut = true) {
  InitialMeshOptions options;
  options.second_voxel_ratio = options.voxel_ratio_for_detail = 0.0;
  options.false_handles.enabled = is_cut;
  Progress silent;
  return make_initial_mesh(cloud, options, silent);
}

InitialMesh initial_mesh_of(const std::vector<Vec3>& points, bool is_cut = true) {
  return initial_mesh_of(oriented_cloud(points), is_cut);
}

TEST(FalseHandles, AreCutFromThinWalls) {
  // Of 0.08: one and one and a half spacings of samples at random.
  for (const Index count : {700, 1000}) {
    Index before = 0, left = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const PointCloud cloud =
          cloud_with_askew_normals(sample_shape(ShapeKind::thin_plate, count, seed), 2);
      const Index handles = initial_mesh_of(cloud, false).report.genus;
      const InitialMesh result = initial_mesh_of(cloud);
      EXPECT_EQ(result.report.false_handles, handles - result.report.genus);
      EXPECT_TRUE(result.mesh.is_consistent());
      expect_closed_manifold(result.mesh, result.report.components + result.report.cavities,
                             result.report.genus);
      before += handles;
      left += result.report.genus;
    }
    EXPECT_GE(before, 30) << "there is little to cut: this test tests little";
    EXPECT_LE(left, before / 5) << count;
  }
}

// A block of 1.2 by 1.2 by 0.6 with a slot from above, some `width` spacings wide.
std::vector<Vec3> sample_slotted_block(Index count, double width, unsigned seed) {
  const auto box = [](const Vec3& p, const Vec3& half) {
    const Vec3 q = p.cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  };
  const double half_slot = 0.5 * width * std::sqrt(6.0 / count);
  Random random(seed);
  return sample_implicit(
             [&](const Vec3& p) {
               return std::max(box(p, {0.6, 0.6, 0.3}),
                               -box(p - Vec3(0.0, 0.0, 0.15), {half_slot, 2.0, 0.3}));
             },
             {1.0, nullptr}, count, random)
      .points;
}

TEST(FalseHandles, AreCutFromANarrowGap) {
  Index before = 0, left = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const PointCloud cloud = cloud_with_askew_normals(sample_slotted_block(3000, 2.5, seed), 1);
    before += initial_mesh_of(cloud, false).report.genus;
    left += initial_mesh_of(cloud).report.genus;
  }
  EXPECT_GE(before, 20) << "there is little to cut: this test tests little";
  EXPECT_LE(left, before / 4);
}

TEST(FalseHandles, AreNoneOfTheObject) {
  for (const Index count : {600, 1000, 3000, 10000})
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {
      const InitialMesh result =
          initial_mesh_of(sample_shape(ShapeKind::double_torus, count, seed));
      EXPECT_EQ(result.report.genus, 2) << count << " samples, seed " << seed;
      EXPECT_EQ(result.report.false_handles, 0);
    }
}

// A block with four holes, some `width` spacings wide.
std::vector<Vec3> sample_bored_block(Index count, double width, unsigned seed) {
  const double radius = 0.5 * width * std::sqrt(6.0 / count);
  Random random(seed);
  return sample_implicit(
             [&](const Vec3& p) {
               const Vec3 beyond = p.cwiseAbs() - Vec3(0.6, 0.6, 0.3);
               const double across =
                   std::hypot(std::abs(p.x()) - 0.3, std::abs(p.y()) - 0.3) - radius;
               return std::max(beyond.maxCoeff(), -across);
             },
             {1.0, nullptr}, count, random)
      .points;
}

// Two rails with five rungs between them, some `width` spacings thick.
std::vector<Vec3> sample_ladder(Index count, double width, unsigned seed) {
  const double area = 2.0 * kPi * (2.0 * 0.15 * 2.4),
               radius = 0.5 * width * std::sqrt(area / count);
  Random random(seed);
  return sample_implicit(
             [&](const Vec3& p) {
               const double rail = std::max(std::hypot(std::abs(p.y()) - 0.45, p.z()) - 0.15,
                                            std::abs(p.x()) - 1.2);
               const double along = p.x() - 0.45 * std::clamp(std::round(p.x() / 0.45), -2.0, 2.0);
               return std::min(rail,
                               std::max(std::hypot(along, p.z()) - radius, std::abs(p.y()) - 0.45));
             },
             {1.4, nullptr}, count, random)
      .points;
}

TEST(FalseHandles, AreNoNarrowHolesNorThinLimbs) {
  for (const bool is_limb : {false, true}) {
    Index found = 0, left = 0;
    for (unsigned seed = 1; seed <= 2 * kSeeds; ++seed) {
      const PointCloud cloud = oriented_cloud(is_limb ? sample_ladder(1500, 2.25, seed)
                                                      : sample_bored_block(3000, 2.25, seed));
      found += initial_mesh_of(cloud, false).report.genus;
      left += initial_mesh_of(cloud).report.genus;
    }
    EXPECT_GE(found, 120) << "few are found: this test tests little";
    EXPECT_GE(left, is_limb ? 4 * found / 7 : 7 * found / 8) << "of " << found;
  }
}

// How many handles there are, and how many are left.
struct Doubt {
  Index found = 0, left = 0;
};
Doubt without_doubtful(const std::function<std::vector<Vec3>(unsigned seed)>& sample) {
  Doubt doubt;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const PointCloud cloud = oriented_cloud(sample(seed));
    InitialMesh mesh = initial_mesh_of(cloud, false);
    Progress silent;
    const SurfaceMesh before = mesh.mesh;
    EXPECT_EQ(cut_doubtful_handles(mesh.mesh, before, cloud, {}, mesh.report.genus, silent), 0)
        << "what both show stays";
    const Index cut =
        cut_doubtful_handles(mesh.mesh, icosphere(2), cloud, {}, mesh.report.genus, silent);
    EXPECT_TRUE(mesh.mesh.is_consistent());
    expect_closed_manifold(mesh.mesh, mesh.report.components + mesh.report.cavities,
                           mesh.report.genus - cut);
    doubt.found += mesh.report.genus;
    doubt.left += mesh.report.genus - cut;
  }
  return doubt;
}

TEST(FalseHandles, OfThoseInDoubtHolesStayThatSamplesShow) {
  const Doubt holes =
      without_doubtful([](unsigned seed) { return sample_bored_block(3000, 2.25, seed); });
  EXPECT_GE(holes.found, 60);
  EXPECT_GE(holes.left, 3 * holes.found / 4) << "of " << holes.found;
  // Rungs may as well be bridges.
  const Doubt limbs =
      without_doubtful([](unsigned seed) { return sample_ladder(1500, 2.25, seed); });
  EXPECT_GE(limbs.found, 40);
  EXPECT_LE(limbs.left, limbs.found / 4) << "of " << limbs.found;
  const Doubt bridges =
      without_doubtful([](unsigned seed) { return sample_slotted_block(3000, 2.25, seed); });
  EXPECT_GE(bridges.found, 20);
  EXPECT_LE(bridges.left, bridges.found / 10) << "of " << bridges.found;
}

// Two balls so close that voxels join them: to cut there would part the surface.
TEST(FalseHandles, CutsPartNothing) {
  const auto balls = [](const Vec3& p) {
    const Vec3 centre(0.452, 0.0, 0.0);
    return std::min((p - centre).norm(), (p + centre).norm()) - 0.45;
  };
  Random random(1);
  const auto samples = sample_implicit(balls, {}, 1000, random);
  InitialMesh result = initial_mesh_of(samples.points);
  ASSERT_EQ(result.report.components, 1) << "nothing is joined: this test tests nothing";
  FalseHandleOptions options;
  options.least_cosine = 1.0;
  options.widest_gap = 0.0;
  Progress silent;
  const std::vector<Triangle> before = result.mesh.triangles();
  const FalseHandleReport cut =
      cut_false_handles(result.mesh, oriented_cloud(samples.points), options, silent);
  EXPECT_EQ(cut.handles, 0);
  EXPECT_EQ(cut.mouths, 0);
  EXPECT_EQ(result.mesh.triangles(), before);
}

// A ball with a hollow so near to its outside that there is a hole in the wall of the solid.
TEST(FalseHandles, MouthsOfCavitiesAreClosed) {
  const auto hollow = [](const Vec3& p) {
    return std::max(p.norm() - 0.9, 0.45 - (p - Vec3(0.37, 0.0, 0.0)).norm());
  };
  Index joined = 0, parted = 0;
  for (unsigned seed = 1; seed <= 4 * kSeeds; ++seed) {  // less than half have one
    Random random(seed);
    const PointCloud cloud =
        cloud_with_askew_normals(sample_implicit(hollow, {}, 1000, random).points, 1);
    const InitialMeshReport without = initial_mesh_of(cloud, false).report;
    if (without.genus > 0 || without.cavities > 0) continue;
    ++joined;
    const InitialMesh with = initial_mesh_of(cloud);
    EXPECT_TRUE(with.mesh.is_consistent());
    expect_closed_manifold(with.mesh, 1 + with.report.false_mouths, 0);
    EXPECT_EQ(with.report.components, 1);
    EXPECT_EQ(with.report.cavities, with.report.false_mouths);
    parted += with.report.false_mouths;
  }
  EXPECT_GE(joined, 5) << "there is little to cut: this test tests little";
  EXPECT_GE(10 * parted, 7 * joined);
}

// Two balls with a rod of two spacings between them, a hollow ball with a channel of three, and one
// in which a ball hangs by such a rod.
TEST(FalseHandles, NecksAndTrueMouthsStay) {
  const auto dumbbell = [](const Vec3& p) {
    const Vec3 centre(0.55, 0.0, 0.0);
    const double rod = std::max(std::hypot(p.y(), p.z()) - 0.07, std::abs(p.x()) - 0.55);
    return std::min({(p - centre).norm() - 0.4, (p + centre).norm() - 0.4, rod});
  };
  const auto bottle = [](const Vec3& p) {
    const double channel = std::max(std::hypot(p.y(), p.z()) - 0.13, -p.x());
    return std::max(p.norm() - 0.9, -std::min(p.norm() - 0.6, channel));
  };
  const auto clapper = [](const Vec3& p) {
    const double rod = std::max(std::hypot(p.y(), p.z()) - 0.07, std::abs(p.x() - 0.4) - 0.4);
    const double hollow = std::max(p.norm() - 0.97, 0.7 - p.norm());
    return std::min({hollow, p.norm() - 0.35, rod});
  };
  Index whole = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    std::vector<std::vector<Vec3>> clouds = {sample_implicit(dumbbell, {}, 1000, random).points,
                                             sample_implicit(bottle, {}, 2000, random).points};
    if (seed <= kSeeds / 4) clouds.push_back(sample_implicit(clapper, {}, 4500, random).points);
    for (const auto& points : clouds) {
      const InitialMeshReport report = initial_mesh_of(points).report;
      const InitialMeshReport without = initial_mesh_of(points, false).report;
      EXPECT_EQ(report.false_mouths, 0) << seed;
      EXPECT_EQ(report.components, without.components) << seed;
      EXPECT_EQ(report.cavities, without.cavities) << seed;
      whole += report.components == 1 && report.cavities == 0;
    }
  }
  EXPECT_GE(whole, 30);
}

// Four houses of some width on flat ground, 2 by 2, as a scanner far away sees them in this
// direction.
std::vector<Vec3> sample_houses(const Vec3& direction, double half_width, double height,
                                double spacing) {
  const auto is_in_house = [&](const Vec3& p) {
    const double beside =
        std::max(std::abs(std::abs(p.x()) - 0.4), std::abs(std::abs(p.y()) - 0.4));
    return beside < half_width - 1e-6 && p.z() > 0.0 && p.z() < height - 1e-6;
  };
  std::vector<Vec3> points;
  const auto add_if_seen = [&](const Vec3& p) {
    for (double way = 0.005; way * direction.z() < height; way += 0.005)
      if (is_in_house(p + way * direction)) return;
    points.push_back(p);
  };
  for (double x = -1.0; x < 1.0; x += spacing)
    for (double y = -1.0; y < 1.0; y += spacing)
      add_if_seen({x, y, is_in_house({x, y, 0.5 * height}) ? height : 0.0});
  for (double z = 0.5 * spacing; z < height; z += spacing)
    for (double along = -half_width; along < half_width; along += spacing)
      for (const double side : {-1.0, 1.0})
        for (const double x : {-0.4, 0.4})
          for (const double y : {-0.4, 0.4}) {
            add_if_seen({x + side * half_width, y + along, z});
            add_if_seen({x + along, y + side * half_width, z});
          }
  return points;
}

// Of the default voxels, where what lies in shadow is told from holes or is not.
InitialMeshReport report_of_sheet(const PointCloud& cloud, bool has_shadows) {
  InitialMeshOptions options;
  if (!has_shadows) options.level_ratio_for_shadows = 0.0;
  Progress silent;
  const InitialMesh mesh = make_initial_mesh(cloud, options, silent);
  expect_closed_manifold(mesh.mesh, mesh.report.components + mesh.report.cavities,
                         mesh.report.genus);
  return mesh.report;
}

TEST(FalseHandles, ShadowsOfHousesAreNoTunnels) {
  Index before = 0, left = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    const double elevation = random.uniform(25.0, 70.0) * kPi / 180.0;
    const double azimuth = random.uniform(0.0, 2.0 * kPi);
    const double half_width = random.uniform(0.12, 0.25), height = random.uniform(0.15, 0.4);
    const double spacing = random.uniform(0.015, 0.04);
    const Vec3 direction(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    std::vector<Vec3> points = sample_houses(direction, half_width, height, spacing);
    const Eigen::AngleAxisd turn(random.uniform(0.0, kPi), random.direction());
    for (Vec3& p : points) p = turn * p;
    const PointCloud cloud = oriented_cloud(points);
    const InitialMeshReport without = report_of_sheet(cloud, false);
    const InitialMeshReport report = report_of_sheet(cloud, true);
    EXPECT_LE(report.genus, without.genus) << seed;
    EXPECT_EQ(report.handles_refuted - without.handles_refuted, without.genus - report.genus)
        << seed;
    EXPECT_EQ(report.components, 1) << seed;
    before += without.genus;
    left += report.genus;
  }
  EXPECT_GE(before, 15) << "there is little to refute: this test tests little";
  EXPECT_LE(left, before / 2);
}

// A ring, of radius 1, as a scanner far away sees it from so many degrees above its plane.
std::vector<Vec3> sample_ring(double elevation, double tube) {
  const Vec3 direction(std::cos(elevation * kPi / 180.0), 0.0, std::sin(elevation * kPi / 180.0));
  const auto ring = [&](const Vec3& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z()) - tube;
  };
  const auto is_seen = [&](const Vec3& p) {
    for (double way = 0.02; way < 3.0; way += 0.01)
      if (ring(p + way * direction) < -1e-3) return false;
    return true;
  };
  Random random(1);
  return sample_implicit_blue_noise(ring, {1.5, is_seen}, 3000, random).points;
}

TEST(FalseHandles, AHoleSeenFromOneSideIsNoShadow) {
  for (const double elevation : {90.0, 60.0, 45.0})
    for (const double tube : {0.15, 0.3, 0.45}) {
      const PointCloud cloud = oriented_cloud(sample_ring(elevation, tube));
      ASSERT_LT(cloud.closedness, 0.5) << elevation << ' ' << tube;
      EXPECT_EQ(report_of_sheet(cloud, true).genus, 1) << elevation << ' ' << tube;
    }
}

TEST(FalseHandles, NoMoreHandlesGoThanThereAreTunnels) {
  // The level that spans the shadows spans the hole of the ring, too.
  std::vector<Vec3> points = sample_houses(Vec3(0.78, 0.38, 0.5).normalized(), 0.2, 0.25, 0.03);
  const Index tunnels = report_of_sheet(oriented_cloud(points), false).genus;
  ASSERT_GT(tunnels, 0);
  EXPECT_EQ(report_of_sheet(oriented_cloud(points), true).genus, 0);
  for (const Vec3& p : sample_ring(90.0, 0.45)) points.push_back(p + Vec3(4.0, 0.0, 0.0));
  const PointCloud cloud = oriented_cloud(points);
  EXPECT_EQ(report_of_sheet(cloud, false).genus, tunnels + 1);
  EXPECT_GT(report_of_sheet(cloud, true).genus, 0);
}

}  // namespace
}  // namespace shrinkwrap::testing
