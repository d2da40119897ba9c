// Folds made in smooth meshes, and removed.
#include "edge_optimisation/fold_removal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "edge_optimisation/intersection_repair.h"
#include "expect_mesh.h"
#include "geometry/triangle_geometry.h"
#include "meeting_pairs.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_pairs;
using testing::expect_closed_manifold;
using testing::icosphere;
using testing::Random;
using testing::torus_mesh;

constexpr std::int64_t kManyTests = 100000000;

FoldReport remove(SurfaceMesh& mesh, const FoldOptions& options = {},
                  const std::vector<Index>& fixed = {}) {
  Progress progress;
  FaceMeetings meetings(mesh, kManyTests, progress);
  HingeFlips hinges(mesh, meetings, fixed);
  const FoldReport report = remove_folds(hinges, options, progress);
  EXPECT_EQ(meetings.pair_count(), count_pairs(mesh)) << "what is known of the pairs is right";
  return report;
}

FoldOptions only_flips() {
  FoldOptions options;
  options.annealing.moves_per_face = 0;
  return options;
}

std::size_t count_folded(const SurfaceMesh& mesh) {
  Progress progress;
  return folded_faces(mesh, {}, progress).size();
}

double least_height(const SurfaceMesh& mesh) {
  double least = 1.0;
  for (const Triangle& t : mesh.triangles())
    least = std::min(
        least, relative_height(mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]]));
  return least;
}

// A sphere of which vertices were pushed out of their rings, each over the face beyond an edge.
SurfaceMesh sphere_with_overturned_vertices(int count, unsigned seed) {
  Random random(seed);
  SurfaceMesh mesh = icosphere(4);
  for (int i = 0; i < count; ++i) {
    const Index v = random.below(mesh.vertex_slots());
    const Index beyond = mesh.twin(SurfaceMesh::next(mesh.outgoing(v)));
    Vec3 centroid = Vec3::Zero();
    for (const Index corner : mesh.triangle(SurfaceMesh::face(beyond)))
      centroid += mesh.position[corner] / 3.0;
    mesh.position[v] = centroid * 1.001;
  }
  return mesh;
}

// A flat lens with a sharp rim: a circle, a ring and an apex on either side.
constexpr Index kRim = 64;
SurfaceMesh blade() {
  std::vector<Vec3> position;
  const auto add_circle = [&](double radius, double z) {
    for (Index i = 0; i < kRim; ++i) {
      const double angle = 2.0 * kPi * i / kRim;
      position.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  };
  add_circle(1.0, 0.0);
  std::vector<Triangle> triangles;
  for (const double side : {1.0, -1.0}) {
    const Index ring = static_cast<Index>(position.size()), apex = ring + kRim;
    add_circle(0.9, side * 0.02);
    position.emplace_back(0.0, 0.0, side * 0.1);
    for (Index i = 0; i < kRim; ++i) {
      const Index j = (i + 1) % kRim;
      for (Triangle t : {Triangle{i, j, ring + j}, Triangle{i, ring + j, ring + i},
                         Triangle{ring + i, ring + j, apex}}) {
        if (side < 0.0) std::swap(t[0], t[1]);
        triangles.push_back(t);
      }
    }
  }
  return SurfaceMesh::from_triangles(std::move(position), triangles);
}

// A mesh on which the positions of neighbours were exchanged.
SurfaceMesh with_exchanged_vertices(SurfaceMesh mesh, int count, unsigned seed) {
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const Index h = random.below(mesh.halfedge_slots());
    std::swap(mesh.position[mesh.origin(h)], mesh.position[mesh.target(h)]);
  }
  return mesh;
}
SurfaceMesh sphere_with_exchanged_vertices(int count, unsigned seed) {
  return with_exchanged_vertices(icosphere(4), count, seed);
}

