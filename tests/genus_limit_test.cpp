// Handles cut to keep to a genus that the user imposes, and handles that a second voxel size
// refutes.
#include "genus_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "expect_mesh.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::Random;
using testing::sample_shape;
using testing::ShapeKind;

TEST(GenusLimit, CutsAHandleWhereItIsThinnest) {
  SurfaceMesh torus = testing::torus_mesh(48, 16);
  Progress silent;
  EXPECT_EQ(genus_of(torus, silent), 1);
  EXPECT_EQ(limit_genus(torus, 0, silent), 1);
  EXPECT_TRUE(torus.is_consistent());
  EXPECT_EQ(genus_of(torus, silent), 0);
  // Around the tube there are 16 edges: as many vertices twice, and two more in the middle.
  EXPECT_EQ(torus.vertex_count(), 48 * 16 + 16 + 2);
}

TEST(GenusLimit, LeavesWhatIsWithinIt) {
  SurfaceMesh torus = testing::torus_mesh(12, 6);
  const std::vector<Triangle> before = torus.triangles();
  Progress silent;
  EXPECT_EQ(limit_genus(torus, 1, silent), 0);
  EXPECT_EQ(torus.triangles(), before);
}

TEST(GenusLimit, IsImposedOnAReconstruction) {
  for (const Index maximum : {0, 1, 2}) {
    ReconstructionOptions options;
    options.initial_mesh.maximum_genus = maximum;
    Progress silent;
    const Reconstruction result =
        reconstruct(sample_shape(ShapeKind::double_torus, 6000, 3), options, silent);
    EXPECT_EQ(result.report.genus, maximum);
    EXPECT_EQ(result.initial_mesh.handles_cut, 2 - maximum);
    EXPECT_TRUE(result.report.closed() && result.report.manifold() && result.report.outward());
    EXPECT_TRUE(result.report.complete_matching() || result.report.vertices_extra > 0);
    EXPECT_EQ(result.report.samples_matched, 6000);
  }
}

// A ring that is cut open, the ends so close that one voxel size bridges the gap.
TEST(InitialMesh, RefutesHandlesAcrossANarrowGap) {
  constexpr Index kSamples = 8000;
  constexpr double kMajor = 0.7, kMinor = 0.2, kGap = 2.5;  // the gap in sample spacings
  const double area = 4.0 * 9.869604401089358 * kMajor * kMinor;
  const double half_gap = 0.5 * kGap * std::sqrt(area / kSamples);
  const auto ring = [&](const Vec3& p) {
    const double to_circle = std::sqrt(p.x() * p.x() + p.y() * p.y()) - kMajor;
    const double tube = std::sqrt(to_circle * to_circle + p.z() * p.z()) - kMinor;
    const double slot = p.x() > 0.0 ? half_gap - std::abs(p.y()) : -1.0;
    return 0.8 * std::max(tube, slot);
  };
  Index refuted = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    Random random(seed);
    const auto samples = testing::sample_implicit(ring, {}, kSamples, random);
    Progress silent;
    const Reconstruction result = reconstruct(samples.points, {}, silent);
    EXPECT_EQ(result.report.genus, 0) << "seed " << seed;
    refuted += result.initial_mesh.handles_refuted;
  }
  EXPECT_GT(refuted, 0) << "the first voxel size bridged no gap: this test tests nothing";
}

}  // namespace
}  // namespace shrinkwrap
