#include "orientation/inverted_patches.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "orientation/orientation.h"
#include "oriented_cloud.h"
#include "reconstruct.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// A ball with a hollow that is open at the top and a chamber below it. The window between the two
// is 2.4 spacings wide, and has a sharp edge all around.
constexpr double kHollow = 0.36, kWindow = 0.06;
const Vec3 kUpper(0.0, 0.0, 0.7);
const Vec3 kLower = kUpper - Vec3(0.0, 0.0, 2.0 * std::sqrt(kHollow * kHollow - kWindow * kWindow));

double ball_with_chamber(const Vec3& p) {
  const double hollows = std::min((p - kUpper).norm(), (p - kLower).norm()) - kHollow;
  return std::max(p.norm() - 0.95, -hollows);
}

std::vector<Vec3> sample_ball_with_chamber(unsigned seed) {
  Random random(seed);
  return sample_implicit(ball_with_chamber, {}, 6000, random).points;
}

// Of the samples of the chamber and the hollow, and of the others.
struct Wrong {
  double inside, outside;
};
Wrong wrong_parts(const PointCloud& cloud) {
  Index wrong[2] = {0, 0}, all[2] = {0, 0};
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.frame.to_input(cloud.position[i]);
    const bool is_outside = p.norm() > 0.949;
    ++all[is_outside];
    const Vec3 out = outward_normal(ball_with_chamber, p);
    wrong[is_outside] += out.dot(cloud.normal[i].cast<double>()) < 0.0;
  }
  return {static_cast<double>(wrong[0]) / all[0], static_cast<double>(wrong[1]) / all[1]};
}

// Normals are left as they are at edges, so that all that differs is what was turned.
OrientationOptions options_of_test() {
  OrientationOptions options;
  options.most_noise_at_creases = -1.0;
  return options;
}
OrientationOptions without_turns() {
  OrientationOptions options = options_of_test();
  options.inverted.most_noise = -1.0;
  return options;
}

PointCloud oriented(const std::vector<Vec3>& points, const OrientationOptions& options,
                    OrientationReport& report) {
  Progress silent;
  PointCloud cloud = prepared_cloud(points);
  report = orient_normals(cloud, options, silent);
  return cloud;
}

TEST(InvertedPatches, ChambersBehindSharpEdgesAreTurned) {
  int inside_out = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Vec3> points = sample_ball_with_chamber(seed);
    OrientationReport report;
    const PointCloud before = oriented(points, without_turns(), report);
    EXPECT_EQ(report.turned, 0);
    inside_out += wrong_parts(before).inside > 0.25;
    const PointCloud after = oriented(points, options_of_test(), report);
    EXPECT_LT(wrong_parts(after).inside, 0.1);
    EXPECT_LT(wrong_parts(after).outside, 0.01);
    Index turned = 0;
    for (Index i = 0; i < after.size(); ++i) turned += after.normal[i] == -before.normal[i];
    EXPECT_EQ(report.turned, turned);
  }
  EXPECT_GE(inside_out, 4) << "this test tests little";
}

// Two bodies that nobody united: what lies in the other becomes the wall of a hollow, so that all
// samples lie on a surface that does not meet itself.
TEST(InvertedPatches, BodiesThatIntersectMakeOneSurface) {
  Random random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 1200; ++i) points.push_back(0.5 * random.direction());
  for (int i = 0; i < 600; ++i) points.push_back(Vec3(0.3, 0, 0) + 0.35 * random.direction());
  Progress silent;
  const Reconstruction result = reconstruct(points, {}, silent);
  EXPECT_EQ(result.report.self_intersecting_faces, 0);
  EXPECT_EQ(result.report.vertices_extra, 0);
  EXPECT_TRUE(result.report.closed() && result.report.manifold());

  ReconstructionOptions options;
  options.orientation = without_turns();
  const Reconstruction other = reconstruct(points, options, silent);
  EXPECT_GT(other.report.self_intersecting_faces + other.report.vertices_extra, 0);
}

TEST(InvertedPatches, EdgesMayObject) {
  const std::vector<Vec3> points = sample_ball_with_chamber(2);
  OrientationOptions options = options_of_test();
  OrientationReport report;
  oriented(points, options, report);
  ASSERT_GT(report.turned, 0);
  options.inverted.most_objections = 0.0;
  oriented(points, options, report);
  EXPECT_EQ(report.turned, 0);
}

TEST(InvertedPatches, ThatAreSmallOrDoNotComeRightStay) {
  const std::vector<Vec3> points = sample_ball_with_chamber(2);
  OrientationReport report;
  OrientationOptions large = options_of_test();
  large.inverted.least_samples = 1000;
  oriented(points, large, report);
  EXPECT_EQ(report.turned, 0);
  OrientationOptions right = options_of_test();
  right.inverted.most_left = 0.05;
  oriented(points, right, report);
  EXPECT_EQ(report.turned, 0);
}

// In a thick layer of samples areas add up to more than that of a surface, and winding numbers to
// those of a body within a body.
TEST(InvertedPatches, AreNotLookedForInNoise) {
  Random random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 5000; ++i)
    points.push_back((1.0 + random.uniform(-0.2, 0.2)) * random.direction());
  OrientationReport report;
  oriented(points, options_of_test(), report);
  EXPECT_EQ(report.turned, 0);
  OrientationOptions always = options_of_test();
  always.inverted.most_noise = 1.0;
  oriented(points, always, report);
  EXPECT_GT(report.turned, 1000) << "this test tests little";
}

TEST(InvertedPatches, SheetsAndShellsStay) {
  OrientationReport report;
  oriented(sample_shape_blue_noise(ShapeKind::hemisphere, 3000, 1), options_of_test(), report);
  EXPECT_EQ(report.turned, 0);
  Random random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 9000; ++i) points.push_back((1.0 - 0.15 * (i % 3)) * random.direction());
  oriented(points, options_of_test(), report);
  EXPECT_EQ(report.turned, 0);
}

TEST(InvertedPatches, ThreadsDoNotMatter) {
  const std::vector<Vec3> points = sample_ball_with_chamber(2);
  OrientationReport report;
  const auto normals_with = [&](int threads) {
    return tbb::task_arena(threads).execute(
        [&] { return oriented(points, options_of_test(), report).normal; });
  };
  EXPECT_EQ(normals_with(1), normals_with(3));
  EXPECT_GT(report.turned, 0);
}

}  // namespace
