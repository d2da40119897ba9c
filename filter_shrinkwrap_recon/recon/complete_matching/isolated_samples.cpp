#include "complete_matching/isolated_samples.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "geometry/triangle_geometry.h"
#include "mesh/box_tree.h"
#include "mesh/fresh_faces.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr std::size_t kMostFaces = 1 << 14;  // around a sample, to be searched
constexpr int kMostTries = 64;               // edges that a sample may be joined to
constexpr double kFolded = -0.5;             // cosine of a face that lies back on its neighbour

class SampleJoiner {
 public:
  SampleJoiner(SurfaceMesh& mesh, Index samples, std::vector<char>& is_dropped, Progress& progress)
      : mesh_(mesh),
        samples_(samples),
        is_dropped_(is_dropped),
        is_reached_(is_dropped.size(), 0),
        pairs_(mesh.position),
        boxes_(mesh.position, mesh.triangles(), progress) {}

  // Returns the face made; kNone if there is none.
  Index join(Index v) {
    reached_.clear();
    mesh_.for_each_outgoing(v, [&](Index h) { reach(h, SurfaceMesh::next(h), kNone, 0); });
    const Index face = join_to_nearest(v);
    for (const Reached& at : reached_) is_reached_[at.face] = 0;
    return face;
  }

 private:
  // A dropped face, and the edge over which it was reached from the sample: its half-edge there.
  struct Reached {
    Index face, entry;
    Index before;  // of `reached_`; kNone: it has the sample
    int rings;
  };
  // Between a dropped face, which it is a half-edge of, and one that stays.
  struct BorderEdge {
    Index from, to;
    Index place;  // in `reached_`
    bool is_folded;
    double longest;  // of the face that it would make, squared
  };

  // Looks for borders face by face, and tries their edges as soon as all are known that are as
  // near.
  Index join_to_nearest(Index v) {
    std::vector<BorderEdge> edges;
    int tries = 0;
    for (std::size_t i = 0; i < reached_.size() && i < kMostFaces && tries < kMostTries; ++i) {
      for_each_border_edge(v, static_cast<Index>(i),
                           [&](const BorderEdge& edge) { edges.push_back(edge); });
      const std::size_t next = i + 1;
      const bool is_last = next == reached_.size() || next == kMostFaces;
      if (!is_last && reached_[next].rings == reached_[i].rings) continue;
      std::sort(edges.begin(), edges.end(), [](const BorderEdge& a, const BorderEdge& b) {
        return std::tie(a.is_folded, a.longest, a.from) < std::tie(b.is_folded, b.longest, b.from);
      });
      for (const BorderEdge& edge : edges)
        if (tries++ < kMostTries && !cuts({edge.from, edge.to, v})) return make_face(edge);
      edges.clear();
    }
    return kNone;
  }
  template <class Fn>
  void for_each_border_edge(Index v, Index place, const Fn& fn) {
    const Reached at = reached_[place];
    for (Index h = 3 * at.face; h < 3 * at.face + 3; ++h) {
      // Of a face with the sample only the edge opposite to it is looked over.
      if (at.before == kNone ? h != at.entry : h == at.entry) continue;
      const Index beyond = mesh_.twin(h);
      if (is_dropped_[SurfaceMesh::face(beyond)])
        reach(beyond, beyond, place, at.rings + 1);
      else if (mesh_.origin(h) < samples_ && mesh_.target(h) < samples_ && is_way_free(v, place))
        fn(border_edge(v, h, place));
    }
  }
  void reach(Index halfedge, Index entry, Index before, int rings) {
    const Index face = SurfaceMesh::face(halfedge);
    if (is_reached_[face]) return;
    is_reached_[face] = 1;
    reached_.push_back({face, entry, before, rings});
  }

  BorderEdge border_edge(Index v, Index h, Index place) const {
    const Index from = mesh_.origin(h), to = mesh_.target(h);
    const std::vector<Vec3>& p = mesh_.position;
    const Vec3 normal = unit_or_zero((p[to] - p[from]).cross(p[v] - p[from])),
               beyond = unit_or_zero(mesh_.area_vector(SurfaceMesh::face(mesh_.twin(h))));
    return {from, to, place, normal.dot(beyond) < kFolded,
            std::max((p[v] - p[from]).squaredNorm(), (p[v] - p[to]).squaredNorm())};
  }

  // Faces that stay, away from what it shares with them.
  bool cuts(const Triangle& t) const {
    return fresh_faces_cut(
        mesh_, boxes_, pairs_, {t}, true, [&](Index f) { return is_dropped_[f] != 0; },
        [](std::int64_t) { return true; });
  }

