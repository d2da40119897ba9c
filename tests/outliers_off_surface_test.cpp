#include "complete_matching/outliers_off_surface.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cleaned_cloud.h"
#include "initial_mesh/bounding_box_start.h"
#include "match_cloud.h"
#include "reconstruct.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr Index kCells = 32;
constexpr double kCell = 1.0 / kCells;

std::vector<Vec3> cube() {
  return cube_with_gaps({});
}

// A cloud of all the points, and the surface of the unit cube.
class OutliersOffSurface : public ::testing::Test {
 protected:
  void prepare(const std::vector<Vec3>& samples) {
    points = samples;
    Progress silent;
    SampleOptions sample_options;
    sample_options.near_copies.enabled = false;
    cloud = prepare_samples(points, sample_options, silent);
    orient_normals(cloud, {}, silent);
    surface = box_mesh(cloud.frame.to_unit(Vec3::Zero()), cloud.frame.to_unit(Vec3::Ones()));
  }
  Index found(int threads = 0) {
    Progress silent;
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    return arena.execute([&] {
      return leave_out_samples_off_surface(cloud, report, surface, noise, options, silent);
    });
  }
  // With a mesh through the points but for those from `without` on.
  Index found_beside_mesh(Index without) {
    Progress silent;
    return found_beside_mesh(without, silent);
  }
  Index found_beside_mesh(Index without, Progress& progress) {
    std::vector<Vec3> vertices(points.begin(), points.begin() + without);
    const Index first = static_cast<Index>(vertices.size());
    for (const Vec3& p : surface.position) vertices.push_back(cloud.frame.to_input(p));
    std::vector<Triangle> triangles;
    for (Index f = 0; f < surface.face_slots(); ++f) {
      const Triangle t = surface.triangle(f);
      triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    vertices.push_back(Vec3::Constant(std::nan("")));
    const Index end = static_cast<Index>(vertices.size());
    triangles.push_back({0, 1, end});  // no face
    triangles.push_back({0, 1, end - 1});
    return leave_out_samples_off_mesh(cloud, report, points, vertices, triangles, options,
                                      progress);
  }

  std::vector<Vec3> points;
  PointCloud cloud;
  SurfaceMesh surface;
  double noise = 0.0;
  OutlierReport report;
  OutlierOptions options;
};

TEST_F(OutliersOffSurface, SamplesAloneOffItAreLeftOut) {
  std::vector<Vec3> samples = cube();
  const Index count = static_cast<Index>(samples.size());
  for (const double cells : {0.7, 1.3, 3.0})  // the spacing is about one
    samples.push_back(Vec3(0.5, 0.3 * cells, 1.0 + cells * kCell));
  prepare(samples);
  report.input_index = {count + 7};
  report.suspected = 1;
  EXPECT_EQ(found(), 2);
  EXPECT_EQ(report.input_index, (std::vector<Index>{count + 1, count + 2, count + 7}));
  EXPECT_EQ(report.suspected, 3);
  EXPECT_EQ(report.off_surface, (std::vector<Index>{count + 1, count + 2}));
  EXPECT_EQ(found(), 0);
}

// As if the samples had never been there.
TEST_F(OutliersOffSurface, TheCloudIsThatOfTheRest) {
  std::vector<Vec3> samples = cube();
  prepare(samples);
  const PointCloud rest = cloud;
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.0 * kCell));
  prepare(samples);
  const auto noise_of = [](Index point) { return 1e-6f * static_cast<float>(point); };
  for (const Index i : cloud.input_index) cloud.more_noise.push_back(noise_of(i));
  cloud.closedness = 0.25;
  const PointCloud before = cloud;
  ASSERT_EQ(found(), 1);
  EXPECT_EQ(cloud.input_index, rest.input_index);
  EXPECT_EQ(cloud.neighbour, rest.neighbour);
  EXPECT_EQ(cloud.closedness, 0.25);
  std::vector<Index> place(points.size());
  for (Index b = 0; b < before.size(); ++b) place[before.input_index[b]] = b;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Index b = place[cloud.input_index[i]];
    EXPECT_EQ(before.position[b], cloud.position[i]);
    EXPECT_EQ(before.normal[b], cloud.normal[i]);
    EXPECT_EQ(before.plane[b].point, cloud.plane[i].point);
    EXPECT_EQ(cloud.more_noise[i], noise_of(cloud.input_index[i]));
  }
}

