#include "orientation/neighbour_graph.h"

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr Index kProbes = 1 << 16;  // samples that tell the noise, and of steps, about
// Bends of the surface look like noise as well, but not everywhere.
constexpr double kEvenest = 0.1;

constexpr float kLeastSlope = 0.5f;    // sine, of what leaves the sheet of a sample
constexpr float kOpposite = -0.36f;    // product of the ways to either sheet
constexpr double kLeastOfSteps = 0.5;  // part of the samples above each other
constexpr int kFewestInSheet = 3;      // neighbours of a sample that tell where its sheet lies

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

std::vector<int> places_of_edges(const PointCloud& cloud, int neighbours) {
  const int most = std::max(cloud.neighbour_count - 1, 0);
  const int count = std::min(std::max(neighbours, 1), most);
  const bool spread = cloud.conditioning.on_lines && count > 1;
  std::vector<int> places;
  for (int i = 0; i < count; ++i) places.push_back(1 + (spread ? i * (most - 1) / (count - 1) : i));
  return places;
}

}  // namespace

float scatter_of_samples(const PointCloud& cloud, Progress& progress) {
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

NeighbourGraph::NeighbourGraph(const PointCloud& cloud, int neighbours, Progress& progress)
    : cloud_(cloud),
      places_(places_of_edges(cloud, neighbours)),
      noise_(scatter_of_samples(cloud, progress)),
      has_steps_(finds_steps(progress)) {}

// From the foot of one sample on the plane of another to the neighbours of this one in its sheet:
// the mean way, x the mean of the lengths. Near 1 in length if the foot lies beyond the border of
// the sheet; 0 if there are too few to tell.
Vec3f NeighbourGraph::way_to_sheet(Index of, Index from) const {
  const Vec3& origin = cloud_.position[of];
  const Vec3f& normal = cloud_.normal[of];
  const Vec3f offset = (cloud_.position[from] - origin).cast<float>();
  const Vec3f foot = offset - offset.dot(normal) * normal;
  const Index* list = cloud_.neighbours_of(of);
  Vec3f sum = -foot;
  float lengths = foot.norm();
  int members = 0;
  for (int place = 1; place < cloud_.neighbour_count; ++place) {
    const Vec3f d = (cloud_.position[list[place]] - origin).cast<float>();
    const float height = d.dot(normal);
    if (std::abs(height) > kLeastSlope * d.norm() ||
        std::abs(normal.dot(cloud_.normal[list[place]])) < kParallel)
      continue;
    const Vec3f way = d - height * normal - foot;
    sum += way;
    lengths += way.norm();
    ++members;
  }
  return members < kFewestInSheet ? Vec3f(Vec3f::Zero()) : Vec3f(sum / lengths);
}

// Whether the sheets of two samples above each other lie on opposite sides of them. Those of a
// plate lie on top of each other, also at its rim.
bool NeighbourGraph::are_ends_of_step(Index a, Index b) const {
  return way_to_sheet(a, b).dot(way_to_sheet(b, a)) < kOpposite;
}

bool NeighbourGraph::finds_steps(Progress& progress) const {
  const Index stride = cloud_.size() / kProbes + 1;
  struct Count {
    Index steep = 0, steps = 0;
  };
  std::vector<Count> counts(static_cast<std::size_t>(block_count(cloud_.size(), stride)));
  parallel_for_each(static_cast<Index>(counts.size()), kGrain, progress, [&](Index probe) {
    const Index a = probe * stride;
    for_each_edge_of(a, [&](Index b) {
      const Edge edge = edge_between(a, b);
      // Nearer ones may be noise.
      const float spacing = 0.5f * (cloud_.local_spacing[a] + cloud_.local_spacing[b]);
      if (edge.length <= spacing || !edge.is_steep()) return;
      ++counts[probe].steep;
      counts[probe].steps += are_ends_of_step(a, b);
    });
  });
  Count sum;
  for (const Count& count : counts) {
    sum.steep += count.steep;
    sum.steps += count.steps;
  }
  return sum.steps > kLeastOfSteps * sum.steep;
}

}  // namespace shrinkwrap
