#include "samples/more_noise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/parallel.h"
#include "samples/neighbourhoods.h"
#include "samples/quadric_deviation.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 32;
constexpr Index kStride = 4;  // of the samples, in Morton order, one is a probe
// Probes, around each. On which side they are is not asked, as noise turns normals.
constexpr int kPooled = 24;
constexpr double kGreatestNoise = 1.0;  // more is not told by its deviations
constexpr double kFew = 0.2;            // a part of the probes around
// It is surely noise all around if it is at so many of the probes there.
constexpr double kMost = 0.75;
constexpr int kReach = 2;  // x the probes around, beyond such places
constexpr std::size_t kNearest = 10, kOnPlane = 7;
constexpr double kLeastSine = 0.25;  // of the way to two others, whose plane it is
constexpr float kUnknown = -1.0f;

// How far, in local spacings, a sample and some of the nearest are from a plane, that which is
// nearest to them: all planes through the sample and two of the others are tried.
float distance_from_plane(const PointCloud& cloud, Index sample) {
  std::vector<VoxelSearch::Hit> nearest;
  cloud.search.k_nearest(cloud.position[sample], kNearest, nearest);
  const std::size_t count = nearest.size();
  if (count < kOnPlane) return kUnknown;
  const double scale = 1.0 / cloud.local_spacing[sample];
  std::array<Vec3, kNearest> offset;
  for (std::size_t n = 0; n < count; ++n)
    offset[n] = scale * (cloud.position[nearest[n].index] - cloud.position[sample]);
  double least = kUnknown;
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a + 1; b < count; ++b) {
      const Vec3 across = offset[a].cross(offset[b]);
      const double sine = across.norm();
      if (!(sine > kLeastSine * offset[a].norm() * offset[b].norm())) continue;
      std::array<double, kNearest> height;
      for (std::size_t n = 0; n < count; ++n) height[n] = std::abs(across.dot(offset[n])) / sine;
      const auto last = height.begin() + (kOnPlane - 1);
      std::nth_element(height.begin(), last, height.begin() + static_cast<std::ptrdiff_t>(count));
      if (least == kUnknown || *last < least) least = *last;
    }
  return static_cast<float>(least);
}

