#include "denoising.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "morton.h"
#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 7;
constexpr int kCoefficients = 6;  // of a quadratic height field: 1, u, v, u^2, u v, v^2
constexpr int kMostSizes = 8;
constexpr int kLeastSamples = 2 * kCoefficients;

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using NormalEquations = Eigen::Matrix<double, kCoefficients, kCoefficients>;

// Sums over a neighbourhood from which its quadric is fitted.
struct Moments {
  std::array<double, 15> power{};  // of u and v up to the fourth degree, as listed in `matrix`
  Coefficients height = Coefficients::Zero();
  double squares = 0.0;

  void add(double u, double v, double z) {
    const double uu = u * u, uv = u * v, vv = v * v;
    const std::array<double, 15> terms = {1.0,     u,       v,       uu,      uv,
                                          vv,      uu * u,  uu * v,  u * vv,  vv * v,
                                          uu * uu, uu * uv, uu * vv, uv * vv, vv * vv};
    for (std::size_t k = 0; k < terms.size(); ++k) power[k] += terms[k];
    for (int k = 0; k < kCoefficients; ++k) height[k] += z * terms[static_cast<std::size_t>(k)];
    squares += z * z;
  }
  Moments& operator+=(const Moments& other) {
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += other.power[k];
    height += other.height;
    squares += other.squares;
    return *this;
  }
  double count() const { return power[0]; }
  NormalEquations matrix() const {
    static constexpr int kPower[kCoefficients][kCoefficients] = {
        {0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
        {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};
    NormalEquations m;
    for (int r = 0; r < kCoefficients; ++r)
      for (int c = 0; c < kCoefficients; ++c)
        m(r, c) = power[static_cast<std::size_t>(kPower[r][c])];
    return m;
  }
};

class Denoiser {
 public:
  Denoiser(const PointCloud& cloud, double noise, const DenoisingOptions& options)
      : cloud_(cloud), options_(options), noise_(noise),
        sizes_(std::clamp(options.neighbourhoods, 1, kMostSizes)) {
    double r = std::max(options.first_radius, 4.0 * noise);
    for (int j = 0; j < sizes_; ++j, r *= options.growth) squared_radius_[j] = r * r;
  }

  // Where the surface passes the sample.
  TangentPlane plane_at(Index sample, double* residual = nullptr) const {
    const Vec3& origin = cloud_.position[sample];
    const double scale = 1.0 / cloud_.local_spacing[sample];
    const Vec3 normal = cloud_.normal[sample].cast<double>();
    const Vec3 u_axis = normal.unitOrthogonal(), v_axis = normal.cross(u_axis);
    std::array<Moments, kMostSizes> ring;
    const double largest = squared_radius_[sizes_ - 1];
    cloud_.search.for_each_near_box(
        origin, origin, std::sqrt(largest) / scale, [&](VoxelSearch::Range range) {
          for (Index i = range.begin; i < range.end; ++i) {
            const Vec3 d = scale * (cloud_.search.ordered_points()[i] - origin);
            const double squared = d.squaredNorm();
            if (squared > 2.0 * largest) continue;
            const double z = d.dot(normal);
            const double extent = std::max(squared - z * z, z * z);
            if (extent > largest) continue;
            const Index other = cloud_.search.ordered_index()[i];
            if (!(cloud_.normal[other].dot(cloud_.normal[sample]) > 0.0f)) continue;
            int j = 0;
            while (extent > squared_radius_[j]) ++j;
            ring[j].add(d.dot(u_axis), d.dot(v_axis), z);
          }
          return true;
        });

    TangentPlane plane{origin.cast<float>(), cloud_.normal[sample]};
    std::array<double, 3> low, high;
    low.fill(-1e30);
    high.fill(1e30);
    const double sigma = sigma_.empty() ? noise_ : scale * sigma_[sample];
    Moments sum;
    bool first = true;
    for (int j = 0; j < sizes_; ++j) {
      sum += ring[j];
      if (sum.count() < kLeastSamples) continue;
      const Eigen::LDLT<NormalEquations> solver(sum.matrix());
      const Coefficients fit = solver.solve(sum.height);
      if (!fit.allFinite()) continue;
      const double freedom = sum.count() - kCoefficients;
      const double square = std::max(sum.squares - fit.dot(sum.height), 0.0) / freedom;
      if (residual) {
        *residual = std::sqrt(square) / scale;
        return plane;
      }
      if (!first && options_.residual > 0 &&
          square > sigma * sigma * (1.0 + options_.residual * std::sqrt(2.0 / freedom)))
        break;
      bool consistent = true;
      for (int c = 0; c < 3; ++c) {
        const double variance = solver.solve(Coefficients::Unit(c))[c];
        const double half = (c ? options_.slope : options_.confidence) * sigma * std::sqrt(std::max(variance, 0.0));
        low[c] = std::max(low[c], fit[c] - half);
        high[c] = std::min(high[c], fit[c] + half);
        if (low[c] > high[c]) consistent = false;
      }
      if (!consistent) break;
      first = false;
      plane.point = (origin + fit[0] / scale * normal).cast<float>();
      plane.normal = (normal - fit[1] * u_axis - fit[2] * v_axis).normalized().cast<float>();
    }
    return plane;
  }

  void measure_sigma(Progress& progress) {
    const int sizes = sizes_;
    sizes_ = 1;
    std::vector<double> residual(cloud_.position.size(), 0.0), sigma(residual.size());
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) { plane_at(i, &residual[i]); });
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      double sum = 0.0;
      const int k = std::min(16, cloud_.neighbour_count);
      for (int e = 0; e < k; ++e) {
        const double r = residual[cloud_.neighbours_of(i)[e]];
        sum += r * r;
      }
      sigma[i] = std::sqrt(sum / k);
    });
    sigma_ = std::move(sigma);
    sizes_ = sizes;
  }

 private:
  const PointCloud& cloud_;
  const DenoisingOptions& options_;
  double noise_;
  std::vector<double> sigma_;
  int sizes_;
  std::array<double, kMostSizes> squared_radius_{};
};

}  // namespace

void denoise(PointCloud& cloud, double noise, const DenoisingOptions& options, Progress& progress) {
  Denoiser denoiser(cloud, noise, options);
  if (options.local_sigma) denoiser.measure_sigma(progress);
  std::vector<TangentPlane> plane(cloud.position.size());
  parallel_for_each(cloud.size(), kGrain, progress,
                    [&](Index i) { plane[i] = denoiser.plane_at(i); });
  std::vector<Vec3> moved(plane.size());
  for (Index i = 0; i < cloud.size(); ++i) moved[i] = plane[i].point.cast<double>();
  const std::vector<Index> order = morton_order(moved, progress);
  std::vector<Index> input_index(plane.size());
  cloud.plane.resize(plane.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = moved[order[i]];
    cloud.plane[i] = plane[order[i]];
    input_index[i] = cloud.input_index[order[i]];
  }
  cloud.input_index = std::move(input_index);
  cloud.search = VoxelSearch(cloud.position, progress);
  measure_neighbourhoods(cloud, 16, progress);
  for (Index i = 0; i < cloud.size(); ++i) cloud.normal[i] = cloud.plane[i].normal;
  cloud.is_denoised = true;
}

}  // namespace shrinkwrap
