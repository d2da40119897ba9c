#include "samples/quadric_deviation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace shrinkwrap {
namespace {

constexpr int kCoefficients = 6;  // of a quadratic height field
static_assert(QuadricDeviation::kLeastNeighbours == kCoefficients + 3);
// Of every neighbourhood the nearest part is fitted too.
constexpr double kNarrowPart = 0.625;
// The narrow ones are as wide as 10 times the noise, at least. A disc of radius r spacings holds
// pi r^2 samples.
constexpr double kNeighboursPerSquaredNoise = 80.0, kMostNeighbours = 200.0;

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
  if (count < QuadricDeviation::kLeastNeighbours) return QuadricDeviation::kUnknown;
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
  if (!std::isfinite(residual)) return QuadricDeviation::kUnknown;
  return std::max(residual, 0.0) / (count - kCoefficients);
}

// The median of the variances of so many neighbours if their residuals are normally distributed
// with variance 1 (Wilson and Hilferty 1931).
double median_variance(int neighbours) {
  return std::pow(1.0 - 2.0 / (9.0 * (neighbours - kCoefficients)), 3);
}

}  // namespace

QuadricDeviation quadric_deviation(const PointCloud& cloud, Index sample, int neighbours) {
  const std::vector<Index> nearest = nearest_to(cloud, sample, neighbours);
  return {squared_deviation(offsets_to(cloud, sample, nearest, narrower(neighbours))),
          squared_deviation(offsets_to(cloud, sample, nearest, neighbours))};
}

void SortedDeviations::add(const QuadricDeviation& deviation) {
  if (deviation.narrow != QuadricDeviation::kUnknown) narrow_.push_back(deviation.narrow);
  if (deviation.wide != QuadricDeviation::kUnknown) wide_.push_back(deviation.wide);
}

void SortedDeviations::sort() {
  std::sort(narrow_.begin(), narrow_.end());
  std::sort(wide_.begin(), wide_.end());
}

QuadricDeviation SortedDeviations::at(double part) const {
  const auto entry = [part](const std::vector<double>& sorted) {
    if (sorted.empty()) return QuadricDeviation::kUnknown;
    return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size()))];
  };
  return {entry(narrow_), entry(wide_)};
}

double variance_of_noise(const QuadricDeviation& median, int neighbours) {
  if (median.wide == QuadricDeviation::kUnknown) return 0.0;
  const int fewer = narrower(neighbours);
  if (median.narrow == QuadricDeviation::kUnknown || fewer < QuadricDeviation::kLeastNeighbours)
    return median.wide;
  const double growth = std::pow(static_cast<double>(neighbours) / fewer, 3);
  const double narrow = median.narrow * (median_variance(neighbours) / median_variance(fewer));
  return std::clamp((growth * narrow - median.wide) / (growth - 1.0), 0.0, median.wide);
}

int neighbours_for_noise(double variance) {
  const double needed = kNeighboursPerSquaredNoise * variance / kNarrowPart;
  return static_cast<int>(std::lround(std::min(needed, kMostNeighbours)));
}

}  // namespace shrinkwrap
