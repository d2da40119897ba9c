#include "parametric_surface/sample_feet.h"

#include <cmath>

#include "common/parallel.h"
#include "mesh/face_tree.h"

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

SampleFeet find_sample_feet(const SurfaceMesh& surface, const PointCloud& cloud,
                            Progress& progress) {
  const FaceTree tree(surface, progress);
  const Index samples = cloud.size(), faces = surface.face_slots();
  SampleFeet feet;
  feet.foot.resize(static_cast<std::size_t>(samples));

  // Samples come along a Morton curve: the face of the last one bounds the search for the next.
  const auto find_block = [&](Index begin, Index end) {
    DistanceSum distances;
    Index hint = kNone;
    FaceTree::Anchor anchor;
    for (Index i = begin; i < end; ++i) {
      if (i % kPollInterval == 0) progress.update(0.0);
      const Vec3& p = cloud.position[i];
      const Vec3 normal = cloud.normal[i].cast<double>();
      const auto any = [](Index) { return true; };
      const auto is_compatible = [&](Index f) { return surface.area_vector(f).dot(normal) > 0.0; };
      const double unlimited = std::numeric_limits<double>::infinity();
      FaceTree::Hit hit = tree.nearest(p, unlimited, hint, any, anchor);
      if (hit.face == kNone) hit.face = 0;  // every distance overflowed: any face will do
      hint = hit.face;
      if (!is_compatible(hit.face)) {
        const double limit = std::sqrt(hit.squared_distance) + kSurplus * cloud.spacing;
        const FaceTree::Hit other = tree.nearest(p, limit * limit, kNone, is_compatible, anchor);
        if (other.face != kNone) hit = other;
      }
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
