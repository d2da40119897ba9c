// Samples that are there several times, but for a little: found, left out, and inserted at last.
#include "samples/near_copies.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "cleaned_cloud.h"
#include "complete_matching/near_copy_insertion.h"
#include "expect_mesh.h"
#include "geometry/morton.h"
#include "mesh/self_intersection.h"
#include "reconstruct.h"
#include "samples/outliers.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::cleaned;
using testing::Random;
using testing::sample_shape;
using testing::sample_shape_blue_noise;
using testing::shape_of;
using testing::ShapeKind;

// `copies` more of each point, this far from it on average.
std::vector<Vec3> with_copies(std::vector<Vec3> points, int copies, double distance,
                              unsigned seed = 5) {
  Random random(seed);
  const std::size_t count = points.size();
  for (int copy = 0; copy < copies; ++copy)
    for (std::size_t i = 0; i < count; ++i)
      points.push_back(points[i] + distance * random.in_cube());
  return points;
}

std::vector<NearCopy> copies_of(const std::vector<Vec3>& points,
                                const NearCopyOptions& options = {}) {
  Progress silent;
  return find_near_copies(points, VoxelSearch(points, silent), options, silent);
}

TEST(NearCopies, AreThoseOfOnePlace) {
  constexpr Index kPlaces = 800;
  const std::vector<Vec3> alone = sample_shape_blue_noise(ShapeKind::sphere, kPlaces, 1);
  for (const int more : {1, 2, 7}) {
    SCOPED_TRACE(more);
    const std::vector<Vec3> points = with_copies(alone, more, 1e-4);
    const std::vector<NearCopy> copies = copies_of(points);
    EXPECT_EQ(copies.size(), static_cast<std::size_t>(more) * kPlaces);
    std::set<Index> originals, named;
    Index last = 0;
    for (const NearCopy& pair : copies) {
      EXPECT_EQ(pair.copy % kPlaces, pair.original % kPlaces) << "of another place";
      EXPECT_GE(pair.original, last);
      last = pair.original;
      originals.insert(pair.original);
      EXPECT_TRUE(named.insert(pair.copy).second) << "named twice";
    }
    EXPECT_EQ(originals.size(), kPlaces);
    for (const Index original : originals) EXPECT_EQ(named.count(original), 0u) << "both";
  }
}

TEST(NearCopies, TheOriginalIsInTheMiddle) {
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, 400, 2);
  for (std::size_t i = 0; i < 400; ++i)
    for (const double factor : {1.001, 0.999}) points.push_back(factor * points[i]);
  const std::vector<NearCopy> copies = copies_of(points);
  EXPECT_EQ(copies.size(), 800u);
  for (const NearCopy& pair : copies) EXPECT_LT(pair.original, 400);
}

TEST(NearCopies, AreNoneByChance) {
  EXPECT_TRUE(copies_of(sample_shape(ShapeKind::torus, 20000, 3)).empty());
  EXPECT_TRUE(copies_of(testing::sample_sphere_on_scan_lines(4000, 1)).empty());
  EXPECT_TRUE(copies_of(testing::sample_spiked_ball(3000, 100.0)).empty());
  // Pairs at a twentieth of the distance to the next.
  const std::vector<Vec3> even = sample_shape_blue_noise(ShapeKind::sphere, 3000, 4);
  EXPECT_TRUE(copies_of(with_copies(even, 1, 0.004)).empty());
}

TEST(NearCopies, AreNoneWhereTheyAreFew) {
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, 3000, 4);
  for (std::size_t i = 0; i < 100; ++i) points.push_back(points[20 * i] + Vec3(1e-5, 0.0, 0.0));
  EXPECT_TRUE(copies_of(points).empty());
  NearCopyOptions few;
  few.least_share = 0.01;
  EXPECT_EQ(copies_of(points, few).size(), 100u);
  few.enabled = false;
  EXPECT_TRUE(copies_of(points, few).empty());
}

// Small bodies far from each other are bodies.
TEST(NearCopies, AreNotWhatSmallBodiesConsistOf) {
  std::vector<Vec3> points;
  Random random(6);
  for (int ball = 0; ball < 60; ++ball) {
    const Vec3 centre = 100.0 * random.in_cube();
    for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, 30, 7))
      points.push_back(centre + p);
  }
  EXPECT_TRUE(copies_of(points).empty());
}

TEST(NearCopies, StayWhereTheRestIsFlat) {
  std::vector<Vec3> points;
  for (int i = 0; i < 400; ++i) points.emplace_back(i % 20, i / 20, 0.0);
  for (int i = 0; i < 400; ++i) points.emplace_back(points[i] + Vec3(0.0, 0.0, 1e-3));
  Progress silent;
  const PointCloud cloud = prepare_samples(points, {}, silent);
  EXPECT_FALSE(copies_of(points).empty());
  EXPECT_TRUE(cloud.conditioning.near_copies.empty());
  EXPECT_EQ(cloud.size(), 800);
}

