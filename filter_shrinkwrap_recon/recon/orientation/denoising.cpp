#include "orientation/denoising.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "common/parallel.h"
#include "geometry/morton.h"
#include "orientation/orientation.h"
#include "orientation/wide_normals.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 7;
constexpr int kCoefficients = 6;  // of a quadratic height field: 1, u, v, u^2, u v, v^2
constexpr int kPowers = 15;       // u^a v^b up to the fourth degree
constexpr int kKept = 3;          // height and slopes
constexpr int kMostSizes = 8;
constexpr int kLeastSamples = 2 * kCoefficients;
// Neighbourhoods are bounded, so that no sample looks at all the others: their radius does not grow
// for more noise than this (in spacings), nor for a spacing beyond so many times the median.
constexpr double kGreatestNoise = 1.0, kGreatestSpacing = 4.0;
// Nor are more samples looked at, as where all are closer than any spacing, or beside samples far
// denser than around the own one. Smaller neighbourhoods that hold no more were tried there: they
// smooth less, and the surface is farther off (a part moved by noise of a spacing: F-score 0.475
// so, 0.467 with them).
constexpr Index kMostLooks = 4096;
// Variances of height and slopes for noise of 1, of a fit that says nothing (samples in a line).
constexpr double kGreatestVariance = 4.0;
constexpr int kPooled = 16;  // neighbours over which residuals and energies are averaged ...
constexpr int kRounds = 3;   // ... the latter so many times in turn: over some 50 samples
// Where there is much detail most residuals are too large: this part of the samples has less noise
// than is taken for typical.
constexpr double kTypical = 0.3;
// A sample keeps of its height over the smallest quadric what exceeds so many times the square that
// is typical: most samples have more noise than the typical.
constexpr double kOwnEnergy = 1.5;
constexpr double kSameNoise = 2.0;        // noise of neighbours is about the same up to this factor
constexpr double kLeastVariance = 1e-12;  // of the noise, in squared local spacings

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;
using Kept = Eigen::Matrix<double, kKept, 1>;
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

// The quadratic height field over a neighbourhood.
struct HeightField {
  Coefficients coefficient;
  Kept variance;                  // of the first coefficients, for noise of 1
  double squared_residual = 0.0;  // mean, freed of the bias of the fit
  bool is_valid = false;

  explicit HeightField(const Moments& moments) {
    if (moments.count() < kLeastSamples) return;
    const Eigen::LDLT<NormalEquations> solver(moments.matrix());
    coefficient = solver.solve(moments.height);
    for (int c = 0; c < kKept; ++c) {
      const Coefficients column = solver.solve(Coefficients::Unit(c));
      variance[c] = std::max(column[c], 0.0);
    }
    squared_residual =
        std::max(moments.squares - coefficient.dot(moments.height), 0.0) / moments.freedom();
    is_valid = coefficient.allFinite() && variance.maxCoeff() <= kGreatestVariance;
  }
};

// What a quadric says of the surface at its sample, in its axes and local spacings; or how that
// changes from one size of neighbourhood to the next.
struct Shape {
  float height = 0.0f, u = 0.0f, v = 0.0f;  // the slopes along u and v

  friend Shape operator-(const Shape& a, const Shape& b) {
    return {a.height - b.height, a.u - b.u, a.v - b.v};
  }
};

// Squares of such a change over what noise alone explains. Negative: there is none.
struct Energy {
  float height = -1.0f, slope = -1.0f;

  bool is_known() const { return height >= 0.0f; }
};

// Where a sample goes.
struct Place {
  Vec3 position;
  Vec3f normal;
};

class Denoiser {
 public:
  Denoiser(const PointCloud& cloud, double noise, const DenoisingOptions& options)
      : cloud_(cloud),
        options_(options),
        sizes_(std::clamp(options.sizes, 1, kMostSizes)),
        noise_of_others_(noise) {}

