#include "mesh/surface_loops.h"

#include <algorithm>

#include "common/disjoint_sets.h"
#include "common/sort_unique.h"
#include "mesh/one_ring.h"

namespace shrinkwrap {
namespace {

constexpr std::size_t kMostOfBall = 1 << 14;  // vertices
constexpr Index kUpdateInterval = 1 << 14;

// The edges that close a loop around or through a handle: of those outside the path tree, long
// loops first, the ones that join no faces anew. `set_of` numbers the faces below `sets`.
template <class SetOf>
std::vector<Index> closing_edges(const SurfaceMesh& mesh, const PathTree& tree, Index sets,
                                 const SetOf& set_of, Progress& progress) {
  std::vector<std::pair<Index, Index>> edges;  // loop length, half-edge
  for (const Index v : tree.reached())
    mesh.for_each_outgoing(v, [&](Index h) {
      if (h < mesh.twin(h) && tree.has_reached(mesh.target(h)) && !tree.has_edge(mesh, h))
        edges.emplace_back(tree.loop_length(mesh, h), h);
    });
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  progress.update(0.0);
  DisjointSets joined(sets);
  std::vector<Index> closing;
  for (const auto& [length, h] : edges)
    if (!joined.unite(set_of(SurfaceMesh::face(h)), set_of(SurfaceMesh::face(mesh.twin(h)))))
      closing.push_back(h);
  return closing;
}

// Sets of faces that hang together but for the edges of loops.
class Pieces {
 public:
  Pieces(const SurfaceMesh& mesh, const std::vector<Loop>& loops, Progress& progress)
      : mesh_(mesh), joined_(mesh.face_slots()) {
    std::vector<char> is_wall(3 * static_cast<std::size_t>(mesh.face_slots()), 0);
    for (const Loop& loop : loops)
      for_each_edge(loop, [&](Index h) { is_wall[h] = is_wall[mesh.twin(h)] = 1; });
    for (Index h = 0; h < 3 * mesh.face_slots(); ++h)
      if (!is_wall[h]) join(h);
    progress.update(0.0);
  }

  Index of(Index h) { return joined_.find(SurfaceMesh::face(h)); }
  /// Whether what is on its two sides was apart.
  bool join_across(const Loop& loop) {
    bool were_apart = false;
    for_each_edge(loop, [&](Index h) { were_apart = join(h) || were_apart; });
    return were_apart;
  }

 private:
  template <class Fn>
  void for_each_edge(const Loop& loop, const Fn& fn) const {
    for (std::size_t i = 0; i < loop.size(); ++i)
      fn(mesh_.find_halfedge(loop[i], loop[(i + 1) % loop.size()]));
  }
  bool join(Index h) {
    return joined_.unite(SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h)));
  }

  const SurfaceMesh& mesh_;
  DisjointSets joined_;
};

struct PieceFigures {
  Index samples = 0;
  double volume = 0.0;       // between its faces and the origin
  Vec3 area = Vec3::Zero();  // sum of the area vectors

  void add(const PieceFigures& other) {
    samples += other.samples;
    volume += other.volume;
    area += other.area;
  }
  // What it encloses with a fan over its rim; other rims count little, as they are short.
  double volume_closed_at(const Vec3& centre) const { return volume - centre.dot(area) / 3.0; }
};

}  // namespace

bool PathTree::grow(const SurfaceMesh& mesh, const std::vector<Index>& roots, Index radius,
                    std::size_t most, Progress& progress) {
  for (const Index v : reached_) distance_[v] = toward_root_[v] = kNone;
  reached_ = roots;
  for (const Index root : roots) distance_[root] = 0;
  for (std::size_t i = 0; i < reached_.size(); ++i) {
    if (i % kUpdateInterval == kUpdateInterval - 1) progress.update(0.0);
    const Index v = reached_[i];
    if (distance_[v] == radius) break;
    mesh.for_each_outgoing(v, [&](Index h) {
      const Index u = mesh.target(h);
      if (distance_[u] != kNone) return;
      distance_[u] = distance_[v] + 1;
      toward_root_[u] = mesh.twin(h);
      reached_.push_back(u);
    });
    if (reached_.size() > most) return false;
  }
  return true;
}

