#include "orientation/orientation.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "orientation/component_shape.h"
#include "orientation/component_sides.h"
#include "orientation/sample_views.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr double kSteepCosine = 0.3;  // with the way to the station: beyond doubt

// Takes the signs that neighbours and views agreed upon for the sets of samples that are to be
// turned (DisputedSigns::find_turned) by a coarse drawing and, unless that was of all samples, also
// by one so fine that hardly a wall is seen through. This one is not made if the coarse one turns
// nothing.
void follow_agreement(const NeighbourGraph& graph, const SampleViews& views,
                      const OrientationOptions& options, const SampleVotes& votes,
                      SpanningForest& forest, Progress& progress) {
  const Index count = graph.sample_count();
  const DisputedSigns disputed(graph, forest, progress);
  const auto find_turned = [&](const SampleVotes& judges) {
    return disputed.find_turned(judges, options.signs.least_majority, options.disputes);
  };
  std::vector<char> turned = find_turned(votes);
  if (std::find(turned.begin(), turned.end(), 1) == turned.end()) return;
  if (votes.drawn.size() < static_cast<std::size_t>(count)) {
    const std::vector<char> finely = find_turned(
        views.draw_evenly(options.judging_samples, options.judging_directions, progress));
    for (std::size_t set = 0; set < turned.size(); ++set) turned[set] &= finely[set];
  }
  for (Index i = 0; i < count; ++i)
    if (disputed.set_of(i) != kNone && turned[disputed.set_of(i)])
      forest.flipped[i] = !forest.flipped[i];
}

// Makes the signs of neighbours consistent.
SpanningForest turn_alike(PointCloud& cloud, const NeighbourGraph& graph, const SampleViews& views,
                          const OrientationOptions& options, SampleVotes& votes,
                          Progress& progress) {
  SpanningForest forest = span_normals(graph, votes, options.signs, progress);
  if (!forest.flipped_as_agreed.empty())
    follow_agreement(graph, views, options, votes, forest, progress);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    if (forest.flipped[i]) cloud.normal[i] = -cloud.normal[i];
  });
  for (std::size_t k = 0; k < votes.drawn.size(); ++k)
    if (forest.flipped[votes.drawn[k]]) votes.votes[k] = votes.votes[k].turned();
  return forest;
}

ComponentSides turn_outward(PointCloud& cloud, const SpanningForest& forest,
                            const SampleVotes& votes, const SampleViews& views,
                            const OrientationOptions& options, Progress& progress) {
  ComponentSides sides = find_component_sides(cloud, forest, votes, views, options, progress);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    if (sides.flip[forest.component_of_sample[i]]) cloud.normal[i] = -cloud.normal[i];
  });
  return sides;
}

// Again, by views from where the ground faces. Pre: oriented normals.
void turn_as_seen_from(const Vec3& front, PointCloud& cloud, const NeighbourGraph& graph,
                       const OrientationOptions& options, OrientationReport& report,
                       Progress& progress) {
  progress.set_range(0.7, 0.77);
  const SampleViews views(cloud, options, front, progress);
  SampleVotes votes =
      views.draw_evenly(options.propagation_samples, options.view_directions, progress);
  progress.set_range(0.77, 0.81);
  const SpanningForest forest = turn_alike(cloud, graph, views, options, votes, progress);
  progress.set_range(0.81, 0.85);
  const ComponentSides sides = turn_outward(cloud, forest, votes, views, options, progress);
  report.components = forest.components;
  report.enclosed_components = sides.enclosed;
  report.undecided_components = sides.undecided + 1;  // the ground itself
  report.ground = front;
}

// Each component as most of it faces the station, and then each sample that is seen steeply.
void turn_towards(const Vec3& station, PointCloud& cloud, const SpanningForest& forest,
                  Progress& progress) {
  const auto cosine = [&](Index i) {
    const Vec3 way = (station - cloud.position[i]).normalized();  // zero stays zero
    return cloud.normal[i].cast<double>().dot(way);
  };
  std::vector<double> towards(static_cast<std::size_t>(forest.components), 0.0);
  for (Index i = 0; i < cloud.size(); ++i) towards[forest.component_of_sample[i]] += cosine(i);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    Vec3f& normal = cloud.normal[i];
    if (towards[forest.component_of_sample[i]] < 0.0) normal = -normal;
    if (cosine(i) < -kSteepCosine) normal = -normal;
  });
}

