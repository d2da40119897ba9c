#include "complete_matching/draw_in.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meeting_pairs.h"

namespace shrinkwrap {
namespace {

using testing::count_meeting_faces;

constexpr Index kWidth = 12;
constexpr double kDepth = 40.0;

// A sheet with a dent in the middle, closed by faces to one vertex far below it, the last.
CompleteMatching sheet_with_dent(double dent) {
  const auto at = [](Index x, Index y) { return y * kWidth + x; };
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  const double middle = 0.5 * (kWidth - 1);
  for (Index y = 0; y < kWidth; ++y)
    for (Index x = 0; x < kWidth; ++x) {
      const double from_middle = std::hypot(x - middle, y - middle);
      positions.emplace_back(x, y, -dent * std::exp(-0.3 * from_middle * from_middle));
    }
  for (Index y = 0; y + 1 < kWidth; ++y)
    for (Index x = 0; x + 1 < kWidth; ++x) {
      triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  CompleteMatching matching;
  const auto apex = static_cast<Index>(positions.size());
  positions.emplace_back(middle, middle, -kDepth);
  const auto close = [&](Index from, Index to) {
    matching.spanning_faces.push_back(static_cast<Index>(triangles.size()));
    triangles.push_back({to, from, apex});
  };
  for (Index i = 0; i + 1 < kWidth; ++i) {
    close(at(i, 0), at(i + 1, 0));
    close(at(kWidth - 1, i), at(kWidth - 1, i + 1));
    close(at(i + 1, kWidth - 1), at(i, kWidth - 1));
    close(at(0, i + 1), at(0, i));
  }
  matching.mesh = SurfaceMesh::from_triangles(std::move(positions), triangles);
  return matching;
}

Index draw_in(CompleteMatching& matching, const DrawingInOptions& options = {}) {
  Progress silent;
  return draw_in_extra_vertices(matching, kWidth * kWidth, Frame(), HostScalar::single_precision,
                                options, silent);
}

TEST(DrawIn, AVertexComesAsNearAsItCuts) {
  for (const double dent : {0.5, 5.0}) {
    SCOPED_TRACE(dent);
    const CompleteMatching before = sheet_with_dent(dent);
    ASSERT_EQ(count_meeting_faces(before.mesh), 0);
    CompleteMatching matching = before;
    EXPECT_EQ(draw_in(matching), 1);
    const double depth = -matching.mesh.position.back().z();
    EXPECT_LT(depth, 0.2 * kDepth);
    EXPECT_GT(depth, dent);
    EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
    EXPECT_EQ(rounded_to_single(matching.mesh.position.back()), matching.mesh.position.back());
    EXPECT_EQ(matching.mesh.triangles(), before.mesh.triangles());
    for (std::size_t i = 0; i + 1 < before.mesh.position.size(); ++i)
      ASSERT_EQ(matching.mesh.position[i], before.mesh.position[i]);
  }
}

TEST(DrawIn, AStepThatCutsIsHalved) {
  CompleteMatching matching = sheet_with_dent(27.0);
  DrawingInOptions options;
  options.rounds = 1;
  EXPECT_EQ(draw_in(matching, options), 1);
  EXPECT_NEAR(-matching.mesh.position.back().z(), 0.75 * kDepth, 0.1);
  EXPECT_EQ(count_meeting_faces(matching.mesh), 0);
}

TEST(DrawIn, WhatIsToBeDroppedIsInNobodysWay) {
  // All but the outermost cells of the sheet stay open: the dent is no obstacle.
  CompleteMatching matching = sheet_with_dent(5.0);
  for (Index f = 0; f < 2 * (kWidth - 1) * (kWidth - 1); ++f) {
    const Index cell = f / 2, x = cell % (kWidth - 1), y = cell / (kWidth - 1);
    if (std::min(x, y) > 0 && std::max(x, y) < kWidth - 2) matching.opening_faces.push_back(f);
  }
  DrawingInOptions options;
  options.rounds = 20;
  EXPECT_EQ(draw_in(matching, options), 1);
  EXPECT_LT(-matching.mesh.position.back().z(), 1.0);
}

TEST(DrawIn, WhatIsToBeDroppedStaysWhereItIs) {
  CompleteMatching matching = sheet_with_dent(0.5);
  matching.opening_faces = matching.spanning_faces;
  EXPECT_EQ(draw_in(matching), 0);
  EXPECT_EQ(matching.mesh.position.back().z(), -kDepth);
}

TEST(DrawIn, NothingMovesThatDoesNotSpanOrCannotBeTested) {
  CompleteMatching of_surface = sheet_with_dent(0.5), untested = of_surface;
  of_surface.spanning_faces.pop_back();
  EXPECT_EQ(draw_in(of_surface), 0);
  EXPECT_EQ(of_surface.mesh.position.back().z(), -kDepth);
  DrawingInOptions options;
  options.max_tests = 10;
  EXPECT_EQ(draw_in(untested, options), 0);
  EXPECT_EQ(untested.mesh.position.back().z(), -kDepth);
}

}  // namespace
}  // namespace shrinkwrap