Loop PathTree::loop(const SurfaceMesh& mesh, Index h) const {
  Loop from_origin, from_target;
  Index a = mesh.origin(h), b = mesh.target(h);
  while (a != b) {
    if (distance_[a] >= distance_[b]) {
      from_origin.push_back(a);
      a = mesh.target(toward_root_[a]);
    } else {
      from_target.push_back(b);
      b = mesh.target(toward_root_[b]);
    }
  }
  from_origin.push_back(a);
  from_origin.insert(from_origin.end(), from_target.rbegin(), from_target.rend());
  return from_origin;
}

// Its Euler characteristic is 1 then: one component, no loop.
bool PathTree::is_disc(const SurfaceMesh& mesh) const {
  Index edge_ends = 0, corners = 0;
  for (const Index v : reached_)
    mesh.for_each_outgoing(v, [&](Index h) {
      if (!has_reached(mesh.target(h))) return;
      ++edge_ends;
      corners += has_reached(mesh.opposite(h));
    });
  return static_cast<Index>(reached_.size()) - edge_ends / 2 + corners / 3 == 1;
}

std::vector<Loop> loops_from(const SurfaceMesh& mesh, const std::vector<Index>& roots,
                             Progress& progress) {
  PathTree tree(mesh);
  tree.grow(mesh, roots, mesh.vertex_slots(), mesh.position.size(), progress);
  std::vector<Loop> loops;
  for (const Index h : closing_edges(
           mesh, tree, mesh.face_slots(), [](Index f) { return f; }, progress))
    loops.push_back(tree.loop(mesh, h));
  sort_by_length(loops);
  return loops;
}

void sort_by_length(std::vector<Loop>& loops) {
  std::stable_sort(loops.begin(), loops.end(),
                   [](const Loop& a, const Loop& b) { return a.size() < b.size(); });
}

Loop loop_in_ball(const SurfaceMesh& mesh, PathTree& tree, Index centre, Index radius,
                  Progress& progress) {
  if (!tree.grow(mesh, {centre}, radius, kMostOfBall, progress) || tree.is_disc(mesh)) return {};
  std::vector<Index> inside;
  for (const Index v : tree.reached())
    mesh.for_each_outgoing(v, [&](Index h) {
      const Triangle t = mesh.triangle(SurfaceMesh::face(h));
      if (std::all_of(t.begin(), t.end(), [&](Index u) { return tree.has_reached(u); }))
        inside.push_back(SurfaceMesh::face(h));
    });
  sort_unique(inside);
  // All faces further off are one set, as if they were joined.
  const Index outside = static_cast<Index>(inside.size());
  const auto set_of = [&](Index f) {
    const auto found = std::lower_bound(inside.begin(), inside.end(), f);
    return found != inside.end() && *found == f ? static_cast<Index>(found - inside.begin())
                                                : outside;
  };
  Loop shortest;
  for (const Index h : closing_edges(mesh, tree, outside + 1, set_of, progress)) {
    Loop loop = tree.loop(mesh, h);
    if (shortest.empty() || loop.size() < shortest.size()) shortest = std::move(loop);
  }
  return shortest;
}

void DisjointLoops::add(const Loop& loop) {
  const auto is_taken_at = [&](Index v) { return is_taken_[v] != 0; };
  if (loop.empty() || loops.size() == most_ || std::any_of(loop.begin(), loop.end(), is_taken_at))
    return;
  for (const Index v : loop) is_taken_[v] = 1;
  loops.push_back(loop);
}