// See PointCloud::closedness. What closes on itself has normals all around, be it sampled so
// sparsely that views see through it: a sheet is what has a mean normal of twice the least that
// sheets have, and less so what has a shorter one.
double closedness_of(const PointCloud& cloud, const SampleVotes& votes) {
  VisibilityVote on_all;
  for (const VisibilityVote& vote : votes.votes) on_all.add(vote);
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& normal : cloud.normal) sum += normal.cast<double>();
  const double beyond = sum.norm() / cloud.size() - kLeastSheetNormal;
  return std::max(on_all.trust(), 1.0 - std::clamp(beyond / kLeastSheetNormal, 0.0, 1.0));
}

// exp(-x) for x in [0, 2.5], within 0.2 %: four terms at a quarter of x.
inline float falling_exponential(float x) {
  const float y = 0.25f * x;
  const float growth = 1.0f + y * (1.0f + y * (0.5f + y * (1.0f / 6.0f + y * (1.0f / 24.0f))));
  const float squared = growth * growth;
  return 1.0f / (squared * squared);
}

TangentPlane tangent_plane(const PointCloud& cloud, int neighbours, Index sample) {
  const Vec3& origin = cloud.position[sample];
  const Vec3f& normal = cloud.normal[sample];
  const Index* list = cloud.neighbours_of(sample);
  const int count = std::min(neighbours, cloud.neighbour_count);
  const float reach = (cloud.position[list[count - 1]] - origin).cast<float>().squaredNorm();
  const float decay = reach > 0.0f ? 2.5f / reach : 0.0f;
  Vec3f offset = Vec3f::Zero(), mean_normal = normal;  // the sample itself, of weight 1
  float total = 1.0f;
  for (int entry = 1; entry < count; ++entry) {
    const Vec3f& other = cloud.normal[list[entry]];
    const float cosine = other.dot(normal);
    if (!(cosine > 0.1f)) continue;
    const Vec3f d = (cloud.position[list[entry]] - origin).cast<float>();
    const float weight = falling_exponential(decay * d.squaredNorm()) * cosine * cosine;
    offset += weight * d;
    mean_normal += weight * other;
    total += weight;
  }
  return {(origin + (offset / total).cast<double>()).cast<float>(), mean_normal.normalized()};
}

}  // namespace

OrientationReport orient_normals(PointCloud& cloud, const OrientationOptions& options,
                                 Progress& progress) {
  progress.begin(Stage::orientation);
  OrientationReport report;
  progress.set_range(0.0, 0.05);
  if (!cloud.conditioning.on_lines)
    report.poled =
        fit_pole_normals(cloud, scatter_of_samples(cloud, progress), options.poles, progress);
  progress.set_range(0.05, 0.25);
  const SampleViews views(cloud, options);
  SampleVotes votes =
      views.draw_evenly(options.propagation_samples, options.view_directions, progress);
  progress.set_range(0.25, 0.5);
  const NeighbourGraph graph(cloud, options.propagation_neighbours, progress);
  const SpanningForest forest = turn_alike(cloud, graph, views, options, votes, progress);
  progress.set_range(0.5, 0.7);
  const Vec3 origin = cloud.frame.to_unit(Vec3::Zero());
  report.components = forest.components;
  report.is_view = is_view_from(cloud, origin, options.station, progress);
  if (report.is_view) {
    turn_towards(origin, cloud, forest, progress);
  } else {
    const ComponentSides sides = turn_outward(cloud, forest, votes, views, options, progress);
    report.enclosed_components = sides.enclosed;
    report.undecided_components = sides.undecided;
    if (!sides.ground.isZero())
      turn_as_seen_from(sides.ground, cloud, graph, options, report, progress);
    report.turned = turn_inverted_patches(cloud, graph, votes, options.inverted, progress);
  }

  report.closedness = cloud.closedness = closedness_of(cloud, votes);

  progress.set_range(0.85, 0.95);
  if (graph.noise() <= options.most_noise_at_creases && !cloud.conditioning.on_lines)
    report.creased = fit_crease_planes(cloud, options.creases, progress);

  progress.set_range(0.95, 1.0);
  measure_tangent_planes(cloud, options.plane_neighbours, progress);
  return report;
}

void measure_tangent_planes(PointCloud& cloud, int neighbours, Progress& progress) {
  cloud.plane.resize(cloud.position.size());
  parallel_for_each(cloud.size(), kGrain, progress,
                    [&](Index i) { cloud.plane[i] = tangent_plane(cloud, neighbours, i); });
}

}  // namespace shrinkwrap
