#include "samples/noise.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "samples/quadric_deviation.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 32;
constexpr Index kSamplesPerProbe = 4;  // of small clouds

NoiseEstimate estimate_with(const PointCloud& cloud, Index stride, int neighbours,
                            Progress& progress) {
  std::vector<QuadricDeviation> probes(static_cast<std::size_t>(cloud.size() / stride));
  parallel_for_each(static_cast<Index>(probes.size()), kGrain, progress,
                    [&](Index n) { probes[n] = quadric_deviation(cloud, n * stride, neighbours); });
  SortedDeviations sorted;
  for (const QuadricDeviation& deviation : probes) sorted.add(deviation);
  sorted.sort();
  if (sorted.is_empty()) return {};
  return {std::sqrt(variance_of_noise(sorted.at(0.5), neighbours)),
          std::sqrt(sorted.at(0.8).wide),
          {},
          {}};
}

}  // namespace

NoiseEstimate estimate_noise(const PointCloud& cloud, const NoiseOptions& options,
                             Progress& progress) {
  const Index probes =
      std::clamp<Index>(cloud.size() / kSamplesPerProbe, 1, std::max<Index>(options.probes, 1));
  const Index stride = std::max<Index>(cloud.size() / probes, 1);
  int neighbours = std::max(cloud.neighbour_count, QuadricDeviation::kLeastNeighbours);
  NoiseEstimate noise = estimate_with(cloud, stride, neighbours, progress);
  for (int round = 0; round < QuadricDeviation::kMostRounds; ++round) {
    const int wider = neighbours_for_noise(noise.median * noise.median);
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
