#include "stop_at_surface/intersection_relaxation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "expect_mesh.h"
#include "mesh/self_intersection.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

std::vector<Index> faces_that_meet(const SurfaceMesh& mesh) {
  Progress silent;
  return self_intersecting_faces(mesh.position, mesh.triangles(), silent);
}

RelaxationReport relax(SurfaceMesh& mesh, const RelaxationOptions& options, Progress& progress) {
  return relax_self_intersections(mesh, {}, HostScalar::double_precision, options, progress);
}

// A torus whose vertices near x = 1 were shaken by more than an edge.
SurfaceMesh shaken_torus(double by) {
  SurfaceMesh mesh = torus_mesh(60, 24);
  Random random(3);
  for (Vec3& p : mesh.position)
    if (p.x() > 0.9) p += by * random.in_cube();
  return mesh;
}

TEST(IntersectionRelaxation, UnfoldsAndLeavesTheRestAlone) {
  const SurfaceMesh before = shaken_torus(0.2);
  ASSERT_GT(faces_that_meet(before).size(), 20u);
  SurfaceMesh mesh = before;
  Progress silent;
  const RelaxationReport report = relax(mesh, {}, silent);
  EXPECT_EQ(report.faces_before, static_cast<Index>(faces_that_meet(before).size()));
  EXPECT_EQ(report.faces_after, 0);
  EXPECT_TRUE(faces_that_meet(mesh).empty());
  EXPECT_EQ(mesh.triangles(), before.triangles());
  Index moved = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    moved += mesh.position[v] != before.position[v];
    EXPECT_TRUE(before.position[v].x() > 0.0 || mesh.position[v] == before.position[v]);
  }
  EXPECT_EQ(moved, report.moved);
  EXPECT_LT(moved, mesh.vertex_slots() / 2);
}

