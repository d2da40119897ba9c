#include "parametric_surface/sample_feet.h"

#include <cmath>
#include <limits>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr Index kPollInterval = 8;  // a search that looks at all faces takes a millisecond
constexpr double kSurplus = 3.0;    // x spacing: how much farther a compatible foot may be

struct DistanceSum {
  double sum = 0.0, largest = 0.0;
  DistanceSum& operator+=(const DistanceSum& other) {
    sum += other.sum;
    largest = std::max(largest, other.largest);
    return *this;
  }
};

}  // namespace

FaceTree::Hit FootSearch::nearest(const Vec3& p) {
  const auto any = [](Index) { return true; };
  const double unlimited = std::numeric_limits<double>::infinity();
  FaceTree::Hit hit = tree_.nearest(p, unlimited, hint_, any, anchor_);
  if (hit.face == kNone) hit.face = 0;
  hint_ = hit.face;
  return hit;
}

FaceTree::Hit FootSearch::nearest_facing(const Vec3& p, const Vec3& normal) {
  const auto is_compatible = [&](Index f) { return surface_.area_vector(f).dot(normal) > 0.0; };
  const FaceTree::Hit hit = nearest(p);
  if (is_compatible(hit.face)) return hit;
  const double limit = std::sqrt(hit.squared_distance) + kSurplus * spacing_;
  const FaceTree::Hit other = tree_.nearest(p, limit * limit, kNone, is_compatible, anchor_);
  return other.face == kNone ? hit : other;
}

SampleFeet find_sample_feet(const SurfaceMesh& surface, const PointCloud& cloud,
                            Progress& progress) {
  const FaceTree tree(surface, progress);
  const Index samples = cloud.size(), faces = surface.face_slots();
  SampleFeet feet;
  feet.foot.resize(static_cast<std::size_t>(samples));

  const auto find_block = [&](Index begin, Index end) {
    DistanceSum distances;
    FootSearch search(surface, tree, cloud.spacing);  // samples come along a Morton curve
    for (Index i = begin; i < end; ++i) {
      if (i % kPollInterval == 0) progress.update(0.0);
      const FaceTree::Hit hit =
          search.nearest_facing(cloud.position[i], cloud.normal[i].cast<double>());
      feet.foot[i] = {hit.face, static_cast<float>(hit.weight_b), static_cast<float>(hit.weight_c)};
      const double distance = std::sqrt(hit.squared_distance);
      distances += {distance, distance};
    }
    return distances;
  };
  const DistanceSum distances = parallel_sum(samples, kGrain, progress, DistanceSum{}, find_block);
  feet.mean_distance = distances.sum / samples / cloud.spacing;
  feet.max_distance = distances.largest / cloud.spacing;

  feet.begin.assign(static_cast<std::size_t>(faces) + 1, 0);
  for (const SampleFoot& foot : feet.foot) ++feet.begin[foot.face + 1];
  for (Index f = 0; f < faces; ++f) feet.begin[f + 1] += feet.begin[f];
  // Filling moves each begin to its face's end; shifting by one brings the begins back.
  feet.by_face.resize(feet.foot.size());
  for (Index i = 0; i < samples; ++i) feet.by_face[feet.begin[feet.foot[i].face]++] = i;
  for (Index f = faces; f > 0; --f) feet.begin[f] = feet.begin[f - 1];
  feet.begin[0] = 0;
  return feet;
}

}  // namespace shrinkwrap
