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

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using NormalEquations = Eigen::Matrix<double, kCoefficients, kCoefficients>;

// Deviation around one sample, x its spacing.
double deviation_at(const PointCloud& cloud, Index sample, int neighbours) {
  std::vector<VoxelSearch::Hit> hits;
  if (neighbours > cloud.neighbour_count)
    cloud.search.k_nearest(cloud.position[sample], neighbours, hits);
  std::vector<Index> list(cloud.neighbours_of(sample),
                          cloud.neighbours_of(sample) + cloud.neighbour_count);
  if (!hits.empty()) {
    list.clear();
    for (const VoxelSearch::Hit& hit : hits) list.push_back(hit.index);
  }
  const double scale = 1.0 / cloud.local_spacing[sample];
  // Across a thin wall lie samples of another surface.
  std::vector<Vec3> offset;
  offset.reserve(list.size());
  Vec3 mean = Vec3::Zero();
  for (const Index other : list) {
    if (!(cloud.normal[other].dot(cloud.normal[sample]) > 0.0f)) continue;
    offset.push_back(scale * (cloud.position[other] - cloud.position[sample]));
    mean += offset.back();
  }
  const int count = static_cast<int>(offset.size());
  if (count < kLeastNeighbours) return kUnknown;
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

}  // namespace

NoiseEstimate estimate_noise(const PointCloud& cloud, const NoiseOptions& options,
                             Progress& progress) {
  const Index probes =
      std::clamp<Index>(cloud.size() / kSamplesPerProbe, 1, std::max<Index>(options.probes, 1));
  const Index stride = std::max<Index>(cloud.size() / probes, 1);
  const auto measure = [&](int neighbours) {
    std::vector<double> deviation(static_cast<std::size_t>(cloud.size() / stride), kUnknown);
    parallel_for_each(static_cast<Index>(deviation.size()), kGrain, progress, [&](Index n) {
      deviation[n] = deviation_at(cloud, n * stride, neighbours);
    });
    deviation.erase(std::remove(deviation.begin(), deviation.end(), kUnknown), deviation.end());
    if (deviation.empty()) return NoiseEstimate{};
    std::sort(deviation.begin(), deviation.end());
    return NoiseEstimate{deviation[deviation.size() / 2], deviation[deviation.size() * 4 / 5]};
  };
  NoiseEstimate noise = measure(cloud.neighbour_count);
  // Wider than thick.
  for (int round = 0, used = cloud.neighbour_count; round < 4; ++round) {
    const int wider = static_cast<int>(std::lround(50.0 * noise.median * noise.median));
    if (wider <= used) break;
    used = wider;
    noise = measure(wider);
  }
  return noise;
}

}  // namespace shrinkwrap