// A finger through the wall opposite, drawn back by a few of its rings in a round.
TEST(IntersectionRelaxation, DrawsBackWhatReachesFar) {
  SurfaceMesh mesh = torus_mesh(120, 48);
  const Vec3 foot = *std::max_element(mesh.position.begin(), mesh.position.end(),
                                      [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
  for (Vec3& p : mesh.position)
    p.x() -= 2.0 * std::pow(std::max(0.0, 1.0 - (p - foot).squaredNorm() / 0.1), 2);
  Progress silent;
  const RelaxationReport report = relax(mesh, {}, silent);
  EXPECT_GT(report.faces_before, 200);
  EXPECT_EQ(report.faces_after, 0);
  EXPECT_EQ(report.flips, 0);
}

// Coordinates of which single precision keeps some thousand steps over the torus.
TEST(IntersectionRelaxation, MovesVerticesToWhereTheHostHasThem) {
  Frame frame;
  frame.center = Vec3(30000.0, -20000.0, 10000.0);
  constexpr HostScalar kScalar = HostScalar::single_precision;
  SurfaceMesh mesh = shaken_torus(0.3);
  round_to_host(mesh, frame, kScalar);
  Progress silent;
  const RelaxationReport report = relax_self_intersections(mesh, frame, kScalar, {}, silent);
  EXPECT_GT(report.moved, 0);
  EXPECT_EQ(report.faces_after, 0);
  const SurfaceMesh relaxed = mesh;
  round_to_host(mesh, frame, kScalar);
  EXPECT_EQ(mesh.position, relaxed.position);
}

TEST(IntersectionRelaxation, LeavesASurfaceWithoutIntersectionsAlone) {
  SurfaceMesh mesh = icosphere(3);
  const SurfaceMesh before = mesh;
  Progress silent;
  const RelaxationReport report = relax(mesh, {}, silent);
  EXPECT_EQ(report.faces_before, 0);
  EXPECT_EQ(report.rounds, 0);
  expect_same_mesh(mesh, before);
}

TEST(IntersectionRelaxation, PutsBackWhatDidNotHelp) {
  const SurfaceMesh before = shaken_torus(0.2);
  SurfaceMesh mesh = before;
  RelaxationOptions options;
  options.weight = -0.5;  // makes it worse
  options.max_rounds = 3;
  options.repair.enabled = false;
  Progress silent;
  const RelaxationReport report = relax(mesh, options, silent);
  EXPECT_EQ(report.moved, 0);
  EXPECT_EQ(report.faces_after, report.faces_before);
  EXPECT_EQ(report.remaining_faces, faces_that_meet(mesh));
  expect_same_mesh(mesh, before);
}

TEST(IntersectionRelaxation, RepairsWhatSmoothingLeaves) {
  const SurfaceMesh before = shaken_torus(0.1);
  SurfaceMesh mesh = before;
  RelaxationOptions options;
  options.weight = 0.0;
  options.max_rounds = 1;
  Progress silent;
  const RelaxationReport report = relax(mesh, options, silent);
  EXPECT_GT(report.faces_before, 20);
  EXPECT_LT(report.faces_after, report.faces_before / 10);
  EXPECT_EQ(report.moved, 0);
  EXPECT_GT(report.flips, 0);
  EXPECT_EQ(report.remaining_faces, faces_that_meet(mesh));
  EXPECT_EQ(mesh.position, before.position);
  expect_closed_manifold(mesh, 1, 1);
}

// Two rings through each other: more faces meet for a while than before.
SurfaceMesh crossing_rings(double size, const Vec3& at) {
  return joined({torus_mesh(60, 24), placed(torus_mesh(60, 24), size, at)});
}

TEST(IntersectionRelaxation, KeepsTheRoundInWhichTheFewestFacesMeet) {
  const SurfaceMesh before = crossing_rings(1.0, Vec3(0.31, 0.02, 0.01));
  RelaxationOptions options;
  options.repair.enabled = false;
  options.most_growth = 100.0;
  Progress silent;
  Index fewest = static_cast<Index>(faces_that_meet(before).size());
  SurfaceMesh best = before;
  int gains = 0, rounds_without_gain = 0;
  for (options.max_rounds = 1; options.max_rounds <= 14; ++options.max_rounds) {
    SurfaceMesh mesh = before;
    const RelaxationReport report = relax(mesh, options, silent);
    ASSERT_EQ(report.remaining_faces, faces_that_meet(mesh)) << options.max_rounds << " rounds";
    ASSERT_LE(report.faces_after, fewest) << options.max_rounds << " rounds";
    const bool has_gained = report.faces_after < fewest;
    if (has_gained) best = mesh;
    expect_same_mesh(mesh, best);
    fewest = report.faces_after;
    ++(has_gained ? gains : rounds_without_gain);
  }
  EXPECT_GT(gains, 0);
  EXPECT_GT(rounds_without_gain, 5);
}

TEST(IntersectionRelaxation, EndsEarlyWhereTooManyMoreFacesMeet) {
  const SurfaceMesh before = crossing_rings(0.3, Vec3(0.71, 0.02, 0.1));
  RelaxationOptions options;
  options.repair.enabled = false;
  Progress silent;
  SurfaceMesh mesh = before;
  const RelaxationReport parted = relax(mesh, options, silent);
  EXPECT_EQ(parted.faces_after, 0);
  EXPECT_GT(parted.rounds, 20);

  options.most_growth = 1.2;
  mesh = before;
  const RelaxationReport report = relax(mesh, options, silent);
  EXPECT_GT(report.rounds, 1);
  EXPECT_LT(report.rounds, 10);
  EXPECT_EQ(report.moved, 0);
  EXPECT_EQ(report.faces_after, report.faces_before);
  expect_same_mesh(mesh, before);
}

// Two small bodies through each other all over, beside a torus that can be mended: smoothed as a
// whole they would shrink to points.
TEST(IntersectionRelaxation, LeavesWholeBodiesAlone) {
  const SurfaceMesh ball = placed(icosphere(0), 0.1, Vec3(5.0, 0.0, 0.0));
  SurfaceMesh turned = icosphere(0);
  for (Vec3& p : turned.position) p = Eigen::AngleAxisd(0.3, Vec3(1.0, 2.0, 3.0).normalized()) * p;
  SurfaceMesh mesh = joined({shaken_torus(0.2), ball, placed(turned, 0.1, Vec3(5.0, 0.0, 0.0))});
  const SurfaceMesh before = mesh;
  RelaxationOptions options;
  options.repair.enabled = false;
  Progress silent;
  const RelaxationReport report = relax(mesh, options, silent);
  EXPECT_LT(report.faces_after, report.faces_before);
  EXPECT_EQ(report.remaining_faces, faces_that_meet(mesh));
  EXPECT_GT(report.faces_after, 0);
  EXPECT_LT(report.rounds, options.max_rounds);  // once nothing is left that may move
  for (const Index f : report.remaining_faces)
    EXPECT_GT(mesh.position[mesh.triangle(f)[0]].x(), 4.0) << "face " << f;
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    EXPECT_TRUE(before.position[v].x() < 4.0 || mesh.position[v] == before.position[v]);
}

TEST(IntersectionRelaxation, LeavesAHeapAlone) {
  SurfaceMesh mesh = torus_mesh(60, 24);
  Random random(4);
  for (Vec3& p : mesh.position) p = random.in_cube();
  const SurfaceMesh before = mesh;
  Progress silent;
  const RelaxationReport report = relax(mesh, {}, silent);
  EXPECT_EQ(report.rounds, 0);
  EXPECT_EQ(report.faces_after, report.faces_before);
  expect_same_mesh(mesh, before);
}

TEST(IntersectionRelaxation, DoesNotDependOnThreads) {
  SurfaceMesh meshes[2] = {shaken_torus(0.3), shaken_torus(0.3)};
  RelaxationReport reports[2];
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Progress silent;
    reports[threads - 1] = relax(meshes[threads - 1], {}, silent);
  }
  EXPECT_GT(reports[0].moved, 0);
  EXPECT_EQ(reports[0].moved, reports[1].moved);
  EXPECT_EQ(reports[0].remaining_faces, reports[1].remaining_faces);
  expect_same_mesh(meshes[0], meshes[1]);
}

TEST(IntersectionRelaxation, CanBeCancelled) {
  SurfaceMesh mesh = shaken_torus(0.3);
  bool goes_on = true;
  Progress refused([&](double, const char*) { return goes_on; }, {Stage::parametric_surface});
  refused.begin(Stage::parametric_surface);
  goes_on = false;
  EXPECT_THROW(relax(mesh, {}, refused), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap::testing