// What the surface does not show: a post, a patch and close samples.
TEST_F(OutliersOffSurface, SeveralTogetherAreNot) {
  std::vector<Vec3> samples = cube();
  for (int i = 1; i <= 6; ++i) samples.push_back(Vec3(0.2, 0.2, 1.0 + 0.6 * i * kCell));
  for (int i = 0; i < 9; ++i)
    samples.push_back(Vec3(0.7 + i % 3 * kCell, 0.7 + i / 3 * kCell, 1.0 + 2.0 * kCell));
  prepare(samples);
  EXPECT_EQ(found(), 0);
  EXPECT_TRUE(report.input_index.empty());
}

// Nor one whose neighbours are as near as those of the others are: it may be of a part with more
// samples.
TEST_F(OutliersOffSurface, SamplesOverADensePatchAreNot) {
  std::vector<Vec3> samples = cube();
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j)
      if (i % 5 != 0 || j % 5 != 0)
        samples.push_back(Vec3(0.5 + 0.2 * i * kCell, 0.5 + 0.2 * j * kCell, 1.0));
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.1 * kCell));
  prepare(samples);
  EXPECT_EQ(found(), 0);
}

// One after the other: each is around the others until it is left out.
TEST_F(OutliersOffSurface, StraysBesideEachOtherAreFound) {
  std::vector<Vec3> samples = cube();
  const Index count = static_cast<Index>(samples.size());
  for (int i = 0; i < 9; ++i)
    samples.push_back(Vec3(0.5 + 2.0 * (i % 3) * kCell, 0.5 + 2.0 * (i / 3) * kCell,
                           1.0 + (1.5 + 0.1 * i) * kCell));
  prepare(samples);
  options.most_rounds = 1;
  const Index at_first = found();
  EXPECT_GE(at_first, 1);
  EXPECT_LT(at_first, 9);
  options = {};
  report = {};
  prepare(samples);
  ASSERT_EQ(found(), 9);
  EXPECT_EQ(report.input_index.front(), count);
  report = {};
  prepare(samples);
  EXPECT_EQ(found_beside_mesh(count), 9);
}

TEST_F(OutliersOffSurface, WhereItIsUselessNoneIsLeftOut) {
  std::vector<Vec3> samples = cube();
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.0 * kCell));
  prepare(samples);
  options.off_surface = kNever;
  EXPECT_EQ(found(), 0);
  options = {};
  options.most = 0.5 / static_cast<double>(samples.size());
  EXPECT_EQ(found(), 0);
  options = {};
  report.suspected = cloud.size() / 2;  // which stay, since they are too many
  EXPECT_EQ(found(), 0);
  report = {};
  // A face alone, and one sample that makes it a body.
  samples.erase(
      std::remove_if(samples.begin(), samples.end(), [](const Vec3& p) { return p.z() < 1.0; }),
      samples.end());
  prepare(samples);
  surface = box_mesh(cloud.frame.to_unit(Vec3(0, 0, 0.999)), cloud.frame.to_unit(Vec3::Ones()));
  EXPECT_EQ(found(), 0);
  EXPECT_EQ(cloud.size(), static_cast<Index>(samples.size()));
}

