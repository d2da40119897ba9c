#include "stop_at_surface/samples_on_surface.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "orientation/denoising.h"
#include "oriented_cloud.h"
#include "parametric_surface/sample_feet.h"
#include "reconstruct.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// The vertices of a mesh of a cube with edges 2, with noise: edges are sampled.
std::vector<Vec3> cube(int cells, unsigned seed, double noise) {
  Random random(seed);
  std::vector<Vec3> points;
  const double spacing = 2.0 / cells;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j)
      for (int k = 0; k <= cells; ++k) {
        const auto is_end = [&](int n) { return n == 0 || n == cells; };
        if (is_end(i) || is_end(j) || is_end(k))
          points.push_back(Vec3(-1, -1, -1) + spacing * Vec3(i, j, k) +
                           noise * spacing * random.in_cube());
      }
  return points;
}

Reconstruction stopped(const std::vector<Vec3>& points, bool may_keep_detail = true) {
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  options.host_scalar = HostScalar::double_precision;
  if (!may_keep_detail) options.samples_on_surface.farthest_twentieth = INFINITY;
  Progress silent;
  return reconstruct(points, options, silent);
}

// The surface of a run that stopped, in the frame of a cloud of its samples.
struct Fitted {
  Fitted(const std::vector<Vec3>& points, double noise_of_samples) : noise(noise_of_samples) {
    Progress silent;
    cloud = oriented_cloud(points);
    surface = to_surface(stopped(points, false).mesh, cloud.frame);
    denoise(cloud, noise, cloud.neighbour_count, {}, silent);
  }
  SamplesOnSurface move(double assumed_noise) const {
    Progress silent;
    return move_onto_surface(surface, cloud, assumed_noise, {}, silent);
  }
  // Of the samples, if they were there, from the surface (x spacing).
  std::vector<double> distances(const std::vector<Vec3>& position) const {
    PointCloud moved = cloud;
    moved.position = position;
    Progress silent;
    std::vector<double> distance;
    for (const SampleFoot& foot : find_sample_feet(surface, moved, silent).foot) {
      const Triangle t = surface.triangle(foot.face);
      const double b = foot.weight_b, c = foot.weight_c;
      const Vec3 at = (1.0 - b - c) * surface.position[t[0]] + b * surface.position[t[1]] +
                      c * surface.position[t[2]];
      distance.push_back((position[distance.size()] - at).norm() / cloud.spacing);
    }
    return distance;
  }
  double noise;
  PointCloud cloud;
  SurfaceMesh surface;
};

TEST(SamplesOnSurface, WithoutNoiseNoneMoves) {
  const Fitted fitted(sample_shape(ShapeKind::box, 500, 1), 0.0);
  EXPECT_EQ(fitted.move(0.0).position, fitted.cloud.position);
}

TEST(SamplesOnSurface, AllMoveOntoASurfaceThatNoiseExplains) {
  const Fitted fitted(sample_noisy_shape(ShapeKind::sphere, 400, 1, 0.25), 0.25);
  const SamplesOnSurface samples = fitted.move(0.25);
  EXPECT_GT(samples.upper_fifth, 0.0);
  EXPECT_LT(samples.upper_fifth, 0.25);
  for (const double distance : fitted.distances(samples.position)) EXPECT_LT(distance, 1e-5);
}

TEST(SamplesOnSurface, SamplesInNoisyPartsMoveByTheNoiseThere) {
  Fitted fitted(sample_noisy_shape(ShapeKind::sphere, 400, 1, 0.25), 0.25);
  const SamplesOnSurface clean = fitted.move(0.0);
  fitted.cloud.more_noise.assign(fitted.cloud.position.size(), 0.25f);
  const SamplesOnSurface samples = fitted.move(0.0);
  EXPECT_EQ(samples.upper_fifth, clean.upper_fifth);
  EXPECT_EQ(clean.fifth_beyond_noise, clean.upper_fifth);
  EXPECT_FALSE(shows_its_samples(clean, 0.0, {}));
  EXPECT_TRUE(shows_its_samples(samples, 0.0, {}));
  for (const double distance : fitted.distances(samples.position)) EXPECT_LT(distance, 1e-5);
}

// A smooth surface rounds the edges of a cube. There the samples tell of more.
TEST(SamplesOnSurface, SamplesStayWhereTheSurfaceMissesDetail) {
  const Fitted fitted(cube(12, 1, 0.1), 0.06);
  const SamplesOnSurface samples = fitted.move(0.06);
  EXPECT_GT(samples.upper_fifth, 0.06);
  const double half_cell = 0.5 * fitted.cloud.frame.scale / 6.0;
  const Vec3 centre = fitted.cloud.frame.to_unit(Vec3::Zero());
  double flat = 0.0, flat_way = 0.0, edges = 0.0, edges_way = 0.0;  // moved, and the whole way
  const std::vector<double> way = fitted.distances(fitted.cloud.position);
  for (Index i = 0; i < fitted.cloud.size(); ++i) {
    const Vec3& p = fitted.cloud.position[i];
    Vec3 axes = (p - centre).cwiseAbs();
    std::sort(axes.data(), axes.data() + 3);
    const double moved = (samples.position[i] - p).norm() / fitted.cloud.spacing;
    const bool is_at_edge = axes[1] > fitted.cloud.frame.scale - half_cell;
    (is_at_edge ? edges : flat) += moved;
    (is_at_edge ? edges_way : flat_way) += way[i];
  }
  ASSERT_GT(edges_way, 0.0);
  EXPECT_LT(edges, 0.3 * edges_way);
  EXPECT_GT(flat / flat_way, 2.0 * edges / edges_way);
}

