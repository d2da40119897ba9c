#include "complete_matching/outliers_on_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cleaned_cloud.h"
#include "initial_mesh/bounding_box_start.h"
#include "reconstruct.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

constexpr double kCell = 1.0 / 32;
const std::vector<Vec3> kAlone = {
    {0.25, 4 * kCell, 0.0}, {0.75, 4 * kCell, 0.0}, {1.0, 0.25, 4 * kCell}, {1.0, 0.75, 4 * kCell}};
const Index kAloneCount = static_cast<Index>(kAlone.size());

Cleaned cleaned_and_oriented(const std::vector<Vec3>& points) {
  Progress silent;
  Cleaned result = cleaned(points);
  orient_normals(result.cloud, {}, silent);
  return result;
}

Reconstruction reconstructed(const std::vector<Vec3>& points, double foot, int threads = 0) {
  Progress silent;
  ReconstructionOptions options;
  options.outliers.foot = foot;
  options.threads = threads;
  return reconstruct(points, options, silent);
}

SurfaceMesh cube_surface(const Frame& frame) {
  return box_mesh(frame.to_unit(Vec3::Zero()), frame.to_unit(Vec3::Ones()));
}

TEST(OutliersOnSurface, SamplesAloneInAFaceBecomeVertices) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  const Reconstruction without = reconstructed(points, 0.0);
  ASSERT_EQ(without.outliers.input_index, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(without.outliers.on_surface, 0);

  const Reconstruction with = reconstructed(points, OutlierOptions().foot);
  EXPECT_TRUE(with.outliers.input_index.empty());
  EXPECT_EQ(with.outliers.on_surface, kAloneCount);
  EXPECT_EQ(with.report.samples, static_cast<Index>(points.size()));
  EXPECT_EQ(with.report.samples_matched, with.report.samples);
  EXPECT_EQ(with.report.vertices_extra, 0);
  EXPECT_EQ(with.report.self_intersecting_faces, 0);
  EXPECT_EQ(with.report.genus, 0);
  EXPECT_TRUE(with.report.closed());
  for (Index i = 0; i < kAloneCount; ++i) EXPECT_EQ(with.mesh.position[i], points[i]);
}

TEST(OutliersOnSurface, TheNoiseAroundSamplesStaysTheirs) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  Cleaned c = cleaned_and_oriented(points);
  for (const Index i : c.cloud.input_index) c.cloud.more_noise.push_back(static_cast<float>(i));
  Progress silent;
  ASSERT_EQ(keep_outliers_on_surface(c.cloud, c.report, points, cube_surface(c.cloud.frame),
                                     OutlierOptions(), silent),
            kAloneCount);
  ASSERT_EQ(c.cloud.more_noise.size(), points.size());
  for (Index i = 0; i < c.cloud.size(); ++i) {
    const Index point = c.cloud.input_index[i];
    if (point < kAloneCount)
      EXPECT_GE(c.cloud.more_noise[i], static_cast<float>(kAloneCount)) << "of one around it";
    else
      EXPECT_EQ(c.cloud.more_noise[i], static_cast<float>(point));
  }
}

TEST(OutliersOnSurface, StrayPointsOverAFaceOrInAnOpeningStayOutliers) {
  std::vector<Vec3> points = cube_with_gaps(kAlone);
  const double height = 3.6 * kCell;
  const Index stray = static_cast<Index>(points.size());
  points.push_back({0.5, 0.5, 1.0 + height});
  points.push_back({-height, 0.5, 0.5});
  const Reconstruction result = reconstructed(points, OutlierOptions().foot);
  EXPECT_EQ(result.outliers.input_index, (std::vector<Index>{stray, stray + 1}));
  EXPECT_EQ(result.outliers.on_surface, kAloneCount);

  std::vector<Vec3> cap = sample_shape_blue_noise(ShapeKind::hemisphere, 3000, 1);
  cap.push_back(Vec3::Zero());
  const Reconstruction open = reconstructed(cap, OutlierOptions().foot);
  EXPECT_EQ(open.outliers.input_index, (std::vector<Index>{static_cast<Index>(cap.size()) - 1}));
}