TEST_F(OutliersOffSurface, NoiseMovesSamplesOffIt) {
  std::vector<Vec3> samples = cube();
  samples.push_back(Vec3(0.3, 0.5, 1.0 + 2.5 * kCell));
  samples.push_back(Vec3(0.7, 0.5, 1.0 + 4.5 * kCell));
  prepare(samples);
  noise = 0.5;
  ASSERT_EQ(found(), 1);
  const Index last = static_cast<Index>(samples.size()) - 1;
  EXPECT_EQ(report.input_index.front(), last);
  prepare(samples);
  report = {};
  noise = 0.0;
  for (const Index i : cloud.input_index) cloud.more_noise.push_back(i == last - 1 ? 0.5f : 0.0f);
  ASSERT_EQ(found(), 1);
  EXPECT_EQ(report.input_index.front(), last);
}

// As the corners of a sheet are, where a smooth surface draws back from them. Beside an edge,
// others lie across.
TEST_F(OutliersOffSurface, SamplesInThePlaneOfOthersAreNot) {
  const Vec3 beside(1.0 + 1.5 * kCell, 0.5, 1.0);
  std::vector<Vec3> samples = cube();
  samples.push_back(beside);
  prepare(samples);
  EXPECT_EQ(found(), 1);
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [](const Vec3& p) { return p.z() > 0.0 && p.z() < 1.0; }),
                samples.end());
  prepare(samples);
  EXPECT_EQ(found(), 0);
}

TEST_F(OutliersOffSurface, NearCopiesGoWithThem) {
  std::vector<Vec3> samples = cube();
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.0 * kCell));
  const Index stray = static_cast<Index>(samples.size()) - 1;
  prepare(samples);
  cloud.conditioning.near_copies = {{stray + 1, stray}, {stray + 2, 0}};
  EXPECT_EQ(found(), 1);
  EXPECT_EQ(report.input_index, (std::vector<Index>{stray, stray + 1}));
  EXPECT_EQ(report.suspected, 1);
  EXPECT_EQ(cloud.conditioning.near_copies.size(), 1u);
}

TEST_F(OutliersOffSurface, AMeshMayLackThem) {
  std::vector<Vec3> samples = cube();
  const Index count = static_cast<Index>(samples.size());
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.0 * kCell));
  prepare(samples);
  EXPECT_EQ(found_beside_mesh(count + 1), 0);
  ASSERT_EQ(found_beside_mesh(count), 1);
  EXPECT_EQ(report.input_index, (std::vector<Index>{count}));
  // So far from the others no mesh makes it a sample again.
  const double top = 1.0 + 6.0 * kCell;
  samples.back().z() = top;
  report = {};
  prepare(samples);
  surface = box_mesh(cloud.frame.to_unit(Vec3::Zero()), cloud.frame.to_unit(Vec3(1.0, 1.0, top)));
  EXPECT_EQ(found_beside_mesh(count), 1);
}

// Nor are others excused that it lacks: those on it, and many together.
TEST_F(OutliersOffSurface, AMeshMayLackNoOthers) {
  std::vector<Vec3> samples = cube();
  const Index count = static_cast<Index>(samples.size());
  samples.push_back(Vec3(0.51, 0.51, 1.0 + 0.3 * kCell));
  prepare(samples);
  EXPECT_EQ(found_beside_mesh(count), 0);
  samples.back() = Vec3(0.5, 0.5, 1.0 + 2.0 * kCell);
  prepare(samples);
  surface = box_mesh(cloud.frame.to_unit(Vec3::Zero()),
                     cloud.frame.to_unit(Vec3(1.0, 1.0, 1.0 + 2.0 * kCell)));
  EXPECT_EQ(found_beside_mesh(count), 0);
  samples.pop_back();
  for (int i = 0; i < 36; ++i)
    samples.push_back(Vec3(0.5 + i % 6 * kCell, 0.5 + i / 6 * kCell, 1.0 + 3.0 * kCell));
  prepare(samples);
  EXPECT_EQ(found_beside_mesh(count), 0);
}