TEST(FoldRemoval, FoldsAreEdgesBentByMoreThanTheAngle) {
  // A roof over a square, the ridge bent by as much as the slope says.
  const auto roof = [](double height) {
    return SurfaceMesh::from_triangles(
        {{0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -0.5, height}, {0, 0.5, height}},
        {{0, 4, 3}, {0, 1, 4}, {4, 1, 5}, {4, 5, 3}, {1, 2, 5}, {5, 2, 3}, {0, 2, 1}, {0, 3, 2}});
  };
  FoldOptions only_ridge;
  Progress progress;
  // 2 atan(height) between the two faces at the ridge, and 180 degrees less atan(height) or so
  // along the eaves.
  only_ridge.angle = 150.0 * kPi / 180.0;
  EXPECT_TRUE(folded_faces(roof(2.0), only_ridge, progress).empty());
  EXPECT_EQ(folded_faces(roof(5.0), only_ridge, progress), (std::vector<Index>{2, 3}));
  EXPECT_EQ(folded_faces(icosphere(2), {}, progress), std::vector<Index>());
}

TEST(FoldRemoval, FlipsUnfold) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SurfaceMesh mesh = sphere_with_overturned_vertices(4, seed);
    const SurfaceMesh before = mesh;
    const Index pairs = count_pairs(mesh);
    const FoldReport report = remove(mesh, only_flips());
    EXPECT_EQ(report.faces_before, static_cast<Index>(count_folded(before)));
    EXPECT_GT(report.faces_before, 4);
    EXPECT_EQ(report.faces_after, 0);
    EXPECT_EQ(count_folded(mesh), 0u);
    EXPECT_GT(report.flips, 0);
    EXPECT_EQ(report.annealed, 0);
    EXPECT_LE(count_pairs(mesh), pairs);
    EXPECT_EQ(mesh.position, before.position);
    expect_closed_manifold(mesh, 1, 0);
  }
}

TEST(FoldRemoval, AnnealsWhatNoFlipUnfolds) {
  Index left_by_flips = 0, left = 0, annealed = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SurfaceMesh flipped = sphere_with_exchanged_vertices(4, seed), mesh = flipped;
    left_by_flips += remove(flipped, only_flips()).faces_after;
    const Index pairs = count_pairs(mesh);
    const FoldReport report = remove(mesh);
    left += report.faces_after;
    annealed += report.annealed;
    EXPECT_LE(count_pairs(mesh), pairs);
    expect_closed_manifold(mesh, 1, 0);
  }
  EXPECT_GT(left_by_flips, 20);
  EXPECT_LT(left, left_by_flips / 10);
  EXPECT_GT(annealed, 5);
}

TEST(FoldRemoval, MakesSliversOnlyAtLast) {
  int with_slivers = 0;
  for (unsigned seed = 0; seed < 16; ++seed) {
    // Rows of vertices that are nearly in line: where they fold, most flips make slivers.
    SurfaceMesh mesh = with_exchanged_vertices(torus_mesh(200, 66), 4, seed);
    ASSERT_GT(least_height(mesh), 0.01);
    remove(mesh);
    with_slivers += least_height(mesh) < 0.01;
  }
  EXPECT_LT(with_slivers, 6);  // 8 if they may come first
}

TEST(FoldRemoval, LeavesTheRimOfABlade) {
  SurfaceMesh mesh = blade();
  const std::vector<Triangle> before = mesh.triangles();
  FoldOptions options;
  options.most_folded = 1.0;
  const FoldReport report = remove(mesh, options);
  EXPECT_EQ(report.faces_before, 2 * kRim);
  EXPECT_EQ(report.faces_after, 2 * kRim);
  EXPECT_EQ(mesh.triangles(), before);
}

TEST(FoldRemoval, WhereManyFacesAreFoldedNothingIsDone) {
  SurfaceMesh mesh = sphere_with_overturned_vertices(40, 1);
  const std::vector<Triangle> before = mesh.triangles();
  const FoldReport report = remove(mesh);
  EXPECT_GT(report.faces_before, mesh.face_count() / 100);
  EXPECT_EQ(report.faces_after, report.faces_before);
  EXPECT_EQ(report.flips, 0);
  EXPECT_EQ(mesh.triangles(), before);
  FoldOptions options;
  options.most_folded = 0.5;
  EXPECT_LT(remove(mesh, options).faces_after, report.faces_before / 4);
}