// Zero of none.
float quantile_of(std::vector<float> values, double part) {
  if (values.empty()) return 0.0f;
  const double last = static_cast<double>(values.size() - 1);
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(std::clamp(part * values.size(), 0.0, last));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class NoiseField {
 public:
  NoiseField(const PointCloud& cloud, Progress& progress)
      : cloud_(cloud), place_(static_cast<std::size_t>((cloud.size() + kStride - 1) / kStride)) {
    for (Index n = 0; n < size(); ++n) place_[n] = cloud.position[n * kStride];
    search_ = VoxelSearch(place_, progress);
    around_ = find_neighbourhoods(place_, search_, kPooled, progress);
    measure_noise(progress);
  }

  // Around each sample, that of the nearest probe.
  std::vector<float> at_samples(Progress& progress) const {
    std::vector<float> noise(cloud_.position.size());
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      noise[i] = noise_[search_.nearest(cloud_.position[i]).index];
    });
    return noise;
  }

  // A part of the probes has less.
  float quantile(double part) const { return quantile_of(noise_, part); }

  // Sets all that is not more than `from`, or may be fine detail, to zero. Returns the median of
  // what there was.
  float keep_more_than(double from, double least_roughness, Progress& progress) {
    const std::vector<float> all = noise_;
    for (float& noise : noise_)
      if (!(noise > from)) noise = 0.0f;
    keep_what_is_sure(least_roughness, progress);
    std::vector<float> others;
    for (Index n = 0; n < size(); ++n)
      if (noise_[n] == 0.0f) others.push_back(all[n]);
    return quantile_of(std::move(others), 0.5);
  }

 private:
  Index size() const { return static_cast<Index>(place_.size()); }
  Index around(Index probe, int entry) const {
    return around_.neighbour[static_cast<std::size_t>(probe) * around_.k + entry];
  }

  void measure_noise(Progress& progress) {
    std::vector<QuadricDeviation> deviation(place_.size());
    std::vector<int> neighbours(place_.size(), 0);
    std::vector<int> asked(place_.size(),
                           std::max(cloud_.neighbour_count, QuadricDeviation::kLeastNeighbours));
    noise_.assign(place_.size(), 0.0f);
    // Rounds of wider neighbourhoods, where there is noise that asks for them.
    for (int round = 0; round <= QuadricDeviation::kMostRounds && asked != neighbours; ++round) {
      parallel_for_each(size(), kGrain, progress, [&](Index n) {
        if (asked[n] != neighbours[n])
          deviation[n] = quadric_deviation(cloud_, n * kStride, asked[n]);
      });
      neighbours = asked;
      parallel_for_each(size(), kGrain, progress, [&](Index n) {
        const double variance = variance_of_noise(median_around(n, deviation), neighbours[n]);
        const double noise = std::sqrt(variance);
        noise_[n] = static_cast<float>(noise);
        asked[n] = std::max(asked[n], neighbours_for_noise(variance));
      });
    }
  }

  // Of those probes around one of which both sizes are known, if they are half of them.
  QuadricDeviation median_around(Index probe,
                                 const std::vector<QuadricDeviation>& deviation) const {
    SortedDeviations both, wide;
    int known = 0;
    for (int entry = 0; entry < around_.k; ++entry) {
      const QuadricDeviation& other = deviation[around(probe, entry)];
      wide.add({QuadricDeviation::kUnknown, other.wide});
      if (other.narrow == QuadricDeviation::kUnknown) continue;
      both.add(other);
      ++known;
    }
    SortedDeviations& taken = 2 * known >= around_.k ? both : wide;
    taken.sort();
    return taken.at(0.5);
  }

  void keep_what_is_sure(double least_roughness, Progress& progress) {
    std::vector<float> distance(place_.size());
    parallel_for_each(size(), kGrain, progress,
                      [&](Index n) { distance[n] = distance_from_plane(cloud_, n * kStride); });
    std::vector<char> is_sure(place_.size()), is_near(place_.size());
    parallel_for_each(size(), kGrain, progress,
                      [&](Index n) { is_sure[n] = is_rough(n, distance, least_roughness); });
    parallel_for_each(size(), kGrain, progress, [&](Index n) {
      int sure = 0;
      for (int entry = 0; entry < around_.k; ++entry) sure += is_sure[around(n, entry)];
      is_near[n] = sure >= kMost * around_.k;
    });
    for (int round = 0; round < kReach; ++round) {
      is_sure = is_near;
      parallel_for_each(size(), kGrain, progress, [&](Index n) {
        for (int entry = 0; entry < around_.k; ++entry)
          is_near[n] = is_near[n] || is_sure[around(n, entry)];
      });
    }
    for (Index n = 0; n < size(); ++n)
      if (!is_near[n]) noise_[n] = 0.0f;
  }

  bool is_rough(Index probe, const std::vector<float>& distance, double least_roughness) const {
    if (noise_[probe] == 0.0f) return false;
    std::vector<float> known;
    for (int entry = 0; entry < around_.k; ++entry)
      if (distance[around(probe, entry)] != kUnknown)
        known.push_back(distance[around(probe, entry)]);
    return !known.empty() && quantile_of(std::move(known), kFew) >= least_roughness * noise_[probe];
  }

  const PointCloud& cloud_;
  std::vector<Vec3> place_;  // of each probe
  VoxelSearch search_;
  Neighbourhoods around_;
  std::vector<float> noise_;  // x local spacing
};

}  // namespace

MoreNoise measure_more_noise(PointCloud& cloud, double noise, const MoreNoiseOptions& options,
                             Progress& progress) {
  MoreNoise result;
  result.others = noise;
  cloud.more_noise.assign(cloud.position.size(), 0.0f);
  if (!(options.from <= kGreatestNoise)) return result;
  NoiseField field(cloud, progress);
  const double half = field.quantile(0.5), calm = field.quantile(options.calm_part);
  // There is less in half of it where layers were counted as noise, too.
  const bool has_calm_part = half >= noise && calm < options.calm_times * half;
  const double from = std::max(options.times * (has_calm_part ? calm : noise), options.from);
  if (from > kGreatestNoise) return result;
  const double others = field.keep_more_than(from, options.least_roughness, progress);
  cloud.more_noise = field.at_samples(progress);
  std::vector<float> more;
  for (const float here : cloud.more_noise)
    if (here > 0.0f) more.push_back(here);
  if (more.empty()) return result;
  if (has_calm_part) result.others = std::min(noise, others);
  result.samples = static_cast<Index>(more.size());
  result.part = static_cast<double>(result.samples) / cloud.size();
  result.median = quantile_of(std::move(more), 0.5);
  return result;
}

}  // namespace shrinkwrap