  // Where the surface passes each sample.
  std::vector<Place> places(Progress& progress) {
    progress.set_range(0.0, 0.1);
    normal_ = cloud_.more_noise.empty() ? cloud_.normal : wide_normals(cloud_, progress);
    measure_noise(progress);
    measure_shapes(progress);
    for (int step = 0; step < sizes_; ++step) {
      progress.set_range(0.7 + 0.1 * step / sizes_, 0.7 + 0.1 * (step + 1) / sizes_);
      add_detail(step, progress);
    }
    std::vector<Place> places(cloud_.position.size());
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      const Axes axes = axes_at(i);
      const Shape& shape = shape_[i];
      const double height = shape.height - blur_at(i);
      places[i] = {axes.origin + height / axes.scale * axes.normal, normal_[i]};
      if (shape.u != 0.0f || shape.v != 0.0f)
        places[i].normal =
            (axes.normal - shape.u * axes.u - shape.v * axes.v).normalized().cast<float>();
    });
    return places;
  }

 private:
  // Height field over the tangent plane of a sample, in its local spacings.
  struct Axes {
    Vec3 origin, normal, u, v;
    double scale;
  };
  double scale_at(Index sample) const {
    return 1.0 / std::min<double>(cloud_.local_spacing[sample], kGreatestSpacing * cloud_.spacing);
  }
  Axes axes_at(Index sample) const {
    const Vec3 normal = normal_[sample].cast<double>(), u = normal.unitOrthogonal();
    return {cloud_.position[sample], normal, u, normal.cross(u), scale_at(sample)};
  }

  double noise_at(Index sample) const {
    return std::min(cloud_.noise_at(sample, noise_of_others_), kGreatestNoise);
  }
  float least_cosine_at(Index sample) const {
    return static_cast<float>(
        std::max(options_.least_cosine - options_.cosine_per_noise * noise_at(sample), 0.0));
  }
  // Squared, x local spacing.
  std::array<double, kMostSizes> radii_at(Index sample) const {
    std::array<double, kMostSizes> squared{};
    double radius = options_.first_radius + options_.radius_per_noise * noise_at(sample);
    for (int size = 0; size < sizes_; ++size, radius *= options_.growth)
      squared[size] = radius * radius;
    return squared;
  }

  // The samples around one, by the smallest of `sizes` neighbourhoods that holds them: a cylinder
  // as high above and below the sample as it is wide.
  std::array<Moments, kMostSizes> rings_at(Index sample, const Axes& axes, int sizes) const {
    std::array<Moments, kMostSizes> rings;
    const std::array<double, kMostSizes> squared_radius = radii_at(sample);
    const double largest = squared_radius[sizes - 1];
    const float least_cosine = least_cosine_at(sample);
    const auto& points = cloud_.search.ordered_points();
    const double reach = std::sqrt(2.0 * largest) / axes.scale;
    Index looks_left = kMostLooks;
    cloud_.search.for_each_near_box(axes.origin, axes.origin, reach, [&](VoxelSearch::Range range) {
      looks_left -= range.end - range.begin;
      for (Index i = range.begin; i < range.end; ++i) {
        const Vec3 offset = axes.scale * (points[i] - axes.origin);
        const double z = offset.dot(axes.normal);
        const double extent = std::max(offset.squaredNorm() - z * z, z * z);
        if (extent > largest) continue;
        const Index other = cloud_.search.ordered_index()[i];
        if (!(normal_[other].dot(normal_[sample]) > least_cosine)) continue;
        int size = 0;
        while (extent > squared_radius[size]) ++size;
        rings[size].add(offset.dot(axes.u), offset.dot(axes.v), z);
      }
      return looks_left > 0;
    });
    return rings;
  }

  // Of the smallest neighbourhood, in lengths of the cloud.
  float residual_at(Index sample) const {
    const Axes axes = axes_at(sample);
    const HeightField quadric(rings_at(sample, axes, 1)[0]);
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

  // Residuals of neighbours, and of them a noise for each sample.
  void measure_noise(Progress& progress) {
    std::vector<float> residual(cloud_.position.size());
    progress.set_range(0.1, 0.25);
    parallel_for_each(cloud_.size(), kGrain, progress,
                      [&](Index i) { residual[i] = residual_at(i); });
    noise_.resize(residual.size());
    progress.set_range(0.25, 0.3);
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      const float noise = static_cast<float>(pooled(residual, i) * scale_at(i));
      noise_[i] = std::isfinite(noise) ? noise : 0.0f;  // samples too near for a spacing
    });
    std::vector<float>& sorted = residual;  // no longer needed
    sorted = noise_;
    const auto typical =
        sorted.begin() + static_cast<std::ptrdiff_t>(kTypical * static_cast<double>(sorted.size()));
    std::nth_element(sorted.begin(), typical, sorted.end());
    typical_noise_ = *typical;
  }

  double typical_at(Index sample) const { return cloud_.noise_at(sample, typical_noise_); }
  // Little more or less than what is typical is typical: it may be detail, or chance.
  double less_detail(Index sample) const {
    const double noise = noise_[sample], typical = typical_at(sample);
    if (noise > options_.alike * typical) return noise / options_.alike;
    if (noise * options_.alike < typical) return noise * options_.alike;
    return typical;
  }

  // The quadrics of all sizes at each sample: the widest, and the steps from each to the next, with
  // that to the sample itself before the first.
  void measure_shapes(Progress& progress) {
    shape_.assign(cloud_.position.size(), {});
    bend_.assign(cloud_.position.size(), 0.0f);
    for (int step = 0; step < sizes_; ++step) {
      step_[step].assign(cloud_.position.size(), {});
      energy_[step].assign(cloud_.position.size(), {});
    }
    progress.set_range(0.3, 0.7);
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) { measure_shapes_at(i); });
  }

  void measure_shapes_at(Index sample) {
    const Axes axes = axes_at(sample);
    const std::array<Moments, kMostSizes> rings = rings_at(sample, axes, sizes_);
    const double noise = less_detail(sample);
    const double squared_noise = noise * noise + kLeastVariance;
    const double most = std::max<double>(noise, noise_[sample]);
    const std::array<double, kMostSizes> squared_radius = radii_at(sample);
    const double typical = typical_at(sample);
    Moments sum;
    Kept smaller_variance = Kept::Zero();
    bool is_first = true;
    for (int size = 0; size < sizes_; ++size) {
      sum += rings[size];
      const HeightField quadric(sum);
      if (!quadric.is_valid && is_first) continue;
      if (!quadric.is_valid || std::abs(quadric.coefficient[0]) > std::sqrt(squared_radius[size]))
        break;
      const double expected =
          most * most * (1.0 + options_.misfit * std::sqrt(2.0 / sum.freedom()));
      if (!is_first && quadric.squared_residual > expected) break;
      const Shape shape = {static_cast<float>(quadric.coefficient[0]),
                           static_cast<float>(quadric.coefficient[1]),
                           static_cast<float>(quadric.coefficient[2])};
      if (is_first) {
        // The sample has a height, which is part of the fit, and no slopes. Beside an edge that no
        // quadric fits it is the detail that makes the residuals.
        const double spare = kOwnEnergy * (1.0 - std::min(quadric.variance[0], 1.0)) *
                                 (typical * typical + kLeastVariance) +
                             kLeastVariance;
        step_[0][sample] = {-shape.height, 0.0f, 0.0f};
        energy_[0][sample] = {
            static_cast<float>(static_cast<double>(shape.height) * shape.height / spare), 0.0f};
      } else {
        const Shape step = shape_[sample] - shape;
        // Of a nested pair the difference varies by the difference of the variances.
        const Kept spare =
            (smaller_variance - quadric.variance).cwiseMax(kLeastVariance) * squared_noise;
        step_[size][sample] = step;
        energy_[size][sample] = {
            static_cast<float>(step.height * step.height / spare[0]),
            static_cast<float>((step.u * step.u + step.v * step.v) / (spare[1] + spare[2]))};
      }
      shape_[sample] = shape;
      bend_[sample] = static_cast<float>(quadric.coefficient[3] + quadric.coefficient[5]);
      smaller_variance = quadric.variance;
      is_first = false;
    }
  }

  // How much higher heights are in the mean around a sample than the surface there, since samples
  // have also moved along it, by about as much: noise blurs what is curved, as heat would spread.
  double blur_at(Index sample) const {
    const float least_cosine = least_cosine_at(sample);
    double sum = 0.0, count = 0.0;
    for (int entry = 0; entry < std::min(kPooled, cloud_.neighbour_count); ++entry) {
      const Index other = cloud_.neighbours_of(sample)[entry];
      if (other != sample && !(normal_[other].dot(normal_[sample]) > least_cosine)) continue;
      sum += bend_[other] * scale_at(other);
      count += scale_at(sample);
    }
    // No more than there is around the sample: what is clean stays.
    const double noise =
        options_.tangential_noise * std::min(typical_at(sample), less_detail(sample));
    const double most = options_.most_blur * noise;
    return std::clamp(noise * noise * sum / count, -most, most);
  }

  // Mean over the neighbours that look the same way and have about as much noise around them: where
  // there is hardly any, a step is many times what that explains, and would tell nothing here.
  Energy mean_energy(const std::vector<Energy>& energy, Index sample) const {
    if (!energy[sample].is_known()) return {};
    const float least_cosine = least_cosine_at(sample);
    const double noise = noise_at(sample);
    Energy sum{0.0f, 0.0f};
    float count = 0.0f;
    for (int entry = 0; entry < std::min(kPooled, cloud_.neighbour_count); ++entry) {
      const Index other = cloud_.neighbours_of(sample)[entry];
      const double others = noise_at(other);
      if (!energy[other].is_known() || others > kSameNoise * noise || noise > kSameNoise * others ||
          !(other == sample || normal_[other].dot(normal_[sample]) > least_cosine))
        continue;
      sum.height += energy[other].height;
      sum.slope += energy[other].slope;
      count += 1.0f;
    }
    return {sum.height / count, sum.slope / count};
  }

  // Of a step the part that is more than noise.
  void add_detail(int step, Progress& progress) {
    std::vector<Energy>& energy = energy_[step];
    std::vector<Energy> mean(energy.size());
    for (int round = 0; round < kRounds; ++round) {
      parallel_for_each(cloud_.size(), kGrain, progress,
                        [&](Index i) { mean[i] = mean_energy(energy, i); });
      energy.swap(mean);
    }
    const auto part = [](float e) { return e > 1.0f ? 1.0f - 1.0f / e : 0.0f; };
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      if (!energy[i].is_known()) return;
      const Shape& change = step_[step][i];
      const float of_slope = part(energy[i].slope);
      shape_[i].height += part(energy[i].height) * change.height;
      shape_[i].u += of_slope * change.u;
      shape_[i].v += of_slope * change.v;
    });
    energy = {};
    step_[step] = {};
  }

  const PointCloud& cloud_;
  const DenoisingOptions& options_;
  int sizes_;
  double noise_of_others_;
  std::vector<Vec3f> normal_;  // of each sample
  std::vector<float> noise_;   // of the neighbours of each, x local spacing
  double typical_noise_ = 0.0;
  std::vector<Shape> shape_;  // of each sample
  std::vector<float> bend_;   // half the Laplacian of the widest quadric of each
  // Of each sample: entry s is the step from size s to the next smaller one, or to the sample.
  std::array<std::vector<Shape>, kMostSizes> step_;
  std::array<std::vector<Energy>, kMostSizes> energy_;
};

}  // namespace

