#include "orientation/sample_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/parallel.h"
#include "geometry/voxel_search.h"
#include "orientation/visibility.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr double kDepthTolerance = 0.7;  // x spacing of the samples drawn
constexpr double kLevelCosine = 0.5;     // with the way that ground faces
constexpr double kSmooth = 0.2;          // deviation, x local spacing: crowns of trees have more
constexpr double kAbove = 3.0;           // x local spacing: another sheet, be it noisy
constexpr double kBeside = 1.5;          // x local spacing, seen along that way: the nearest sample
constexpr double kMostSpacing = 8.0;     // x that of the cloud: of strays it may be any

}  // namespace

SampleViews::SampleViews(const PointCloud& cloud, const OrientationOptions& options)
    : cloud_(cloud), options_(options) {}

SampleViews::SampleViews(const PointCloud& cloud, const OrientationOptions& options,
                         const Vec3& front, Progress& progress)
    : cloud_(cloud), options_(options), front_(front) {
  find_sides_above_others(progress);
}

void SampleViews::find_sides_above_others(Progress& progress) {
  const auto plan_of = [&](const Vec3& p) { return Vec3(p - p.dot(front_) * front_); };
  std::vector<Vec3> plan;
  plan.reserve(cloud_.position.size());
  for (const Vec3& p : cloud_.position) plan.push_back(plan_of(p));
  const VoxelSearch search(std::move(plan), progress);
  side_above_others_.assign(cloud_.position.size(), 0);
  parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
    const double cosine = height_cosine(i), spacing = cloud_.local_spacing[i];
    if (!(std::abs(cosine) > kLevelCosine) || cloud_.deviation[i] > kSmooth * spacing) return;
    const Vec3& p = cloud_.position[i];
    const double beside = kBeside * std::min(spacing, kMostSpacing * cloud_.spacing);
    const VoxelSearch::Hit below = search.nearest_if(plan_of(p), beside, [&](Index j) {
      return (p - cloud_.position[j]).dot(front_) > kAbove * spacing;
    });
    if (below.index != kNone) side_above_others_[i] = cosine > 0.0 ? 1 : -1;
  });
}

SampleVotes SampleViews::draw_evenly(Index most, int directions, Progress& progress) const {
  const Index stride = (cloud_.size() - 1) / std::max<Index>(most, 1) + 1;
  std::vector<Index> drawn;
  for (Index i = 0; i < cloud_.size(); i += stride) drawn.push_back(i);
  SampleVotes samples = draw(std::move(drawn), stride, directions, progress);
  keep_sides(samples);
  return samples;
}

SampleVotes SampleViews::draw(std::vector<Index> drawn, Index stride, int directions,
                              Progress& progress,
                              const std::vector<Index>* component_of_sample) const {
  const double spacing = cloud_.spacing * std::sqrt(static_cast<double>(stride));
  VisibilityOptions views;
  views.directions = directions;
  views.front = front_;
  views.min_cosine = options_.min_cosine;
  views.pixel = options_.pixel_size * spacing;
  views.depth_tolerance = kDepthTolerance * spacing;
  SampleVotes samples{std::move(drawn), {}};
  samples.votes = visibility_votes(cloud_, samples.drawn, views, progress, component_of_sample);
  return samples;
}

void SampleViews::keep_sides(SampleVotes& samples) const {
  if (!are_from_one_side()) return;
  for (std::size_t k = 0; k < samples.drawn.size(); ++k) {
    const Index i = samples.drawn[k];
    const double side = height_cosine(i) * side_above_others_[i];
    if (side != 0.0) {
      double& outward = samples.votes[k].outward;
      outward = std::copysign(outward, side);
    }
  }
}

}  // namespace shrinkwrap