void keep_inseparable(const SurfaceMesh& mesh, std::vector<Loop>& loops, Progress& progress) {
  Pieces pieces(mesh, loops, progress);
  std::vector<Loop> kept;
  for (auto loop = loops.rbegin(); loop != loops.rend(); ++loop)
    if (!pieces.join_across(*loop)) kept.push_back(std::move(*loop));
  loops = std::move(kept);
}

void keep_mouths_of_cavities(const SurfaceMesh& mesh, std::vector<Loop>& loops,
                             const std::vector<Index>& samples_of, Index least,
                             Progress& progress) {
  Pieces pieces(mesh, loops, progress);
  std::vector<PieceFigures> figures(static_cast<std::size_t>(mesh.face_slots()));
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    figures[pieces.of(mesh.outgoing(v))].samples += samples_of[v];
  const auto& p = mesh.position;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    const Triangle t = mesh.triangle(f);
    PieceFigures& piece = figures[pieces.of(3 * f)];
    piece.volume += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6.0;
    piece.area += 0.5 * mesh.area_vector(f);
  }
  const auto is_mouth = [&](const Loop& loop, const PieceFigures& left, const PieceFigures& right) {
    Vec3 centre = Vec3::Zero();
    for (const Index v : loop) centre += p[v] / static_cast<double>(loop.size());
    // The normals in a tunnel look at its axis, those on a rod away from it.
    double inward = 0.0;
    for (const Index v : loop)
      inward += gather_one_ring(mesh, v).normal.dot((centre - p[v]).normalized());
    return inward > 0.0 && std::min(left.samples, right.samples) >= least &&
           (left.volume_closed_at(centre) < 0.0) != (right.volume_closed_at(centre) < 0.0);
  };
  std::vector<Loop> kept;
  for (auto loop = loops.rbegin(); loop != loops.rend(); ++loop) {
    const Index h = mesh.find_halfedge(loop->front(), (*loop)[1]);
    const Index left = pieces.of(h), right = pieces.of(mesh.twin(h));
    if (left != right && is_mouth(*loop, figures[left], figures[right])) {
      kept.push_back(std::move(*loop));
      continue;
    }
    if (!pieces.join_across(*loop)) continue;
    PieceFigures both = figures[left];
    both.add(figures[right]);
    figures[pieces.of(h)] = both;
  }
  loops = std::move(kept);
}

void cut_along(SurfaceMesh& mesh, const std::vector<Loop>& loops, Progress& progress) {
  std::vector<Vec3> position = mesh.position;
  std::vector<Triangle> triangles = mesh.triangles();
  for (const Loop& loop : loops) {
    const std::size_t count = loop.size();
    const Index first_copy = static_cast<Index>(position.size());
    Vec3 centre = Vec3::Zero();
    for (std::size_t i = 0; i < count; ++i) {
      const Index v = loop[i], next = loop[(i + 1) % count],
                  previous = loop[(i + count - 1) % count];
      centre += mesh.position[v] / static_cast<double>(count);
      position.push_back(mesh.position[v]);
      // Faces to the right of the loop, from its half-edge back to the one onwards, get the copy.
      const Index onwards = mesh.find_halfedge(v, next);
      for (Index h = mesh.find_halfedge(v, previous); h != onwards; h = mesh.rotate(h))
        for (Index& corner : triangles[SurfaceMesh::face(h)])
          if (corner == v) corner = first_copy + static_cast<Index>(i);
    }
    const Index left_centre = static_cast<Index>(position.size()), right_centre = left_centre + 1;
    position.push_back(centre);
    position.push_back(centre);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = (i + 1) % count;
      triangles.push_back({loop[next], loop[i], left_centre});
      triangles.push_back({first_copy + static_cast<Index>(i),
                           first_copy + static_cast<Index>(next), right_centre});
    }
  }
  mesh = SurfaceMesh::from_triangles(std::move(position), triangles, progress);
}

}  // namespace shrinkwrap