DenoisingReport denoise(PointCloud& cloud, double noise, int neighbours,
                        const DenoisingOptions& options, Progress& progress) {
  std::vector<Place> places = Denoiser(cloud, noise, options).places(progress);
  progress.set_range(0.8, 1.0);
  DenoisingReport report;
  // Searches expect samples in the order of their places.
  std::vector<Vec3> moved(places.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    moved[i] = places[i].position;
    const double distance = (moved[i] - cloud.position[i]).norm() / cloud.spacing;
    if (distance > 0.0) ++report.moved;
    report.mean_displacement += distance / cloud.size();
    report.max_displacement = std::max(report.max_displacement, distance);
  }
  const std::vector<Index> order = morton_order(moved, progress);
  // The cloud that was stays as it is until the new one is complete.
  PointCloud next;
  next.frame = cloud.frame;
  next.conditioning = cloud.conditioning;
  next.closedness = cloud.closedness;
  next.position.resize(places.size());
  next.input_index.resize(places.size());
  next.plane.resize(places.size());
  next.more_noise.resize(cloud.more_noise.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    const Place& place = places[order[i]];
    next.position[i] = place.position;
    next.plane[i] = {place.position.cast<float>(), place.normal};
    next.input_index[i] = cloud.input_index[order[i]];
    if (!next.more_noise.empty()) next.more_noise[i] = cloud.more_noise[order[i]];
  }
  places = {};
  moved = {};
  next.search = VoxelSearch(next.position, progress);
  measure_neighbourhoods(next, neighbours, progress);
  for (Index i = 0; i < next.size(); ++i) next.normal[i] = next.plane[i].normal;
  next.index_before = order;
  cloud = std::move(next);
  return report;
}

void undo_denoising(PointCloud& cloud, const std::vector<Vec3>& points, int neighbours,
                    int plane_neighbours, Progress& progress) {
  std::vector<Index> input_index(cloud.input_index.size());
  std::vector<Vec3f> normal(cloud.normal.size());
  std::vector<float> more_noise(cloud.more_noise.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    input_index[cloud.index_before[i]] = cloud.input_index[i];
    normal[cloud.index_before[i]] = cloud.normal[i];
    if (!more_noise.empty()) more_noise[cloud.index_before[i]] = cloud.more_noise[i];
  }
  for (Index i = 0; i < cloud.size(); ++i)
    cloud.position[i] = cloud.frame.to_unit(points[input_index[i]]);
  cloud.input_index = std::move(input_index);
  cloud.more_noise = std::move(more_noise);
  cloud.index_before.clear();
  cloud.search = VoxelSearch(cloud.position, progress);
  measure_neighbourhoods(cloud, neighbours, progress);
  cloud.normal = std::move(normal);
  measure_tangent_planes(cloud, plane_neighbours, progress);
}

}  // namespace shrinkwrap