TEST(SamplesOnSurface, SameForAnyNumberOfThreads) {
  const Fitted fitted(sample_noisy_shape(ShapeKind::double_torus, 5000, 1, 0.1), 0.1);
  const auto with_threads = [&](int threads) {
    return tbb::task_arena(threads).execute([&] { return fitted.move(0.1).position; });
  };
  EXPECT_EQ(with_threads(1), with_threads(2));
}

// Of the faces, not of their corners: the edges of a smooth surface cut those of the cube.
double mean_distance_from_cube(const Reconstruction& result) {
  double sum = 0.0, area = 0.0;
  for (const Triangle& t : result.mesh.triangles) {
    const auto& p = result.mesh.position;
    const double face = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
    const Vec3 centre = (p[t[0]] + p[t[1]] + p[t[2]]) / 3.0;
    sum += face * std::abs(centre.cwiseAbs().maxCoeff() - 1.0);
    area += face;
  }
  return sum / area;
}

TEST(SamplesOnSurface, ARunThatStopsKeepsDetailThatTheSurfaceMisses) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const std::vector<Vec3> points = cube(8, seed, 0.1);
    const Reconstruction kept = stopped(points), smooth = stopped(points, false);
    EXPECT_FALSE(smooth.surface_detail.is_kept);
    EXPECT_GT(smooth.surface_detail.upper_fifth, smooth.noise.median);
    ASSERT_TRUE(kept.surface_detail.is_kept);
    EXPECT_EQ(kept.surface_detail.upper_fifth, smooth.surface_detail.upper_fifth);
    EXPECT_LT(mean_distance_from_cube(kept), 0.65 * mean_distance_from_cube(smooth));
    EXPECT_TRUE(kept.report.closed() && kept.report.manifold());
    EXPECT_EQ(kept.report.genus, 0);
    EXPECT_EQ(kept.report.self_intersecting_faces, 0);
    EXPECT_EQ(static_cast<std::size_t>(kept.stages[kept.stages.size() - 2].vertices),
              points.size());

    // Vertices stand for the samples, in their order, near where they were.
    ASSERT_EQ(kept.mesh.position.size(), points.size());
    double mean = 0.0, greatest = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(kept.mesh.input_index[i], static_cast<Index>(i));
      const double displacement = (kept.mesh.position[i] - points[i]).norm() / kept.spacing;
      mean += displacement / static_cast<double>(points.size());
      greatest = std::max(greatest, displacement);
    }
    EXPECT_NEAR(kept.surface_detail.mean_displacement, mean, 0.05 * mean);
    EXPECT_NEAR(kept.surface_detail.max_displacement, greatest, 0.05 * greatest);
    EXPECT_GT(mean, 0.0);
    EXPECT_LT(greatest, 1.0);
  }
}

TEST(SamplesOnSurface, ASurfaceThatShowsAllIsTheResult) {
  for (const double noise : {0.0, 0.3}) {
    SCOPED_TRACE(noise);
    const Reconstruction result = stopped(sample_noisy_shape(ShapeKind::torus, 4000, 1, noise));
    EXPECT_FALSE(result.surface_detail.is_kept);
    EXPECT_GT(result.surface_detail.upper_fifth, 0.0);
    EXPECT_GT(result.surface_detail.upper_twentieth, result.surface_detail.upper_fifth);
    if (noise == 0.0)
      EXPECT_LT(result.surface_detail.upper_twentieth, 0.06);
    else
      EXPECT_LT(result.surface_detail.upper_fifth, result.noise.median);
  }
}

// What spans an opening has no samples; nor has what is left open, but its membrane is no obstacle.
TEST(SamplesOnSurface, DetailIsKeptUnlessAnOpeningIsSpanned) {
  std::vector<Vec3> points;
  for (const Vec3& p : cube(12, 1, 0.1))
    if (p.z() < 0.2) points.push_back(p);
  const Reconstruction spanned = stopped(points);
  EXPECT_EQ(spanned.openings.spanned, 1);
  EXPECT_FALSE(spanned.surface_detail.is_kept);

  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  Progress silent;
  const Reconstruction open = reconstruct(points, options, silent);
  EXPECT_TRUE(open.surface_detail.is_kept);
  EXPECT_EQ(open.mesh.position.size(), points.size());
  EXPECT_EQ(open.report.border_loops, 1);
  EXPECT_EQ(open.openings.left_open, 1);
  EXPECT_EQ(open.report.self_intersecting_faces, 0);

  // Nobody would know of faces that meet.
  options.intersection_repair.enabled = false;
  EXPECT_FALSE(reconstruct(points, options, silent).surface_detail.is_kept);
}

}  // namespace
