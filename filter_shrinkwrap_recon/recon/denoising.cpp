#include "denoising.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "morton.h"
#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 7;
constexpr int kCoefficients = 6;  // of a quadratic height field: 1, u, v, u^2, u v, v^2
constexpr int kPowers = 15;       // u^a v^b up to the fourth degree
constexpr int kChecked = 3;       // height and slopes
constexpr int kMostSizes = 8;
constexpr int kLeastSamples = 2 * kCoefficients;
// Neighbourhoods are bounded, so that no sample looks at all the others: their radius does not grow
// for more noise than this (in spacings), nor for a spacing beyond so many times the median.
constexpr double kGreatestNoise = 1.0, kGreatestSpacing = 4.0;
// Variances of height and slopes for noise of 1, of a fit that says nothing (samples in a line).
constexpr double kGreatestVariance = 4.0;
constexpr int kPooled = 16;  // neighbours whose residuals make the noise around a sample

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using NormalEquations = Eigen::Matrix<double, kCoefficients, kCoefficients>;

// Sums over a neighbourhood, of which its quadric follows.
struct Moments {
  std::array<double, kPowers> power{};
  Coefficients height = Coefficients::Zero();
  double squares = 0.0;

  void add(double u, double v, double z) {
    const double uu = u * u, uv = u * v, vv = v * v;
    const std::array<double, kPowers> terms = {1.0,     u,       v,       uu,      uv,
                                               vv,      uu * u,  uu * v,  u * vv,  vv * v,
                                               uu * uu, uu * uv, uu * vv, uv * vv, vv * vv};
    for (std::size_t k = 0; k < kPowers; ++k) power[k] += terms[k];
    for (int k = 0; k < kCoefficients; ++k) height[k] += z * terms[static_cast<std::size_t>(k)];
    squares += z * z;
  }
  Moments& operator+=(const Moments& other) {
    for (std::size_t k = 0; k < kPowers; ++k) power[k] += other.power[k];
    height += other.height;
    squares += other.squares;
    return *this;
  }
  double count() const { return power[0]; }
  double freedom() const { return count() - kCoefficients; }
  NormalEquations matrix() const {
    static constexpr std::size_t kPowerOf[kCoefficients][kCoefficients] = {
        {0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
        {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};
    NormalEquations m;
    for (int row = 0; row < kCoefficients; ++row)
      for (int column = 0; column < kCoefficients; ++column)
        m(row, column) = power[kPowerOf[row][column]];
    return m;
  }
};

// The quadric of a neighbourhood.
struct Quadric {
  Coefficients coefficient;
  Coefficients variance;          // of the first kChecked coefficients, for noise of 1
  double squared_residual = 0.0;  // mean, freed of the bias of the fit
  bool is_valid = false;

  explicit Quadric(const Moments& moments) {
    if (moments.count() < kLeastSamples) return;
    const Eigen::LDLT<NormalEquations> solver(moments.matrix());
    coefficient = solver.solve(moments.height);
    for (int c = 0; c < kChecked; ++c) {
      const Coefficients column = solver.solve(Coefficients::Unit(c));
      variance[c] = std::max(column[c], 0.0);
    }
    squared_residual =
        std::max(moments.squares - coefficient.dot(moments.height), 0.0) / moments.freedom();
    is_valid = coefficient.allFinite() && variance.head<kChecked>().maxCoeff() <= kGreatestVariance;
  }
};

// What all neighbourhoods so far agree on.
class Agreement {
 public:
  Agreement() {
    low_.fill(-std::numeric_limits<double>::infinity());
    high_.fill(std::numeric_limits<double>::infinity());
  }
  // Narrows the intervals; false if one is empty then.
  bool add(const Quadric& quadric, double margin) {
    bool agree = true;
    for (int c = 0; c < kChecked; ++c) {
      const double half = margin * std::sqrt(quadric.variance[c]);
      low_[c] = std::max(low_[c], quadric.coefficient[c] - half);
      high_[c] = std::min(high_[c], quadric.coefficient[c] + half);
      agree = agree && low_[c] <= high_[c];
    }
    return agree;
  }

 private:
  Eigen::Array<double, kChecked, 1> low_, high_;
};

class Denoiser {
 public:
  Denoiser(const PointCloud& cloud, double noise, const DenoisingOptions& options)
      : cloud_(cloud), options_(options), sizes_(std::clamp(options.sizes, 1, kMostSizes)) {
    noise = std::min(noise, kGreatestNoise);
    double radius = options.first_radius + options.radius_per_noise * noise;
    least_cosine_ =
        static_cast<float>(std::max(options.least_cosine - options.cosine_per_noise * noise, 0.0));
    for (int size = 0; size < sizes_; ++size, radius *= options.growth)
      squared_radius_[size] = radius * radius;
  }

  // Where the surface passes each sample.
  std::vector<TangentPlane> planes(Progress& progress) const {
    std::vector<float> residual(cloud_.position.size());
    progress.set_range(0.0, 0.2);
    parallel_for_each(cloud_.size(), kGrain, progress,
                      [&](Index i) { residual[i] = residual_at(i); });
    std::vector<TangentPlane> planes(cloud_.position.size());
    progress.set_range(0.2, 0.8);
    parallel_for_each(cloud_.size(), kGrain, progress,
                      [&](Index i) { planes[i] = plane_at(i, pooled(residual, i)); });
    return planes;
  }

 private:
  // Height field over the tangent plane of a sample, in its local spacings.
  struct Axes {
    Vec3 origin, normal, u, v;
    double scale;
  };
  Axes axes_at(Index sample) const {
    const Vec3 normal = cloud_.normal[sample].cast<double>(), u = normal.unitOrthogonal();
    return {
        cloud_.position[sample], normal, u, normal.cross(u),
        1.0 / std::min<double>(cloud_.local_spacing[sample], kGreatestSpacing * cloud_.spacing)};
  }

  // The samples around one, by the smallest of `sizes` neighbourhoods that holds them: a cylinder
  // as high above and below the sample as it is wide.
  std::array<Moments, kMostSizes> rings_at(Index sample, const Axes& axes, int sizes) const {
    std::array<Moments, kMostSizes> rings;
    const double largest = squared_radius_[sizes - 1];
    const auto& points = cloud_.search.ordered_points();
    const double reach = std::sqrt(2.0 * largest) / axes.scale;
    cloud_.search.for_each_near_box(axes.origin, axes.origin, reach, [&](VoxelSearch::Range range) {
      for (Index i = range.begin; i < range.end; ++i) {
        const Vec3 offset = axes.scale * (points[i] - axes.origin);
        const double z = offset.dot(axes.normal);
        const double extent = std::max(offset.squaredNorm() - z * z, z * z);
        if (extent > largest) continue;
        const Index other = cloud_.search.ordered_index()[i];
        if (!(cloud_.normal[other].dot(cloud_.normal[sample]) > least_cosine_)) continue;
        int size = 0;
        while (extent > squared_radius_[size]) ++size;
        rings[size].add(offset.dot(axes.u), offset.dot(axes.v), z);
      }
      return true;
    });
    return rings;
  }

  // Of the smallest neighbourhood, in lengths of the cloud.
  float residual_at(Index sample) const {
    const Axes axes = axes_at(sample);
    const Quadric quadric(rings_at(sample, axes, 1)[0]);
    return quadric.is_valid ? static_cast<float>(std::sqrt(quadric.squared_residual) / axes.scale)
                            : 0.0f;
  }

  // The noise around a sample: root mean square of the residuals of its neighbours.
  double pooled(const std::vector<float>& residual, Index sample) const {
    const int count = std::min(kPooled, cloud_.neighbour_count);
    double sum = 0.0;
    for (int entry = 0; entry < count; ++entry) {
      const double r = residual[cloud_.neighbours_of(sample)[entry]];
      sum += r * r;
    }
    return std::sqrt(sum / count);
  }

  TangentPlane plane_at(Index sample, double noise) const {
    const Axes axes = axes_at(sample);
    const std::array<Moments, kMostSizes> rings = rings_at(sample, axes, sizes_);
    const double deviation = noise * axes.scale;
    TangentPlane plane{axes.origin.cast<float>(), cloud_.normal[sample]};
    Moments sum;
    Agreement agreement;
    bool is_first = true;
    for (int size = 0; size < sizes_; ++size) {
      sum += rings[size];
      const Quadric quadric(sum);
      if (!quadric.is_valid) continue;
      if (std::abs(quadric.coefficient[0]) > std::sqrt(squared_radius_[size])) break;
      const double expected =
          deviation * deviation * (1.0 + options_.misfit * std::sqrt(2.0 / sum.freedom()));
      const bool fits = is_first || quadric.squared_residual <= expected;
      if (!fits || !agreement.add(quadric, options_.confidence * deviation)) break;
      is_first = false;
      const Coefficients& q = quadric.coefficient;
      plane.point = (axes.origin + q[0] / axes.scale * axes.normal).cast<float>();
      plane.normal = (axes.normal - q[1] * axes.u - q[2] * axes.v).normalized().cast<float>();
    }
    return plane;
  }

  const PointCloud& cloud_;
  const DenoisingOptions& options_;
  int sizes_;
  float least_cosine_ = 0.0f;
  std::array<double, kMostSizes> squared_radius_{};  // x local spacing
};

}  // namespace

void denoise(PointCloud& cloud, double noise, int neighbours, const DenoisingOptions& options,
             Progress& progress) {
  const std::vector<TangentPlane> planes = Denoiser(cloud, noise, options).planes(progress);
  progress.set_range(0.8, 1.0);
  // Searches expect samples in the order of their places.
  std::vector<Vec3> moved(planes.size());
  for (Index i = 0; i < cloud.size(); ++i) moved[i] = planes[i].point.cast<double>();
  const std::vector<Index> order = morton_order(moved, progress);
  std::vector<Index> input_index(planes.size());
  cloud.plane.resize(planes.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = moved[order[i]];
    cloud.plane[i] = planes[order[i]];
    input_index[i] = cloud.input_index[order[i]];
  }
  cloud.input_index = std::move(input_index);
  cloud.search = VoxelSearch(cloud.position, progress);
  measure_neighbourhoods(cloud, neighbours, progress);
  for (Index i = 0; i < cloud.size(); ++i) cloud.normal[i] = cloud.plane[i].normal;
  cloud.index_before = order;
}

void undo_denoising(PointCloud& cloud, const std::vector<Vec3>& points, int neighbours,
                    Progress& progress) {
  std::vector<Index> input_index(cloud.input_index.size());
  std::vector<Vec3f> normal(cloud.normal.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    input_index[cloud.index_before[i]] = cloud.input_index[i];
    normal[cloud.index_before[i]] = cloud.normal[i];
  }
  for (Index i = 0; i < cloud.size(); ++i)
    cloud.position[i] = cloud.frame.to_unit(points[input_index[i]]);
  cloud.input_index = std::move(input_index);
  cloud.index_before = {};
  cloud.plane = {};
  cloud.search = VoxelSearch(cloud.position, progress);
  measure_neighbourhoods(cloud, neighbours, progress);
  cloud.normal = std::move(normal);
}

}  // namespace shrinkwrap
