#include "membranes.h"

#include <algorithm>
#include <cmath>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kBeyond = 1.1;  // x `membrane_high`: farther samples are not looked for

// Per vertex, in spacings: 0 where that is at most `membrane_low`, which the foot of a sample
// nearby may show; as far as it matters, a little beyond `membrane_high`.
struct Distances {
  std::vector<float> any;       // from the samples
  std::vector<float> own_side;  // from those that look to the same side
};

Distances measure(const SurfaceMesh& surface, const SampleFeet& feet, const PointCloud& cloud,
                  const CompleteMatchingOptions& options, Progress& progress) {
  Distances distances;
  distances.any.resize(surface.position.size(), 0.0f);
  distances.own_side.resize(surface.position.size(), 0.0f);
  // Planes through all the samples there are tell no side.
  const bool has_sides = cloud.size() > cloud.neighbour_count;
  const double low = options.membrane_low, beyond = kBeyond * options.membrane_high;
  // The nearest sample is no farther than any other, and its own spacing at least the median.
  const double enough = low * cloud.spacing * low * cloud.spacing;
  parallel_for_each(surface.vertex_slots(), kGrain, progress, [&](Index v) {
    const Vec3& p = surface.position[v];
    const Index first = surface.outgoing(v);
    Index h = first;
    do {
      const Index f = SurfaceMesh::face(h);
      for (Index k = feet.begin[f]; k < feet.begin[f + 1]; ++k) {
        const Index i = feet.by_face[k];
        if ((cloud.position[i] - p).squaredNorm() <= enough &&
            (!has_sides || surface.area_vector(f).dot(cloud.normal[i].cast<double>()) > 0.0))
          return;
      }
      h = surface.rotate(h);
    } while (h != first);
    const VoxelSearch::Hit nearest = cloud.search.nearest(p);
    const double spacing = cloud.spacing_at(nearest.index);
    const auto in_spacings = [&](const VoxelSearch::Hit& hit) {
      const double distance = std::sqrt(hit.squared_distance) / spacing;
      return distance > low ? static_cast<float>(distance) : 0.0f;
    };
    distances.any[v] = distances.own_side[v] = in_spacings(nearest);
    const Vec3f normal = surface.vertex_normal(v).cast<float>();
    const auto is_compatible = [&](Index i) { return cloud.normal[i].dot(normal) > 0.0f; };
    if (!has_sides || is_compatible(nearest.index)) return;
    const VoxelSearch::Hit other = cloud.search.nearest_if(p, beyond * spacing, is_compatible);
    distances.own_side[v] = std::max(
        distances.any[v], other.index == kNone ? static_cast<float>(beyond) : in_spacings(other));
  });
  return distances;
}

}  // namespace

Membranes find_membranes(const SurfaceMesh& surface, const SampleFeet& feet,
                         const PointCloud& cloud, const CompleteMatchingOptions& options,
                         Progress& progress) {
  const Distances distances = measure(surface, feet, cloud, options, progress);
  const std::vector<float>& distance =
      options.backs_are_openings ? distances.own_side : distances.any;
  const auto is_far = [&](float spacings) { return spacings > options.membrane_high; };
  Membranes membranes;
  std::vector<Index> stack;
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (!is_far(distance[seed])) continue;
    if (membranes.count == 0) membranes.is_membrane.assign(distance.size(), 0);
    if (membranes.is_membrane[seed]) continue;
    ++membranes.count;
    membranes.is_membrane[seed] = 1;
    stack.push_back(seed);
    while (!stack.empty()) {
      const Index v = stack.back();
      stack.pop_back();
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (membranes.is_membrane[u] || distance[u] <= 0.0f) return;
        membranes.is_membrane[u] = 1;
        stack.push_back(u);
      });
    }
  }
  for (Index v = 0; v < surface.vertex_slots(); ++v)
    if (is_far(distances.own_side[v]) && (membranes.count == 0 || !membranes.is_membrane[v]))
      ++membranes.backs;
  return membranes;
}

}  // namespace shrinkwrap
