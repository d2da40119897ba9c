#include "noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 32;
constexpr Index kSamplesPerProbe = 16;  // of small clouds
constexpr int kCoefficients = 6;        // of a quadratic height field
constexpr int kLeastNeighbours = kCoefficients + 3;
constexpr double kUnknown = -1.0;
// Neighbourhoods that are as thick as they are wide hide a part of the noise: theirs is widened to
// at least 8 times the noise. A disc of radius r spacings holds pi r^2 samples.
constexpr double kNeighboursPerSquaredNoise = 50.0, kMostNeighbours = 200.0;
constexpr int kMostRounds = 4;

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using NormalEquations = Eigen::Matrix<double, kCoefficients, kCoefficients>;

// The nearest samples, of those that face the same way: across a thin wall lie samples of another
// surface. Relative to the sample, in its spacings.
std::vector<Vec3> neighbourhood_of(const PointCloud& cloud, Index sample, int neighbours) {
  const double scale = 1.0 / cloud.local_spacing[sample];
  std::vector<Vec3> offset;
  offset.reserve(static_cast<std::size_t>(neighbours));
  const auto add = [&](Index other) {
    if (cloud.normal[other].dot(cloud.normal[sample]) > 0.0f)
      offset.push_back(scale * (cloud.position[other] - cloud.position[sample]));
  };
  if (neighbours <= cloud.neighbour_count) {
    std::for_each(cloud.neighbours_of(sample), cloud.neighbours_of(sample) + neighbours, add);
  } else {
    std::vector<VoxelSearch::Hit> hits;
    cloud.search.k_nearest(cloud.position[sample], neighbours, hits);
    for (const VoxelSearch::Hit& hit : hits) add(hit.index);
  }
  return offset;
}

// Deviation around one sample, x its spacing.
double deviation_at(const PointCloud& cloud, Index sample, int neighbours) {
  std::vector<Vec3> offset = neighbourhood_of(cloud, sample, neighbours);
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
  return std::sqrt(std::max(residual, 0.0) / (count - kCoefficients));
}

NoiseEstimate estimate_with(const PointCloud& cloud, Index stride, int neighbours,
                            Progress& progress) {
  std::vector<double> deviation(static_cast<std::size_t>(cloud.size() / stride), kUnknown);
  parallel_for_each(static_cast<Index>(deviation.size()), kGrain, progress,
                    [&](Index n) { deviation[n] = deviation_at(cloud, n * stride, neighbours); });
  deviation.erase(std::remove(deviation.begin(), deviation.end(), kUnknown), deviation.end());
  if (deviation.empty()) return {};
  std::sort(deviation.begin(), deviation.end());
  return {deviation[deviation.size() / 2], deviation[deviation.size() * 4 / 5]};
}

}  // namespace

NoiseEstimate estimate_noise(const PointCloud& cloud, const NoiseOptions& options,
                             Progress& progress) {
  const Index probes =
      std::clamp<Index>(cloud.size() / kSamplesPerProbe, 1, std::max<Index>(options.probes, 1));
  const Index stride = std::max<Index>(cloud.size() / probes, 1);
  int neighbours = cloud.neighbour_count;
  NoiseEstimate noise = estimate_with(cloud, stride, neighbours, progress);
  for (int round = 0; round < kMostRounds; ++round) {
    const double needed = kNeighboursPerSquaredNoise * noise.median * noise.median;
    const int wider = static_cast<int>(std::lround(std::min(needed, kMostNeighbours)));
    if (wider <= neighbours) break;
    neighbours = wider;
    noise = estimate_with(cloud, stride, neighbours, progress);
  }
  return noise;
}

}  // namespace shrinkwrap