// As where a face has a hole, for one sample or four.
TEST_F(OutliersOffSurface, AMeshMayLackNothingInThePlanesOfItsVertices) {
  for (const int size : {1, 2}) {
    SCOPED_TRACE(size);
    std::vector<Vec3> samples = cube();
    const auto is_in_hole = [&](const Vec3& p) {
      return p.z() == 1.0 && p.x() >= 0.5 && p.y() >= 0.5 && p.x() < 0.5 + size * kCell &&
             p.y() < 0.5 + size * kCell;
    };
    const auto hole = std::stable_partition(samples.begin(), samples.end(),
                                            [&](const Vec3& p) { return !is_in_hole(p); });
    const Index count = static_cast<Index>(hole - samples.begin());
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(count + size * size));
    prepare(samples);
    surface = SurfaceMesh();  // no face at all
    EXPECT_EQ(found_beside_mesh(count), 0);
  }
}

// Points beside an edge, where planes tell nothing: the search keeps some of them.
TEST(OutliersOffSurfaceOfAll, PointsBesideEdgesAreStray) {
  const std::vector<Vec3> points = cube_with_strays_beside_edges(900, 5);
  Progress silent;
  ReconstructionOptions options;
  options.outliers.off_surface = kNever;
  const Reconstruction before = reconstruct(points, options, silent);
  const Reconstruction after = reconstruct(points, {}, silent);
  EXPECT_TRUE(before.outliers.off_surface.empty());
  EXPECT_GE(after.outliers.off_surface.size(), 2u);
  EXPECT_EQ(after.outliers.input_index.size(),
            before.outliers.input_index.size() + after.outliers.off_surface.size());
  options = {};
  options.outliers.exclude = false;
  EXPECT_TRUE(reconstruct(points, options, silent).outliers.input_index.empty());
  EXPECT_GE(after.outliers.input_index.front(), static_cast<Index>(points.size()) - 12);
  EXPECT_TRUE(after.report.closed());
  EXPECT_EQ(after.report.samples_matched, after.report.samples);
  EXPECT_EQ(after.report.vertices_extra, 0);
}

TEST(OutliersOffSurfaceOfAll, AnotherAttemptHasAsManySamples) {
  ReconstructionOptions options;
  keep_samples(options);
  EXPECT_EQ(options.outliers.foot, 0.0);
  EXPECT_EQ(options.outliers.off_surface, kNever);
}

TEST_F(OutliersOffSurface, ThreadsDoNotMatter) {
  std::vector<Vec3> samples = cube();
  for (int i = 0; i < 40; ++i)
    samples.push_back(Vec3(0.1 + 0.1 * (i % 8), 0.1 + 0.15 * (i / 8), 1.0 + (1 + i % 5) * kCell));
  prepare(samples);
  found(1);
  const OutlierReport one = report;
  const std::vector<Vec3> position = cloud.position;
  report = {};
  prepare(samples);
  found(3);
  EXPECT_GE(one.off_surface.size(), 30u);
  EXPECT_EQ(report.input_index, one.input_index);
  EXPECT_EQ(cloud.position, position);
}

TEST_F(OutliersOffSurface, ACancelledRunLosesNothing) {
  std::vector<Vec3> samples = cube();
  const Index count = static_cast<Index>(samples.size());
  samples.push_back(Vec3(0.5, 0.5, 1.0 + 2.0 * kCell));
  prepare(samples);
  Progress cancelled([](double, const char*) { return false; }, {Stage::complete_matching});
  EXPECT_THROW(cancelled.begin(Stage::complete_matching), Cancelled);
  EXPECT_THROW(leave_out_samples_off_surface(cloud, report, surface, noise, options, cancelled),
               Cancelled);
  EXPECT_THROW(found_beside_mesh(count, cancelled), Cancelled);
  EXPECT_EQ(cloud.size(), static_cast<Index>(samples.size()));
  EXPECT_TRUE(report.input_index.empty());
}

}  // namespace