TEST(FoldRemoval, FixedFacesStay) {
  SurfaceMesh mesh = sphere_with_overturned_vertices(4, 2);
  const SurfaceMesh before = mesh;
  Progress progress;
  const std::vector<Index> folded = folded_faces(mesh, {}, progress);
  const std::vector<Index> fixed(folded.begin(), folded.begin() + 3);
  const std::vector<Index> others = folded_faces(mesh, {}, progress, fixed);
  EXPECT_LE(others.size() + fixed.size(), folded.size());
  for (const Index f : fixed) EXPECT_FALSE(std::binary_search(others.begin(), others.end(), f));
  remove(mesh, {}, fixed);
  for (const Index f : fixed) EXPECT_EQ(mesh.triangle(f), before.triangle(f));
  EXPECT_NE(mesh.triangles(), before.triangles());
}

TEST(FoldRemoval, RemovedFacesDoNotMatter) {
  SurfaceMesh mesh = sphere_with_overturned_vertices(4, 6);
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_removed_face(SurfaceMesh::face(h)) && mesh.is_collapse_legal(h)) mesh.collapse(h);
  }
  ASSERT_LT(mesh.face_count(), mesh.face_slots());
  Progress progress;
  for (const Index f : folded_faces(mesh, {}, progress)) EXPECT_FALSE(mesh.is_removed_face(f));
  EXPECT_GT(count_folded(mesh), 0u);
  remove(mesh);
  EXPECT_EQ(count_folded(mesh), 0u);
  EXPECT_TRUE(mesh.is_consistent());
}

TEST(FoldRemoval, SameEveryTime) {
  SurfaceMesh first = sphere_with_exchanged_vertices(4, 3), second = first;
  remove(first);
  remove(second);
  EXPECT_EQ(first.triangles(), second.triangles());
}

TEST(FoldRemoval, IsPartOfTheRepair) {
  SurfaceMesh mesh = sphere_with_overturned_vertices(4, 4);
  Progress progress;
  const RepairReport report = repair_self_intersections(mesh, {}, progress);
  EXPECT_EQ(report.folds.faces_after, 0);
  EXPECT_EQ(count_folded(mesh), 0u);
  EXPECT_EQ(report.after, count_pairs(mesh));
}

TEST(FoldRemoval, IsDoneWhereNoFacesMeet) {
  // A vertex that lies above the face beyond the edge that it was pushed over.
  SurfaceMesh mesh = icosphere(4);
  const Index v = 700, beyond = mesh.twin(SurfaceMesh::next(mesh.outgoing(v)));
  const Index across = mesh.opposite(beyond);
  mesh.position[v] += 1.1 * (mesh.position[across] - mesh.position[v]);
  mesh.position[v] *= 1.05;
  ASSERT_GT(count_folded(mesh), 0u);
  ASSERT_EQ(count_pairs(mesh), 0);
  Progress progress;
  const RepairReport report = repair_self_intersections(mesh, {}, progress);
  EXPECT_EQ(report.folds.faces_after, 0);
  EXPECT_EQ(count_folded(mesh), 0u);
}

TEST(FoldRemoval, CanBeCancelled) {
  SurfaceMesh mesh = sphere_with_exchanged_vertices(4, 5);
  Progress silent;
  FaceMeetings meetings(mesh, kManyTests, silent);
  const std::vector<Index> none;
  HingeFlips hinges(mesh, meetings, none);
  Progress progress([](double, const char*) { return false; }, {Stage::edge_optimisation});
  EXPECT_THROW(progress.begin(Stage::edge_optimisation), Cancelled);
  EXPECT_THROW(remove_folds(hinges, {}, progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
