#include "mesh/bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/parallel.h"
#include "geometry/exact_predicates.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 13;

// A point of a component, from which a ray runs along the x axis.
struct Probe {
  Vec3 position;
  Index component;
  Eigen::AlignedBox3d box;  // of the component
};

// A ray leaves the solid of another component (1), or enters it (-1).
struct Crossing {
  Index probe, component;
  int sign;
};

// On which side of an edge, seen along the x axis, p lies: 1 is left. In doubt that of a point
// beside it, which is the same one for all edges: a little farther along y, and less than that
// along z. 0: the edge is a point.
int side_of_edge(const Vec3& from, const Vec3& to, const Vec3& p) {
  const int side = orientation_sign_2d(from, to, p, 0);
  if (side != 0) return side;
  if (from.z() != to.z()) return from.z() > to.z() ? 1 : -1;
  return from.y() == to.y() ? 0 : from.y() < to.y() ? 1 : -1;
}

int crossing_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const int side = side_of_edge(a, b, p);
  if (side == 0 || side_of_edge(b, c, p) != side || side_of_edge(c, a, p) != side) return 0;
  // Ahead of the ray if p lies behind a face that looks forwards, or before one that looks back.
  return orientation_sign(a, b, c, p) == -side ? side : 0;
}

// One for each component that is to be judged, on its first face of finite corners.
std::vector<Probe> probes_of(const std::vector<Vec3>& position,
                             const std::vector<Triangle>& triangles,
                             const std::vector<Index>& component_of_face,
                             const std::vector<double>& volume) {
  std::vector<char> is_wanted(volume.size());
  std::transform(volume.begin(), volume.end(), is_wanted.begin(),
                 [](double v) { return v != 0.0; });
  std::vector<Probe> probes;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Index component = component_of_face[f];
    if (!is_wanted[component]) continue;
    const Triangle& t = triangles[f];
    const Vec3 p = 0.2360679775 * position[t[0]] + 0.3090169944 * position[t[1]] +
                   0.4549150281 * position[t[2]];
    if (!p.allFinite()) continue;
    is_wanted[component] = 0;
    probes.push_back({p, component, {}});
  }
  std::sort(probes.begin(), probes.end(), [](const Probe& a, const Probe& b) {
    return a.position.y() != b.position.y() ? a.position.y() < b.position.y()
                                            : a.component < b.component;
  });
  return probes;
}

// Of the rays of all probes, sorted along y, with the faces of other components, but for those that
// are too small to enclose them.
std::vector<Crossing> find_crossings(const std::vector<Probe>& probes,
                                     const std::vector<Vec3>& position,
                                     const std::vector<Triangle>& triangles,
                                     const std::vector<Index>& component_of_face,
                                     const std::vector<Index>& probe_of_component,
                                     Progress& progress) {
  return parallel_collect<Crossing>(
      static_cast<Index>(triangles.size()), kGrain, progress,
      [&](Index begin, Index end, std::vector<Crossing>& some) {
        for (Index f = begin; f < end; ++f) {
          const Triangle& t = triangles[f];
          const Vec3 &a = position[t[0]], &b = position[t[1]], &c = position[t[2]];
          if (!a.allFinite() || !b.allFinite() || !c.allFinite()) continue;
          const Index own = probe_of_component[component_of_face[f]];
          const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
          auto probe =
              std::lower_bound(probes.begin(), probes.end(), low.y(),
                               [](const Probe& other, double y) { return other.position.y() < y; });
          for (; probe != probes.end() && probe->position.y() <= high.y(); ++probe) {
            const Vec3& p = probe->position;
            if (p.z() < low.z() || p.z() > high.z() || p.x() > high.x() ||
                component_of_face[f] == probe->component ||
                (own != kNone && !probes[own].box.contains(probe->box)))
              continue;
            const int sign = crossing_sign(a, b, c, p);
            if (sign != 0)
              some.push_back(
                  {static_cast<Index>(probe - probes.begin()), component_of_face[f], sign});
          }
        }
      });
}

// Of faces and an apex, six times: the signed volume between them, and what its rounding is a few
// bits of, that of the coordinates included.
struct VolumeSum {
  double volume = 0.0, size = 0.0;
  bool is_finite = true;  // all of its faces

  VolumeSum& operator+=(const VolumeSum& other) {
    volume += other.volume;
    size += other.size;
    is_finite = is_finite && other.is_finite;
    return *this;
  }
};

VolumeSum volume_under(const Vec3& apex, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 edge = b - a, other = c - a, from_apex = a - apex;
  VolumeSum sum;
  sum.volume = from_apex.dot(edge.cross(other));
  sum.size = edge.norm() * other.norm() * (from_apex.norm() + a.norm());
  return std::isfinite(sum.volume) && std::isfinite(sum.size) ? sum : VolumeSum{0.0, 0.0, false};
}

}  // namespace