// A second attempt is made of the samples that the first found.
TEST(OutliersOnSurface, ASecondAttemptHasTheSameSamples) {
  int backs = 0, smoothings = 0;
  for (const double noisy_from : {0.2, -1.0})
    for (const unsigned seed : {1u, 2u}) {
      SCOPED_TRACE(seed);
      Random random(seed);
      std::vector<Vec3> points = cube_with_gaps(kAlone);
      // Two noisy layers, too close to each other to be told apart.
      for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
          for (const double z : {0.0, 0.5})
            points.push_back((Vec3(48 + i, j, z) + 0.5 * random.in_cube()) / 32.0);
      Progress silent;
      ReconstructionOptions options;
      options.noise.high = options.denoising.from = noisy_from;
      const Reconstruction result = reconstruct(points, options, silent);
      backs += result.backs.is_made && result.backs.is_finished;
      smoothings += result.smoothing.is_made && result.smoothing.is_finished;
      EXPECT_TRUE(result.outliers.input_index.empty());
      EXPECT_EQ(result.outliers.on_surface, kAloneCount);
      EXPECT_EQ(result.report.samples_matched, static_cast<Index>(points.size()));
    }
  EXPECT_GE(backs, 2);
  EXPECT_GE(smoothings, 2);
}

// As if the samples had never been away.
TEST(OutliersOnSurface, TheCloudIsThatOfAllTheSamples) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  Progress silent;
  const PointCloud whole = prepare_samples(points, {}, silent);
  Cleaned some = cleaned_and_oriented(points);
  ASSERT_EQ(some.cloud.size(), whole.size() - kAloneCount);
  some.cloud.closedness = 0.25;
  EXPECT_EQ(keep_outliers_on_surface(some.cloud, some.report, points,
                                     cube_surface(some.cloud.frame), {}, silent),
            kAloneCount);
  EXPECT_TRUE(some.report.input_index.empty());
  EXPECT_EQ(some.cloud.position, whole.position);
  EXPECT_EQ(some.cloud.input_index, whole.input_index);
  EXPECT_EQ(some.cloud.neighbour, whole.neighbour);
  EXPECT_EQ(some.cloud.local_spacing, whole.local_spacing);
  EXPECT_EQ(some.cloud.spacing, whole.spacing);
  EXPECT_EQ(some.cloud.closedness, 0.25);
  ASSERT_EQ(some.cloud.plane.size(), whole.position.size());
  const PointCloud others = cleaned_and_oriented(points).cloud;
  Index other = 0;
  for (Index i = 0; i < whole.size(); ++i) {
    const Index input = whole.input_index[i];
    EXPECT_NEAR(some.cloud.plane[i].normal.norm(), 1.0f, 1e-5f);
    if (input >= kAloneCount)
      EXPECT_EQ(some.cloud.normal[i], others.normal[other++]);
    else
      EXPECT_EQ(some.cloud.normal[i], input < 2 ? Vec3f(0, 0, -1) : Vec3f(1, 0, 0));
  }
}

TEST(OutliersOnSurface, VerticesOfAMeshAreSamples) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  Progress silent;
  Cleaned some = cleaned_and_oriented(points);
  const double nan = std::nan("");
  const std::vector<Vec3> vertices = {{nan, nan, nan}, points[100],     points[2],
                                      {0.5, 0.5, 0.5}, {nan, 0.0, 0.0}, points[0]};
  keep_outliers_among(some.cloud, some.report, points, vertices, silent);
  EXPECT_EQ(some.report.input_index, (std::vector<Index>{1, 3}));
  EXPECT_EQ(some.report.on_surface, 2);
  EXPECT_EQ(some.cloud.size(), static_cast<Index>(points.size()) - 2);
  EXPECT_EQ(std::count(some.cloud.input_index.begin(), some.cloud.input_index.end(), 2), 1);
}

TEST(OutliersOnSurface, ThreadsDoNotMatter) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  const double foot = OutlierOptions().foot;
  const Reconstruction one = reconstructed(points, foot, 1), three = reconstructed(points, foot, 3);
  EXPECT_EQ(one.mesh.triangles, three.mesh.triangles);
  EXPECT_EQ(one.outliers.on_surface, three.outliers.on_surface);
}

TEST(OutliersOnSurface, ACancelledRunLosesNothing) {
  const std::vector<Vec3> points = cube_with_gaps(kAlone);
  Cleaned some = cleaned_and_oriented(points);
  const std::vector<Vec3> position = some.cloud.position;
  Progress cancelled([](double, const char*) { return false; }, {Stage::complete_matching});
  EXPECT_THROW(cancelled.begin(Stage::complete_matching), Cancelled);
  EXPECT_THROW(keep_outliers_on_surface(some.cloud, some.report, points,
                                        cube_surface(some.cloud.frame), {}, cancelled),
               Cancelled);
  EXPECT_EQ(some.cloud.position, position);
  EXPECT_EQ(some.report.input_index.size(), kAlone.size());
}

}  // namespace
