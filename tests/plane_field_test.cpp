#include "initial_mesh/plane_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// Samples anywhere in a cube, whose spacings span three powers of ten.
PointCloud uneven_cloud(Index count, unsigned seed) {
  Random random(seed);
  PointCloud cloud;
  cloud.spacing = 0.02;
  for (Index i = 0; i < count; ++i) {
    cloud.position.push_back(random.in_cube());
    cloud.normal.push_back(random.direction().cast<float>());
    cloud.local_spacing.push_back(
        static_cast<float>(cloud.spacing * std::pow(10.0, random.uniform(-1.0, 2.0))));
  }
  return cloud;
}

VoxelLattice lattice_for(const PointCloud& cloud) {
  VoxelLattice lattice;
  lattice.size = 1.75 * cloud.spacing;
  lattice.origin = Vec3::Constant(-1.0 - 0.5 * lattice.size);
  return lattice;
}

// In voxels, as the declarations say it.
struct Reach {
  double spacing, reach;
};
Reach reach_of(const PointCloud& cloud, Index i, const VoxelLattice& lattice,
               const PlaneFieldOptions& options) {
  const double spacing =
      std::clamp<double>(cloud.local_spacing[i], options.least_spacing * cloud.spacing,
                         16.0 * cloud.spacing) /
      lattice.size;
  return {spacing, std::max(options.reach * spacing, 1.75)};
}

TEST(PlaneField, AddsUpEverySampleThatReachesAVoxel) {
  Progress silent;
  const PointCloud cloud = uneven_cloud(500, 1);
  const VoxelLattice lattice = lattice_for(cloud);
  for (const PlaneFieldOptions& options :
       {PlaneFieldOptions{2.5, 0.5, 2.0}, PlaneFieldOptions{2.5, 1.0, 0.0}}) {
    const PlaneField field(cloud, lattice, options, silent);
    Random random(2);
    int reached = 0;
    for (int k = 0; k < 50; ++k) {
      const Voxel brick = BrickIndex::brick_of(lattice.voxel_of(1.2 * random.in_cube()));
      const BrickPlanes planes = field.planes_at(brick);
      for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
        const Vec3 centre = lattice.centre_of(BrickIndex::voxel_in(brick, offset));
        double distance_sum = 0.0, weight_sum = 0.0, nearest = 1e30;
        for (Index i = 0; i < cloud.size(); ++i) {
          const Reach of = reach_of(cloud, i, lattice, options);
          const Vec3 from = (centre - cloud.position[i]) / lattice.size;
          if (from.norm() > of.reach) continue;
          const double weight = std::pow(1.0 - from.squaredNorm() / (of.reach * of.reach), 5.0);
          weight_sum += weight;
          const double height = from.dot(cloud.normal[i].cast<double>());
          distance_sum += weight * height / of.spacing;
          const double along_squared = from.squaredNorm() - height * height;
          nearest = std::min(nearest, (height * height + (1.0 + options.sideways) * along_squared) /
                                          (of.spacing * of.spacing));
        }
        reached += weight_sum > 0.01;
        EXPECT_NEAR(planes.weight_sum[offset], weight_sum, 1e-4);
        EXPECT_NEAR(planes.distance_sum[offset], distance_sum, 1e-4);
        if (weight_sum > 1e-4) {
          EXPECT_NEAR(planes.nearest[offset], nearest, 1e-4);
        }
      }
    }
    EXPECT_GT(reached, 1000);
  }
}

TEST(PlaneField, KnowsTheBricksWithinTheBoxesOfReach) {
  Progress silent;
  const PointCloud cloud = uneven_cloud(40, 3);
  const VoxelLattice lattice = lattice_for(cloud);
  const PlaneFieldOptions options;
  std::vector<BrickKey> expected;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 reach = Vec3::Constant(reach_of(cloud, i, lattice, options).reach * lattice.size);
    const auto brick_at = [&](const Vec3& p) { return BrickIndex::brick_of(lattice.voxel_of(p)); };
    const Voxel low = brick_at(cloud.position[i] - reach),
                high = brick_at(cloud.position[i] + reach);
    for (Index z = low[2]; z <= high[2]; ++z)
      for (Index y = low[1]; y <= high[1]; ++y)
        for (Index x = low[0]; x <= high[0]; ++x) expected.push_back(key_of({x, y, z}));
  }
  parallel_sort_unique(expected);
  const PlaneField field(cloud, lattice, options, silent);
  EXPECT_EQ(field.keys_of_bricks_in_reach(silent), expected);
  for (const BrickKey key : expected) EXPECT_EQ(key_of(brick_of_key(key)), key);
}

}  // namespace
}  // namespace shrinkwrap::testing
