#include "neighbour_graph.h"

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr Index kProbes = 1 << 16;  // samples that tell the noise, about
// Bends of the surface look like noise as well, but not everywhere.
constexpr double kEvenest = 0.1;

// How far the neighbours of a sample scatter along its normal, x local spacing. They may be of two
// sheets, the sides of a plate or of a slot: so this is measured among those above their mean
// height and among those below it.
float scatter_at(const PointCloud& cloud, Index sample) {
  constexpr float kHalfNormal = 0.6028f;  // deviation within either half of a normal distribution
  const Index* list = cloud.neighbours_of(sample);
  const int count = cloud.neighbour_count;
  const auto height_of = [&](int place) {
    const Vec3 offset = cloud.position[list[place]] - cloud.position[sample];
    return offset.cast<float>().dot(cloud.normal[sample]);
  };
  float mean = 0.0f;
  for (int place = 0; place < count; ++place) mean += height_of(place) / static_cast<float>(count);
  float half_mean[2] = {0.0f, 0.0f}, squares[2] = {0.0f, 0.0f};
  int members[2] = {0, 0};
  for (int place = 0; place < count; ++place) {
    const float height = height_of(place) - mean;
    const int half = height > 0.0f;
    const float change = height - half_mean[half];  // Welford's update
    half_mean[half] += change / static_cast<float>(++members[half]);
    squares[half] += change * (height - half_mean[half]);
  }
  return std::sqrt((squares[0] + squares[1]) / static_cast<float>(count)) /
         (kHalfNormal * cloud.local_spacing[sample]);
}

float noise_of(const PointCloud& cloud, Progress& progress) {
  const Index stride = cloud.size() / kProbes + 1;
  std::vector<float> scatter(static_cast<std::size_t>(block_count(cloud.size(), stride)));
  if (scatter.empty()) return 0.0f;
  parallel_for_each(static_cast<Index>(scatter.size()), kGrain, progress,
                    [&](Index probe) { scatter[probe] = scatter_at(cloud, probe * stride); });
  const auto evenest =
      scatter.begin() + static_cast<std::ptrdiff_t>(kEvenest * static_cast<double>(scatter.size()));
  std::nth_element(scatter.begin(), evenest, scatter.end());
  return *evenest;
}

}  // namespace

NeighbourGraph::NeighbourGraph(const PointCloud& cloud, int neighbours, Progress& progress)
    : cloud_(cloud),
      neighbours_(std::min(std::max(neighbours, 1), std::max(cloud.neighbour_count - 1, 0))),
      noise_(noise_of(cloud, progress)) {}

}  // namespace shrinkwrap
