// Handles cut to keep to a genus that the user imposes, and handles that a second voxel size
// refutes.
#include "initial_mesh/genus_limit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "expect_mesh.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::sample_shape;
using testing::ShapeKind;

TEST(GenusLimit, CutsAHandleWhereItIsThinnest) {
  SurfaceMesh torus = testing::torus_mesh(48, 16);
  Progress silent;
  EXPECT_EQ(genus_of(torus, silent), 1);
  const GenusLimitReport report = limit_genus(torus, 0, silent);
  EXPECT_EQ(report.cut, 1);
  EXPECT_EQ(report.rounds, 1);
  EXPECT_TRUE(torus.is_consistent());
  EXPECT_EQ(genus_of(torus, silent), 0);
  // Around the tube there are 16 edges: as many vertices twice, and two more in the middle.
  EXPECT_EQ(torus.vertex_count(), 48 * 16 + 16 + 2);
}

TEST(GenusLimit, LeavesWhatIsWithinIt) {
  SurfaceMesh torus = testing::torus_mesh(12, 6);
  const std::vector<Triangle> before = torus.triangles();
  Progress silent;
  EXPECT_EQ(limit_genus(torus, 1, silent).cut, 0);
  EXPECT_EQ(torus.triangles(), before);
}

// A plate with `holes` times `holes` square holes, of cubes without the sides between them; each
// side of a cube is `steps` edges wide.
SurfaceMesh perforated_plate(int holes, int steps) {
  const int cells = 2 * holes + 1, lines = cells * steps + 1;
  const auto is_solid = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < cells && j < cells && (i % 2 == 0 || j % 2 == 0);
  };
  std::map<std::array<int, 3>, Index> index;
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] = index.emplace(at, static_cast<Index>(positions.size()));
    if (is_new) positions.emplace_back(Vec3(at[0], at[1], at[2]) / lines);
    return entry->second;
  };
  // The square with a corner at `origin` and these sides, counter-clockwise from outside.
  const auto add_side = [&](const std::array<int, 3>& origin, const std::array<int, 3>& u,
                            const std::array<int, 3>& v) {
    const auto at = [&](int a, int b) {
      return vertex({origin[0] + a * u[0] + b * v[0], origin[1] + a * u[1] + b * v[1],
                     origin[2] + a * u[2] + b * v[2]});
    };
    for (int a = 0; a < steps; ++a)
      for (int b = 0; b < steps; ++b) {
        triangles.push_back({at(a, b), at(a + 1, b), at(a + 1, b + 1)});
        triangles.push_back({at(a, b), at(a + 1, b + 1), at(a, b + 1)});
      }
  };
  const int s = steps;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      if (!is_solid(i, j)) continue;
      const int x = i * s, y = j * s;
      add_side({x, y, s}, {1, 0, 0}, {0, 1, 0});
      add_side({x, y, 0}, {0, 1, 0}, {1, 0, 0});
      if (!is_solid(i - 1, j)) add_side({x, y, 0}, {0, 0, 1}, {0, 1, 0});
      if (!is_solid(i + 1, j)) add_side({x + s, y, 0}, {0, 1, 0}, {0, 0, 1});
      if (!is_solid(i, j - 1)) add_side({x, y, 0}, {1, 0, 0}, {0, 0, 1});
      if (!is_solid(i, j + 1)) add_side({x, y + s, 0}, {0, 0, 1}, {1, 0, 0});
    }
  return SurfaceMesh::from_triangles(std::move(positions), triangles);
}

TEST(GenusLimit, CutsManyHandlesInFewRounds) {
  constexpr int kHoles = 20;
  for (const Index maximum : {0, 150}) {
    SurfaceMesh plate = perforated_plate(kHoles, 3);
    const Index before = plate.vertex_count();
    Progress silent;
    ASSERT_EQ(genus_of(plate, silent), kHoles * kHoles);
    const GenusLimitReport report = limit_genus(plate, maximum, silent);
    EXPECT_EQ(report.cut, kHoles * kHoles - maximum);
    EXPECT_TRUE(plate.is_consistent());
    testing::expect_closed_manifold(plate, 1, maximum);
    // One by one they would take some hundred times as many.
    EXPECT_LE(report.rounds, 6);
    EXPECT_LE(report.searches, 30);
    // Around a bar or a hole there are twelve edges; some loops are longer once their neighbours
    // are cut.
    EXPECT_LE(plate.vertex_count() - before, 18 * report.cut);
  }
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
  ReconstructionOptions options;
  options.initial_mesh.false_handles.enabled = false;
  options.orientation.most_noise_at_creases = -1.0;  // planes at the ends lie askew
  Index refuted = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    Progress silent;
    const Reconstruction result =
        reconstruct(testing::sample_cut_ring(8000, 2.5, seed), options, silent);
    EXPECT_EQ(result.report.genus, 0) << "seed " << seed;
    refuted += result.initial_mesh.handles_refuted;
  }
  EXPECT_GT(refuted, 0) << "the first voxel size bridged no gap: this test tests nothing";
}

}  // namespace
}  // namespace shrinkwrap
