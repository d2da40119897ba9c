#include "membranes.h"

#include <algorithm>
#include <cmath>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kFar = 1.1;  // x `high`: beyond, all distances are alike

// Per vertex: its distance from the samples of its own side in spacings, at most a little more than
// `high`, or 0 where that is at most `low`. (The back of a sheet may be near its samples.)
std::vector<float> distances_above(const SurfaceMesh& surface, const SampleFeet& feet,
                                   const PointCloud& cloud, double low, double high,
                                   Progress& progress) {
  std::vector<float> distance(surface.position.size(), 0.0f);
  // Planes through all the samples there are tell no side.
  const bool has_sides = cloud.size() > cloud.neighbour_count;
  parallel_for_each(surface.vertex_slots(), kGrain, progress, [&](Index v) {
    const Vec3& p = surface.position[v];
    // The nearest sample is no farther than any other, and its own spacing at least the median.
    const double enough = low * cloud.spacing * low * cloud.spacing;
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
    const Vec3f normal = surface.vertex_normal(v).cast<float>();
    const auto is_compatible = [&](Index i) {
      return !has_sides || cloud.normal[i].dot(normal) > 0.0f;
    };
    VoxelSearch::Hit hit = cloud.search.nearest(p);
    const double spacing =
        std::max(cloud.spacing, static_cast<double>(cloud.local_spacing[hit.index]));
    const double far = kFar * high * spacing;
    if (!is_compatible(hit.index)) hit = cloud.search.nearest_if(p, far, is_compatible);
    const double spacings =
        hit.index == kNone ? kFar * high : std::sqrt(hit.squared_distance) / spacing;
    if (spacings > low) distance[v] = static_cast<float>(spacings);
  });
  return distance;
}

}  // namespace

Membranes find_membranes(const SurfaceMesh& surface, const SampleFeet& feet,
                         const PointCloud& cloud, double low, double high, Progress& progress) {
  const std::vector<float> distance = distances_above(surface, feet, cloud, low, high, progress);
  Membranes membranes;
  std::vector<Index> stack;
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (!(distance[seed] > high)) continue;
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
  return membranes;
}

}  // namespace shrinkwrap
