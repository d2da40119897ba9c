#include "complete_matching/membranes.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "complete_matching/surface_openings.h"
#include "parametric_surface/parametric_surface.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kBeyond = 1.1;  // x `membrane_high`: farther samples are not looked for
constexpr Index kFewFeet = 16;   // of a part that an opening must not cut off

// Of a vertex: how far samples are.
enum Level : char { kNear, kBeyondLow, kBeyondHigh };  // `membrane_low`, `membrane_high`

struct Levels {
  std::vector<Level> any;       // from the samples
  std::vector<Level> own_side;  // from those that look to the same side
};

Levels measure(const SurfaceMesh& surface, const SampleFeet& feet, const PointCloud& cloud,
               const CompleteMatchingOptions& options, Progress& progress) {
  Levels levels;
  levels.any.resize(surface.position.size(), kNear);
  levels.own_side.resize(surface.position.size(), kNear);
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
    const auto level_of = [&](const VoxelSearch::Hit& hit) {
      const double distance = std::sqrt(hit.squared_distance);
      if (distance <= low * spacing) return kNear;
      const double high = options.membrane_high * cloud.spacing_beside(nearest.index);
      return distance > high ? kBeyondHigh : kBeyondLow;
    };
    levels.any[v] = levels.own_side[v] = level_of(nearest);
    const Vec3f normal = surface.vertex_normal(v).cast<float>();
    const auto is_compatible = [&](Index i) { return cloud.normal[i].dot(normal) > 0.0f; };
    if (!has_sides || is_compatible(nearest.index)) return;
    const VoxelSearch::Hit other = cloud.search.nearest_if(p, beyond * spacing, is_compatible);
    levels.own_side[v] =
        other.index == kNone ? kBeyondHigh : std::max(levels.any[v], level_of(other));
  });
  return levels;
}

// Marks the openings that show along the surface, where samples of another side may be near as the
// crow flies. Those that would cut off a few samples are none.
class OpeningsAlongSurface {
 public:
  OpeningsAlongSurface(const SurfaceMesh& surface, const SampleFeet& feet, const PointCloud& cloud,
                       const CompleteMatchingOptions& options, Progress& progress)
      : surface_(surface), feet_(feet) {
    const std::vector<SurfaceMembrane> found = find_surface_membranes(
        surface, mark_membranes(surface, cloud, ParametricSurfaceOptions(), progress), cloud,
        options, progress);
    for (const SurfaceMembrane& membrane : found) {
      if (count_++ == 0) opening_of_.assign(surface.position.size(), kNone);
      for (const Index v : membrane.vertices) opening_of_[v] = count_ - 1;
    }
  }

  void mark(std::vector<char>& is_membrane) {
    if (count_ == 0) return;
    if (is_membrane.empty()) is_membrane.assign(surface_.position.size(), 0);
    leave_out_around_feet();
    const std::vector<char> cuts_off = find_those_that_cut_off(is_membrane);
    for (Index v = 0; v < surface_.vertex_slots(); ++v)
      if (opening_of_[v] != kNone && !cuts_off[opening_of_[v]]) is_membrane[v] = 1;
  }

 private:
  // Narrower, what stays would leave samples at the rim without a face among samples.
  void leave_out_around_feet() {
    for (Index f = 0; f < surface_.face_slots(); ++f) {
      if (feet_.begin[f] == feet_.begin[f + 1]) continue;
      for (const Index v : surface_.triangle(f)) {
        opening_of_[v] = kNone;
        surface_.for_each_outgoing(v, [&](Index h) { opening_of_[surface_.target(h)] = kNone; });
      }
    }
  }

  // Per opening: whether a part of the surface with few feet hangs together with the rest through
  // it only.
  std::vector<char> find_those_that_cut_off(const std::vector<char>& is_membrane) const {
    std::vector<char> cuts_off(static_cast<std::size_t>(count_), 0);
    std::vector<char> is_seen = is_membrane;
    std::vector<Index> part, around;  // vertices of it; openings
    for (Index seed = 0; seed < surface_.vertex_slots(); ++seed) {
      if (is_seen[seed] || opening_of_[seed] != kNone) continue;
      Index corners = 0;  // of the faces with feet, each as many times as it has feet
      around.clear();
      part.assign(1, seed);
      is_seen[seed] = 1;
      for (std::size_t i = 0; i < part.size(); ++i)
        surface_.for_each_outgoing(part[i], [&](Index h) {
          const Index f = SurfaceMesh::face(h), u = surface_.target(h);
          corners += feet_.begin[f + 1] - feet_.begin[f];
          if (opening_of_[u] != kNone) around.push_back(opening_of_[u]);
          if (is_seen[u] || opening_of_[u] != kNone) return;
          is_seen[u] = 1;
          part.push_back(u);
        });
      if (corners >= 3 * kFewFeet) continue;
      for (const Index opening : around) cuts_off[opening] = 1;
    }
    return cuts_off;
  }

  const SurfaceMesh& surface_;
  const SampleFeet& feet_;
  Index count_ = 0;
  std::vector<Index> opening_of_;  // per vertex; empty if there is none
};

// That hang together.
Index count_pieces(const SurfaceMesh& surface, std::vector<char> is_membrane) {
  Index count = 0;
  std::vector<Index> stack;
  for (std::size_t seed = 0; seed < is_membrane.size(); ++seed) {
    if (!is_membrane[seed]) continue;
    ++count;
    is_membrane[seed] = 0;
    stack.push_back(static_cast<Index>(seed));
    while (!stack.empty()) {
      const Index v = stack.back();
      stack.pop_back();
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (!is_membrane[u]) return;
        is_membrane[u] = 0;
        stack.push_back(u);
      });
    }
  }
  return count;
}

}  // namespace

Membranes find_membranes(const SurfaceMesh& surface, const SampleFeet& feet,
                         const PointCloud& cloud, const CompleteMatchingOptions& options,
                         Progress& progress) {
  const Levels levels = measure(surface, feet, cloud, options, progress);
  const std::vector<Level>& level = options.backs_are_openings ? levels.own_side : levels.any;
  Membranes membranes;
  std::vector<Index> stack;
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (level[seed] != kBeyondHigh) continue;
    if (membranes.is_membrane.empty()) membranes.is_membrane.assign(level.size(), 0);
    if (membranes.is_membrane[seed]) continue;
    membranes.is_membrane[seed] = 1;
    stack.push_back(seed);
    while (!stack.empty()) {
      const Index v = stack.back();
      stack.pop_back();
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (membranes.is_membrane[u] || level[u] == kNear) return;
        membranes.is_membrane[u] = 1;
        stack.push_back(u);
      });
    }
  }
  if (options.openings == CompleteMatchingOptions::Openings::leave_open)
    OpeningsAlongSurface(surface, feet, cloud, options, progress).mark(membranes.is_membrane);
  membranes.count = count_pieces(surface, membranes.is_membrane);
  for (Index v = 0; v < surface.vertex_slots(); ++v)
    if (levels.own_side[v] == kBeyondHigh && (membranes.count == 0 || !membranes.is_membrane[v]))
      ++membranes.backs;
  return membranes;
}

}  // namespace shrinkwrap