struct CopiesCase {
  ShapeKind kind;
  int copies;
  double distance;
};

class NearCopiesReconstructed : public ::testing::TestWithParam<CopiesCase> {};

// Not left out, thousands of these faces meet others.
TEST_P(NearCopiesReconstructed, AreVerticesOfFacesThatDoNotMeet) {
  const auto [kind, copies, distance] = GetParam();
  const std::vector<Vec3> points =
      with_copies(sample_shape_blue_noise(kind, 2500, 8), copies, distance);
  Progress silent;
  const Reconstruction result = reconstruct(points, {}, silent);
  EXPECT_EQ(result.conditioning.near_copies.size(), static_cast<std::size_t>(copies) * 2500);
  EXPECT_EQ(result.report.samples_matched, static_cast<Index>(points.size()));
  EXPECT_EQ(result.report.vertices_extra, 0);
  EXPECT_EQ(result.report.genus, shape_of(kind).genus);
  EXPECT_EQ(result.intersection_repair.faces_after, 0);
  EXPECT_TRUE(self_intersecting_faces(result.mesh.position, result.mesh.triangles, silent).empty());
  for (std::size_t v = 0; v < points.size(); ++v) {
    ASSERT_EQ(result.mesh.input_index[v], static_cast<Index>(v));
    ASSERT_EQ(result.mesh.position[v], points[v]);
  }
  const SurfaceMesh mesh = SurfaceMesh::from_triangles(result.mesh.position, result.mesh.triangles);
  EXPECT_GT(testing::normal_consistency(mesh, shape_of(kind)), 0.99);

  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(reconstruct(points, {}, silent).mesh.triangles, result.mesh.triangles);
}

INSTANTIATE_TEST_SUITE_P(NearCopies, NearCopiesReconstructed,
                         ::testing::Values(CopiesCase{ShapeKind::torus, 1, 1e-7},
                                           CopiesCase{ShapeKind::torus, 2, 1e-5},
                                           CopiesCase{ShapeKind::blob, 4, 1e-6},
                                           CopiesCase{ShapeKind::blob, 2, 3e-4}));

TEST(NearCopies, OfTheRimOfAnOpeningAreVerticesToo) {
  const std::vector<Vec3> points =
      with_copies(sample_shape_blue_noise(ShapeKind::hemisphere, 1500, 9), 2, 1e-5);
  for (const auto openings :
       {CompleteMatchingOptions::Openings::close, CompleteMatchingOptions::Openings::leave_open}) {
    ReconstructionOptions options;
    options.complete_matching.openings = openings;
    Progress silent;
    const Reconstruction result = reconstruct(points, options, silent);
    EXPECT_EQ(result.report.samples_matched, static_cast<Index>(points.size()));
    EXPECT_EQ(result.report.border_loops,
              openings == CompleteMatchingOptions::Openings::close ? 0 : 1);
    EXPECT_EQ(result.intersection_repair.faces_after, 0);
  }
}

// Frames of a depth camera: the copies lie along the line of sight, beyond the border for the half.
TEST(NearCopies, AlongOneDirectionKeepTheBorderClean) {
  std::vector<Vec3> points;
  for (int copy = 0; copy < 6; ++copy)
    for (int x = 0; x < 40; ++x)
      for (int y = 0; y < 40; ++y)
        points.emplace_back(Vec3(x, y, 3.0 * std::sin(x / 5.0) * std::cos(y / 7.0)) +
                            2.5e-5 * copy * Vec3(1.0, 2.0, 3.0));
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  Progress silent;
  const Reconstruction result = reconstruct(points, options, silent);
  EXPECT_EQ(result.report.samples_matched, 9600);
  EXPECT_EQ(result.report.border_loops, 1);
  EXPECT_LE(result.intersection_repair.faces_after, 6);  // hundreds if none moved the border
}

TEST(NearCopies, OfStrayPointsAreStrayToo) {
  std::vector<Vec3> alone = sample_shape_blue_noise(ShapeKind::sphere, 2000, 10);
  alone.emplace_back(1.7, 0.2, 0.1);
  alone.emplace_back(-0.3, 1.9, 0.4);
  const std::vector<Vec3> points = with_copies(alone, 2, 1e-5);
  const testing::Cleaned result = cleaned(points);
  std::set<Index> places;
  for (const Index i : result.report.input_index) places.insert(i % 2002);
  EXPECT_EQ(places, (std::set<Index>{2000, 2001}));
  EXPECT_EQ(result.report.input_index.size(), 6u);
  EXPECT_TRUE(std::is_sorted(result.report.input_index.begin(), result.report.input_index.end()));
  EXPECT_EQ(result.cloud.input_indices().size(), 6000u);
}