  // Whether the flips along the way from the sample to a face are possible: each makes an edge to
  // the corner that the face beyond has alone.
  bool is_way_free(Index v, Index place) const {
    std::vector<Index> corners;
    for (Index i = place; reached_[i].before != kNone; i = reached_[i].before)
      corners.push_back(mesh_.opposite(reached_[i].entry));
    std::sort(corners.begin(), corners.end());
    return std::adjacent_find(corners.begin(), corners.end()) == corners.end() &&
           std::all_of(corners.begin(), corners.end(),
                       [&](Index corner) { return mesh_.find_halfedge(v, corner) == kNone; });
  }

  // Flips the edges that the way from the sample crosses, from that of the sample on: each is
  // the one opposite to the sample when its turn comes. Returns the face at the border.
  Index make_face(const BorderEdge& edge) {
    std::vector<std::pair<Index, Index>> crossed;  // vertices, since flips renumber half-edges
    for (Index i = edge.place; reached_[i].before != kNone; i = reached_[i].before)
      crossed.emplace_back(mesh_.origin(reached_[i].entry), mesh_.target(reached_[i].entry));
    for (; !crossed.empty(); crossed.pop_back())
      mesh_.flip(mesh_.find_halfedge(crossed.back().first, crossed.back().second));
    const Index face = SurfaceMesh::face(mesh_.find_halfedge(edge.from, edge.to));
    is_dropped_[face] = 0;
    boxes_.set_box(face, boxes_.box_of(mesh_.position, mesh_.triangle(face)));
    return face;
  }

  SurfaceMesh& mesh_;
  Index samples_;
  std::vector<char>& is_dropped_;
  std::vector<char> is_reached_;  // per face; none once a search is done
  std::vector<Reached> reached_;
  TrianglePairs pairs_;
  BoxTree boxes_;  // up to date where faces stay
};

// Of each dropped face, how many faces it is from the nearest border; kNone if there is none.
std::vector<Index> distances_from_borders(const SurfaceMesh& mesh,
                                          const std::vector<char>& is_dropped) {
  std::vector<Index> distance(is_dropped.size(), kNone), reached;
  const auto reach = [&](Index f, Index at) {
    if (!is_dropped[f] || distance[f] != kNone) return;
    distance[f] = at;
    reached.push_back(f);
  };
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    if (!is_dropped[SurfaceMesh::face(mesh.twin(h))]) reach(SurfaceMesh::face(h), 0);
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (Index h = 3 * reached[i]; h < 3 * reached[i] + 3; ++h)
      reach(SurfaceMesh::face(mesh.twin(h)), distance[reached[i]] + 1);
  return distance;
}

// Samples none of whose faces stays and that are within reach of a border, the nearest to one
// first.
std::vector<Index> isolated_samples(const SurfaceMesh& mesh, Index samples,
                                    const std::vector<char>& is_dropped) {
  std::vector<Index> isolated;
  for (Index v = 0; v < samples; ++v) {
    bool all_dropped = true;
    mesh.for_each_outgoing(
        v, [&](Index h) { all_dropped = all_dropped && is_dropped[SurfaceMesh::face(h)]; });
    if (all_dropped) isolated.push_back(v);
  }
  if (isolated.empty()) return isolated;
  const std::vector<Index> distance = distances_from_borders(mesh, is_dropped);
  std::vector<std::pair<Index, Index>> by_distance;
  for (const Index v : isolated) {
    Index nearest = kNone;
    mesh.for_each_outgoing(v, [&](Index h) {
      const Index at = distance[SurfaceMesh::face(h)];
      if (at != kNone && (nearest == kNone || at < nearest)) nearest = at;
    });
    if (nearest != kNone) by_distance.emplace_back(nearest, v);
  }
  std::sort(by_distance.begin(), by_distance.end());
  isolated.clear();
  for (const auto& [at, v] : by_distance) isolated.push_back(v);
  return isolated;
}

}  // namespace

std::vector<Index> join_isolated_samples(SurfaceMesh& mesh, Index samples,
                                         std::vector<char>& is_dropped, Progress& progress) {
  std::vector<Index> made;
  const std::vector<Index> isolated = isolated_samples(mesh, samples, is_dropped);
  if (isolated.empty()) return made;
  SampleJoiner joiner(mesh, samples, is_dropped, progress);
  for (const Index v : isolated) {
    progress.update(1.0);
    const Index face = joiner.join(v);
    if (face != kNone) made.push_back(face);
  }
  std::sort(made.begin(), made.end());
  return made;
}

}  // namespace shrinkwrap
