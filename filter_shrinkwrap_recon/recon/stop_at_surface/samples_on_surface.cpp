#include "stop_at_surface/samples_on_surface.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "parametric_surface/sample_feet.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kAround = 7;  // the sample itself and its one-ring, about

Vec3 position_of(const SampleFoot& foot, const SurfaceMesh& surface) {
  const Triangle t = surface.triangle(foot.face);
  const double b = foot.weight_b, c = foot.weight_c;
  return (1.0 - b - c) * surface.position[t[0]] + b * surface.position[t[1]] +
         c * surface.position[t[2]];
}

double mean_around(const PointCloud& cloud, Index sample, const std::vector<double>& value) {
  double sum = 0.0;
  int count = 0;
  const Index* neighbour = cloud.neighbours_of(sample);
  for (int n = 0; n < std::min(kAround, cloud.neighbour_count); ++n) {
    if (!(cloud.normal[neighbour[n]].dot(cloud.normal[sample]) > 0.0f)) continue;
    sum += value[neighbour[n]];
    ++count;
  }
  return count > 0 ? sum / count : value[sample];
}

}  // namespace

SamplesOnSurface move_onto_surface(const SurfaceMesh& surface, const PointCloud& cloud,
                                   double noise, const SamplesOnSurfaceOptions& options,
                                   Progress& progress) {
  const Index samples = cloud.size();
  const SampleFeet feet = find_sample_feet(surface, cloud, progress);
  SamplesOnSurface result;
  result.position.resize(static_cast<std::size_t>(samples));
  std::vector<double> squared_distance(result.position.size());  // x local spacing
  parallel_for_each(samples, kGrain, progress, [&](Index i) {
    result.position[i] = position_of(feet.foot[i], surface);
    const double distance = (cloud.position[i] - result.position[i]).norm();
    squared_distance[i] = std::pow(distance / cloud.local_spacing[i], 2);
  });

  parallel_for_each(samples, kGrain, progress, [&](Index i) {
    const double around = cloud.noise_at(i, noise);
    const double left = around * (options.left + options.left_per_noise * around);
    const double mean = mean_around(cloud, i, squared_distance);
    const double moves = mean > left * left ? left * left / mean : 1.0;
    result.position[i] = cloud.position[i] + moves * (result.position[i] - cloud.position[i]);
  });
  std::vector<double> beyond_noise = squared_distance;
  parallel_for_each(samples, kGrain, progress, [&](Index i) {
    const double more = cloud.noise_at(i, noise) - noise;
    double& squared = beyond_noise[i];
    if (more > 0.0) squared = std::pow(std::max(std::sqrt(squared) - more, 0.0), 2);
  });
  const auto least_of_upper = [&](Index part, std::vector<double>& squared) {
    const auto least = squared.end() - (samples + part - 1) / part;
    std::nth_element(squared.begin(), least, squared.end());
    return std::sqrt(*least);
  };
  result.upper_fifth = least_of_upper(5, squared_distance);
  result.upper_twentieth = least_of_upper(20, squared_distance);
  result.fifth_beyond_noise = least_of_upper(5, beyond_noise);
  result.twentieth_beyond_noise = least_of_upper(20, beyond_noise);
  return result;
}

bool shows_its_samples(const SamplesOnSurface& samples, double noise,
                       const SamplesOnSurfaceOptions& options) {
  return samples.fifth_beyond_noise <= options.farthest_fifth * noise ||
         samples.twentieth_beyond_noise <= options.farthest_twentieth;
}

}  // namespace shrinkwrap