// Copies of copies are found once: what is left when stray points have gone is not looked at again.
TEST(NearCopies, AreNotLostWithStrayPoints) {
  std::vector<Vec3> alone = sample_shape_blue_noise(ShapeKind::sphere, 600, 12);
  alone.emplace_back(2.0, 0.2, 0.1);
  const std::vector<Vec3> points = with_copies(with_copies(alone, 4, 1e-3), 3, 1e-7);
  const testing::Cleaned result = cleaned(points);
  EXPECT_FALSE(result.report.input_index.empty());
  EXPECT_FALSE(result.cloud.conditioning.near_copies.empty());
  EXPECT_EQ(result.cloud.input_indices().size() + result.report.input_index.size(), points.size());
}

// As their searches expect them.
TEST(NearCopies, LeaveTheOthersInOrder) {
  const std::vector<Vec3> points =
      with_copies(sample_shape_blue_noise(ShapeKind::sphere, 3000, 13), 3, 2e-3);
  Progress silent;
  const PointCloud cloud = prepare_samples(points, {}, silent);
  ASSERT_FALSE(cloud.conditioning.near_copies.empty());
  const std::vector<Index> order = morton_order(cloud.position, silent);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  for (Index i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(cloud.position[i], cloud.frame.to_unit(points[cloud.input_index[i]]));
}

// They are where the surface is not, which the samples have moved onto.
TEST(NearCopies, StayOutOfASurface) {
  std::vector<Vec3> alone = sample_shape_blue_noise(ShapeKind::box, 600, 1);
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  Progress silent;
  for (const std::size_t stray : {0, 1}) {
    if (stray == 1) alone.emplace_back(2.5, 2.4, 2.3);
    const std::vector<Vec3> points = with_copies(alone, 1, 1e-5);
    const Reconstruction result = reconstruct(points, options, silent);
    ASSERT_TRUE(result.surface_detail.is_kept);
    EXPECT_EQ(result.mesh.position.size(), 600u);
    EXPECT_EQ(result.outliers.input_index.size(), 2 * stray);
    // The report is on all samples, whatever became of them.
    EXPECT_EQ(result.report.samples, 1200);
  }
}

TEST(NearCopies, ThatVanishInTheUnitFrameAreNotExact) {
  std::vector<Vec3> points =
      with_copies(sample_shape_blue_noise(ShapeKind::sphere, 400, 11), 1, 1e-5);
  for (Vec3& p : points) p *= 1e10;
  points.emplace_back(0.0, 0.0, 1.1e10);
  Progress silent;
  for (const bool vanishes : {false, true}) {
    if (vanishes) points.emplace_back(1e-320, 0.0, 1.1e10);
    const PointCloud cloud = prepare_samples(points, {}, silent);
    EXPECT_EQ(cloud.conditioning.near_copies.size(), vanishes ? 401u : 400u);
    EXPECT_EQ(is_exact_in_unit_frame(cloud, points, silent), !vanishes);
  }
}

CompleteMatching tetrahedron() {
  CompleteMatching matching;
  matching.mesh = SurfaceMesh::from_triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}},
                                              {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}});
  for (Index i = 0; i < 4; ++i) matching.sample_of_vertex.push_back(to_sample(i));
  return matching;
}

TEST(NearCopies, GoBesideFacesThatStayOpen) {
  PointCloud cloud;
  std::vector<Vec3> points = tetrahedron().mesh.position;
  cloud.position = points;
  cloud.input_index = {0, 1, 2, 3};
  points.emplace_back(1e-3, 1e-3, 0.0);  // on the first face
  cloud.conditioning.near_copies = {{4, 0}};
  Progress silent;
  for (const bool spans : {false, true}) {
    CompleteMatching matching = tetrahedron();
    if (spans) matching.spanning_faces = matching.opening_faces = {0};
    insert_near_copies(matching, cloud, points, silent);
    testing::expect_closed_manifold(matching.mesh, 1, 0);
    ASSERT_EQ(matching.mesh.vertex_slots(), 5);
    EXPECT_EQ(matching.mesh.position[4], points[4]);
    EXPECT_EQ(matching.sample_of_vertex[4], to_sample(4));
    EXPECT_EQ(cloud.input_index_of(to_sample(4)), 4);
    const Triangle first = matching.mesh.triangle(0);
    EXPECT_EQ(first == (Triangle{0, 1, 2}), spans);
    EXPECT_EQ(matching.spanning_faces.size(), spans ? 1u : 0u);
  }
  // A sample that only such faces hold: its copies are among them, those that stay if there are.
  CompleteMatching matching = tetrahedron();
  matching.spanning_faces = {0, 1, 3};
  matching.opening_faces = {0, 1};
  insert_near_copies(matching, cloud, points, silent);
  EXPECT_EQ(matching.spanning_faces.size(), 5u);
  EXPECT_EQ(matching.opening_faces.size(), 2u);
}

}  // namespace
}  // namespace shrinkwrap
