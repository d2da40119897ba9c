#include "samples/noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 32;
constexpr Index kSamplesPerProbe = 4;  // of small clouds
constexpr int kCoefficients = 6;       // of a quadratic height field
constexpr int kLeastNeighbours = kCoefficients + 3;
constexpr double kUnknown = -1.0;
// Of every neighbourhood the nearest part is fitted too.
constexpr double kNarrowPart = 0.625;
// Neighbourhoods that are as thick as they are wide hide a part of the noise: the narrow ones are
// widened to at least 10 times the noise. A disc of radius r spacings holds pi r^2 samples.
constexpr double kNeighboursPerSquaredNoise = 80.0, kMostNeighbours = 200.0;
constexpr int kMostRounds = 4;

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using NormalEquations = Eigen::Matrix<double, kCoefficients, kCoefficients>;

int narrower(int neighbours) {
  return static_cast<int>(std::lround(kNarrowPart * neighbours));
}

// The nearest samples, nearest first.
std::vector<Index> nearest_to(const PointCloud& cloud, Index sample, int neighbours) {
  if (neighbours <= cloud.neighbour_count)
    return {cloud.neighbours_of(sample), cloud.neighbours_of(sample) + neighbours};
  std::vector<VoxelSearch::Hit> hits;
  cloud.search.k_nearest(cloud.position[sample], neighbours, hits);
  std::vector<Index> nearest;
  nearest.reserve(hits.size());
  for (const VoxelSearch::Hit& hit : hits) nearest.push_back(hit.index);
  return nearest;
}

// Of the first `count` samples those that face the same way: across a thin wall lie samples of
// another surface. Relative to the sample, in its spacings.
std::vector<Vec3> offsets_to(const PointCloud& cloud, Index sample,
                             const std::vector<Index>& nearest, int count) {
  const double scale = 1.0 / cloud.local_spacing[sample];
  std::vector<Vec3> offset;
  for (const Index other : nearest) {
    if (count-- == 0) break;
    if (cloud.normal[other].dot(cloud.normal[sample]) > 0.0f)
      offset.push_back(scale * (cloud.position[other] - cloud.position[sample]));
  }
  return offset;
}

// Mean squared residual of the quadric that fits best, free of the bias of the fit.
double squared_deviation(std::vector<Vec3> offset) {
  const int count = static_cast<int>(offset.size());
  if (count < kLeastNeighbours) return kUnknown;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& d : offset) mean += d;
  mean /= count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (Vec3& d : offset) {
    d -= mean;
    scatter += d * d.transpose();
  }
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();

  NormalEquations squares = NormalEquations::Zero();
  Coefficients moments = Coefficients::Zero();
  double heights = 0.0;
  for (const Vec3& d : offset) {
    const Vec3 local = axes.transpose() * d;  // least extent first
    const double z = local[0], v = local[1], u = local[2];
    Coefficients term;
    term << 1.0, u, v, u * u, u * v, v * v;
    squares += term * term.transpose();
    moments += z * term;
    heights += z * z;
  }
  const double residual = heights - squares.ldlt().solve(moments).dot(moments);
  if (!std::isfinite(residual)) return kUnknown;
  return std::max(residual, 0.0) / (count - kCoefficients);
}

// The median of the variances of so many neighbours if their residuals are normally distributed
// with variance 1 (Wilson and Hilferty 1931).
double median_variance(int neighbours) {
  return std::pow(1.0 - 2.0 / (9.0 * (neighbours - kCoefficients)), 3);
}

// What the quadrics miss of a curved surface grows with the third power of the radius of the
// neighbourhood, its square thus with the third power of the number of samples; noise does not
// grow. Two sizes tell them apart. `narrow` and `wide`: the medians of the variances of each.
double variance_of_noise(double narrow, double wide, int neighbours) {
  const int fewer = narrower(neighbours);
  const double growth = std::pow(static_cast<double>(neighbours) / fewer, 3);
  narrow *= median_variance(neighbours) / median_variance(fewer);
  return std::clamp((growth * narrow - wide) / (growth - 1.0), 0.0, wide);
}

NoiseEstimate estimate_with(const PointCloud& cloud, Index stride, int neighbours,
                            Progress& progress) {
  const auto probes = static_cast<Index>(cloud.size() / stride);
  std::vector<double> narrow(static_cast<std::size_t>(probes), kUnknown), wide = narrow;
  parallel_for_each(probes, kGrain, progress, [&](Index n) {
    const Index sample = n * stride;
    const std::vector<Index> nearest = nearest_to(cloud, sample, neighbours);
    narrow[n] = squared_deviation(offsets_to(cloud, sample, nearest, narrower(neighbours)));
    wide[n] = squared_deviation(offsets_to(cloud, sample, nearest, neighbours));
  });
  const auto sort_known = [](std::vector<double>& variances) {
    variances.erase(std::remove(variances.begin(), variances.end(), kUnknown), variances.end());
    std::sort(variances.begin(), variances.end());
  };
  sort_known(narrow);
  sort_known(wide);
  if (wide.empty()) return {};
  double median = wide[wide.size() / 2];
  if (!narrow.empty())  // not of fewer than 14 neighbours
    median = variance_of_noise(narrow[narrow.size() / 2], median, neighbours);
  return {std::sqrt(median), std::sqrt(wide[wide.size() * 4 / 5]), {}};
}

}  // namespace

NoiseEstimate estimate_noise(const PointCloud& cloud, const NoiseOptions& options,
                             Progress& progress) {
  const Index probes =
      std::clamp<Index>(cloud.size() / kSamplesPerProbe, 1, std::max<Index>(options.probes, 1));
  const Index stride = std::max<Index>(cloud.size() / probes, 1);
  int neighbours = std::max(cloud.neighbour_count, kLeastNeighbours);
  NoiseEstimate noise = estimate_with(cloud, stride, neighbours, progress);
  for (int round = 0; round < kMostRounds; ++round) {
    const double needed = kNeighboursPerSquaredNoise * noise.median * noise.median / kNarrowPart;
    const int wider = static_cast<int>(std::lround(std::min(needed, kMostNeighbours)));
    if (wider <= neighbours) break;
    neighbours = wider;
    noise = estimate_with(cloud, stride, neighbours, progress);
  }
  noise.layers = find_layers(cloud, options.layers, progress);
  const auto count = [](double& deviation, double step) {
    deviation = std::max(deviation, std::min(step / std::sqrt(12.0), 1.0));
  };
  count(noise.median, noise.layers.step);
  count(noise.upper_fifth, noise.layers.upper_fifth);
  return noise;
}

}  // namespace shrinkwrap