ComponentVolumes signed_volumes(const std::vector<Vec3>& position,
                                const std::vector<Triangle>& triangles,
                                const std::vector<Index>& component_of_face, Index components,
                                double scale, Progress& progress) {
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  // From a vertex of their own: a small component far from the others has a small volume too.
  std::vector<Index> apex(static_cast<std::size_t>(components), kNone);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    Index& own = apex[component_of_face[f]];
    for (const Index v : triangles[f])
      if (own == kNone || !position[own].allFinite()) own = v;
  }
  // Block by block; most blocks lie in one component.
  struct Part {
    Index component;
    VolumeSum sum;
  };
  const std::vector<Part> parts = parallel_collect<Part>(
      static_cast<Index>(triangles.size()), kGrain, progress,
      [&](Index begin, Index end, std::vector<Part>& some) {
        for (Index f = begin; f < end; ++f) {
          const Index component = component_of_face[f];
          if (some.empty() || some.back().component != component) some.push_back({component, {}});
          const auto& [a, b, c] = triangles[f];
          some.back().sum += volume_under(scale * position[apex[component]], scale * position[a],
                                          scale * position[b], scale * position[c]);
        }
      });
  std::vector<VolumeSum> sum(static_cast<std::size_t>(components));
  for (const Part& part : parts) sum[part.component] += part.sum;
  ComponentVolumes result;
  for (const VolumeSum& all : sum) {
    const bool is_flat = all.is_finite && !(std::abs(all.volume) > kRounding * all.size);
    result.volume.push_back(is_flat ? 0.0 : all.volume / 6.0);
    result.flat += is_flat ? 1 : 0;
  }
  return result;
}

ComponentSides find_sides(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                          const std::vector<Index>& component_of_face,
                          const std::vector<double>& volume, Progress& progress) {
  ComponentSides sides;
  std::vector<Probe> probes = probes_of(position, triangles, component_of_face, volume);
  std::vector<Index> probe_of_component(volume.size(), kNone);
  for (std::size_t i = 0; i < probes.size(); ++i)
    probe_of_component[probes[i].component] = static_cast<Index>(i);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Index probe = probe_of_component[component_of_face[f]];
    if (probe == kNone) continue;
    for (const Index v : triangles[f])
      if (position[v].allFinite()) probes[probe].box.extend(position[v]);
  }
  std::vector<Crossing> crossings =
      find_crossings(probes, position, triangles, component_of_face, probe_of_component, progress);
  const auto by_probe = [](const Crossing& a, const Crossing& b) { return a.probe < b.probe; };
  std::sort(crossings.begin(), crossings.end(), by_probe);
  // What encloses a component has a greater volume than it.
  std::vector<Index> outer_first(probes.size());
  std::iota(outer_first.begin(), outer_first.end(), 0);
  const auto size = [&](Index i) { return std::abs(volume[probes[i].component]); };
  std::stable_sort(outer_first.begin(), outer_first.end(),
                   [&](Index a, Index b) { return size(a) > size(b); });
  std::vector<char> is_turned(volume.size(), 0);
  for (const Index i : outer_first) {
    const auto [first, last] =
        std::equal_range(crossings.begin(), crossings.end(), Crossing{i, 0, 0}, by_probe);
    int winding = 0, winding_of_unjudged = 0;
    for (auto crossing = first; crossing != last; ++crossing) {
      if (probe_of_component[crossing->component] == kNone)
        winding_of_unjudged += crossing->sign;
      else
        winding += is_turned[crossing->component] ? -crossing->sign : crossing->sign;
    }
    if (winding_of_unjudged != 0) continue;
    const Index component = probes[i].component;
    const bool is_cavity = winding > 0;
    is_turned[component] = is_cavity != (volume[component] < 0.0);
    if (is_cavity) sides.cavities.push_back(component);
    if (is_turned[component]) sides.inside_out.push_back(component);
  }
  std::sort(sides.cavities.begin(), sides.cavities.end());
  std::sort(sides.inside_out.begin(), sides.inside_out.end());
  return sides;
}

Index turn_outward(SurfaceMesh& mesh, const std::vector<Index>& opening_faces, Progress& progress) {
  const MeshComponents components = connected_components(mesh, progress);
  std::vector<Triangle> triangles = mesh.triangles();
  std::vector<Index> component_of_face(triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f)
    component_of_face[f] = components.of_vertex[triangles[f][0]];
  std::vector<double> volume =
      signed_volumes(mesh.position, triangles, component_of_face, components.count, 1.0, progress)
          .volume;
  for (const Index f : opening_faces) volume[component_of_face[f]] = 0.0;

  const std::vector<Index> inside_out =
      find_sides(mesh.position, triangles, component_of_face, volume, progress).inside_out;
  if (inside_out.empty()) return 0;
  std::vector<char> is_turned(volume.size(), 0);
  for (const Index component : inside_out) is_turned[component] = 1;
  for (std::size_t f = 0; f < triangles.size(); ++f)
    if (is_turned[component_of_face[f]]) std::swap(triangles[f][1], triangles[f][2]);
  mesh = SurfaceMesh::from_triangles(std::move(mesh.position), triangles, progress);
  return static_cast<Index>(inside_out.size());
}

}  // namespace shrinkwrap
