#include "samples/tangent_target.h"

#include <algorithm>
#include <cmath>

namespace shrinkwrap {
namespace {

constexpr int kMostSteps = 50;       // of a walk
constexpr int kMostNeighbours = 32;  // that are weighed
// x reach: where no sample is so near, looking for a compatible one would be in vain, and slow.
constexpr double kFarReaches = 2.0;
constexpr float kKernelReach = 1.2f;  // the kernel ends this much (squared) beyond the farthest

}  // namespace

TangentTarget::Target TangentTarget::find(const Vec3& query, const Vec3& normal,
                                          const Vec3& centroid, Index hint) const {
  const Vec3f mesh_normal = normal.cast<float>();
  Target target;
  target.point = query;
  target.nearest = hint == kNone ? search_all(query, mesh_normal) : walk(query, mesh_normal, hint);

  const float spacing =
      std::max(static_cast<float>(cloud_.spacing), cloud_.local_spacing[target.nearest]);
  const float reach = static_cast<float>(options_.reach) * spacing;
  if ((cloud_.position[target.nearest] - query).cast<float>().squaredNorm() > reach * reach ||
      !is_compatible(target.nearest, mesh_normal)) {
    target.is_membrane = true;
    return target;
  }

  // Offsets from the query, and the kernel (1 - d^2 / R^2)^2 on them.
  const Index* list = cloud_.neighbours_of(target.nearest);
  const int count =
      std::clamp(options_.rim_neighbours, 1, std::min(kMostNeighbours, cloud_.neighbour_count));
  const int planes =
      std::clamp(cloud_.is_denoised() ? options_.quadric_planes : options_.planes, 1, count);
  Vec3f offset[kMostNeighbours];
  float squared_distance[kMostNeighbours];
  float plane_reach = 0.0f, rim_reach = 0.0f;
  for (int e = 0; e < count; ++e) {
    offset[e] = (cloud_.position[list[e]] - query).cast<float>();
    squared_distance[e] = offset[e].squaredNorm();
    rim_reach = std::max(rim_reach, squared_distance[e]);
    if (e < planes) plane_reach = rim_reach;
  }
  const auto falloff = [](float reach_squared) {
    return 1.0f / (kKernelReach * reach_squared + 1e-30f);
  };

  const Vec3f origin = query.cast<float>();
  const float plane_falloff = falloff(plane_reach);
  const float min_cosine = static_cast<float>(options_.min_cosine);
  Vec3f displacement = Vec3f::Zero(), plane_normal = Vec3f::Zero();
  float total = 0.0f;
  for (int e = 0; e < planes; ++e) {
    const TangentPlane& plane = cloud_.plane[list[e]];
    const float cosine = plane.normal.dot(mesh_normal);
    if (!(cosine > min_cosine)) continue;
    const float kernel = 1.0f - squared_distance[e] * plane_falloff;
    const float weight = kernel * kernel * cosine * cosine;
    displacement += weight * (plane.point - origin).dot(plane.normal) * plane.normal;
    plane_normal += weight * plane.normal;
    total += weight;
  }
  if (!(total > 0.0f)) {  // the planes turn away from the mesh
    target.is_membrane = true;
    return target;
  }
  if (cloud_.is_denoised()) {
    // A tangent plane lies outside of what is convex, by half of what the normal turns on the way;
    // with the mean of the normals at either end it meets any quadric.
    plane_normal.normalize();
    float height = 0.0f;
    for (int e = 0; e < planes; ++e) {
      const TangentPlane& plane = cloud_.plane[list[e]];
      const float cosine = plane.normal.dot(mesh_normal);
      if (!(cosine > min_cosine)) continue;
      const float kernel = 1.0f - squared_distance[e] * plane_falloff;
      height += kernel * kernel * cosine * cosine *
                (plane.point - origin).dot(0.5f * (plane.normal + plane_normal));
    }
    displacement = height * plane_normal;
  }

  const float rim_falloff = falloff(rim_reach);
  Vec3f off = Vec3f::Zero();
  float rim_total = 1e-30f;
  for (int e = 0; e < count; ++e) {
    if (!is_compatible(list[e], mesh_normal)) continue;
    const float kernel = 1.0f - squared_distance[e] * rim_falloff;
    const float weight = kernel * kernel;
    off += weight * offset[e];
    rim_total += weight;
  }
  off /= rim_total;
  // Tangential part, squared, against the plane's own normal.
  const float height = off.dot(plane_normal);
  const float off_centre =
      off.squaredNorm() - height * height / std::max(plane_normal.squaredNorm(), 1e-30f);
  const float near_limit = static_cast<float>(options_.off_centre) * spacing;
  const float far_limit = static_cast<float>(options_.beyond_rim) * spacing;
  if (off_centre >= far_limit * far_limit) {
    target.is_membrane = true;
    return target;
  }
  target.point += (displacement / total).cast<double>();
  if (off_centre > near_limit * near_limit) {
    const float fade = (std::sqrt(off_centre) - near_limit) / (far_limit - near_limit);
    target.point += static_cast<double>(fade) * (centroid - target.point);
  }
  return target;
}

// Greedy walk to ever nearer compatible neighbours.
Index TangentTarget::walk(const Vec3& query, const Vec3f& normal, Index from) const {
  if (!is_compatible(from, normal)) return search_all(query, normal);
  Index at = from;
  double best = (cloud_.position[at] - query).squaredNorm();
  for (int step = 0; step < kMostSteps; ++step) {
    const Index* list = cloud_.neighbours_of(at);
    Index next = kNone;
    for (int e = 1; e < cloud_.neighbour_count; ++e) {
      const double squared_distance = (cloud_.position[list[e]] - query).squaredNorm();
      if (squared_distance < best && is_compatible(list[e], normal)) {
        best = squared_distance;
        next = list[e];
      }
    }
    if (next == kNone) return at;
    at = next;
  }
  return search_all(query, normal);
}

// The nearest compatible sample if there is one not much farther than the nearest of all, else that
// one: a far compatible sample belongs to another part of the surface.
Index TangentTarget::search_all(const Vec3& query, const Vec3f& normal) const {
  const VoxelSearch::Hit any = cloud_.search.nearest(query);
  if (is_compatible(any.index, normal)) return any.index;
  const double spacing = cloud_.spacing_at(any.index);
  const double far = kFarReaches * options_.reach * spacing;
  if (any.squared_distance > far * far) return any.index;
  const VoxelSearch::Hit hit =
      cloud_.search.nearest_if(query, std::sqrt(any.squared_distance) + options_.reach * spacing,
                               [&](Index sample) { return is_compatible(sample, normal); });
  return hit.index == kNone ? any.index : hit.index;
}

}  // namespace shrinkwrap
