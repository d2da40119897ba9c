#include "genus_limit.h"

#include <algorithm>

#include "disjoint_sets.h"
#include "parallel.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr int kMostSearches = 12;             // for one loop, each from a place on the loop before
constexpr std::size_t kMostOfBall = 1 << 14;  // vertices around a loop that is made shorter nearby
constexpr std::size_t kLongest = 2;           // of the loops of a round, x the shortest

using Loop = std::vector<Index>;  // vertices, each joined to the next, the last to the first
constexpr Index kUpdateInterval = 1 << 14;

// Shortest paths, by number of edges, from some vertices to all that are within reach: of their
// components, or of a ball.
class PathTree {
 public:
  explicit PathTree(const SurfaceMesh& mesh)
      : distance_(mesh.position.size(), kNone), toward_root_(mesh.position.size(), kNone) {}

  // Starts anew. False if there are more than `most` vertices within the radius.
  bool grow(const SurfaceMesh& mesh, const std::vector<Index>& roots, Index radius,
            std::size_t most, Progress& progress) {
    for (const Index v : reached_) distance_[v] = toward_root_[v] = kNone;
    reached_ = roots;
    for (const Index root : roots) distance_[root] = 0;
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      if (i % kUpdateInterval == 0) progress.update(0.0);
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

  bool has_reached(Index v) const { return distance_[v] != kNone; }
  const std::vector<Index>& reached() const { return reached_; }
  bool has_edge(const SurfaceMesh& mesh, Index h) const {
    return toward_root_[mesh.origin(h)] == h || toward_root_[mesh.target(h)] == mesh.twin(h);
  }
  Index loop_length(const SurfaceMesh& mesh, Index h) const {
    return distance_[mesh.origin(h)] + distance_[mesh.target(h)] + 1;
  }
  // The cycle of an edge and the paths from its ends to where they meet.
  Loop loop(const SurfaceMesh& mesh, Index h) const {
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

 private:
  std::vector<Index> distance_;
  std::vector<Index> toward_root_;  // half-edge that leaves the vertex
  std::vector<Index> reached_;
};

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

// The loops, each up to where its two ends part, of which none separates the surface, nor do any
// that have no vertex in common: no two are homologous. The shortest first.
std::vector<Loop> loops_from(const SurfaceMesh& mesh, const std::vector<Index>& roots,
                             Progress& progress) {
  PathTree tree(mesh);
  tree.grow(mesh, roots, mesh.vertex_slots(), mesh.position.size(), progress);
  std::vector<Loop> loops;
  for (const Index h : closing_edges(
           mesh, tree, mesh.face_slots(), [](Index f) { return f; }, progress))
    loops.push_back(tree.loop(mesh, h));
  std::stable_sort(loops.begin(), loops.end(),
                   [](const Loop& a, const Loop& b) { return a.size() < b.size(); });
  return loops;
}

// A shortest loop through a vertex among those within so many edges of it that no disc bounds;
// whether it separates the surface is not looked into, as it would take all of it. Empty if there
// is none.
Loop loop_in_ball(const SurfaceMesh& mesh, PathTree& tree, Index centre, Index radius,
                  Progress& progress) {
  if (!tree.grow(mesh, {centre}, radius, kMostOfBall, progress)) return {};
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

// Searches from where a loop passes, for one of at most `longest` edges. Empty if there is none.
Loop shortened_nearby(const SurfaceMesh& mesh, PathTree& tree, Loop loop, std::size_t longest,
                      Progress& progress) {
  // Where the loop closes, and from then on opposite to where the search began.
  Index centre = loop.front();
  for (int search = 0; search < kMostSearches; ++search) {
    const Index radius = static_cast<Index>(std::min(loop.size(), longest) / 2);
    Loop shorter = loop_in_ball(mesh, tree, centre, radius, progress);
    if (shorter.empty() || shorter.size() >= loop.size()) break;
    loop = std::move(shorter);
    centre = loop[loop.size() / 2];
  }
  return loop.size() <= longest ? loop : Loop();
}

// The same by searches of the whole mesh: what comes out separates nothing.
Loop shortened(const SurfaceMesh& mesh, Loop loop, int& searches, Progress& progress) {
  for (int search = 1; search < kMostSearches; ++search) {
    ++searches;
    std::vector<Loop> through = loops_from(mesh, {loop[loop.size() / 2]}, progress);
    if (through.front().size() >= loop.size()) break;
    loop = std::move(through.front());
  }
  return loop;
}

// Leaves out loops, of those that separate the surface together the longest.
void keep_inseparable(const SurfaceMesh& mesh, std::vector<Loop>& loops, Progress& progress) {
  std::vector<char> is_wall(3 * static_cast<std::size_t>(mesh.face_slots()), 0);
  const auto for_each_edge = [&](const Loop& loop, const auto& fn) {
    for (std::size_t i = 0; i < loop.size(); ++i)
      fn(mesh.find_halfedge(loop[i], loop[(i + 1) % loop.size()]));
  };
  for (const Loop& loop : loops)
    for_each_edge(loop, [&](Index h) { is_wall[h] = is_wall[mesh.twin(h)] = 1; });
  DisjointSets joined(mesh.face_slots());
  const auto join_across = [&](Index h) {
    return joined.unite(SurfaceMesh::face(h), SurfaceMesh::face(mesh.twin(h)));
  };
  for (Index h = 0; h < 3 * mesh.face_slots(); ++h)
    if (!is_wall[h]) join_across(h);
  progress.update(0.0);
  std::stable_sort(loops.begin(), loops.end(),
                   [](const Loop& a, const Loop& b) { return a.size() < b.size(); });
  std::vector<Loop> kept;
  for (auto loop = loops.rbegin(); loop != loops.rend(); ++loop) {
    bool separates = false;
    for_each_edge(*loop, [&](Index h) { separates = join_across(h) || separates; });
    if (!separates) kept.push_back(std::move(*loop));
  }
  loops = std::move(kept);
}

// Loops that have no vertex in common.
struct Disjoint {
  Disjoint(const SurfaceMesh& mesh, Index most_loops)
      : most(static_cast<std::size_t>(most_loops)), is_taken(mesh.position.size(), 0) {}
  void add(const Loop& loop) {
    const auto is_taken_at = [&](Index v) { return is_taken[v] != 0; };
    if (loop.empty() || loops.size() == most || std::any_of(loop.begin(), loop.end(), is_taken_at))
      return;
    for (const Index v : loop) is_taken[v] = 1;
    loops.push_back(loop);
  }

  std::size_t most;
  std::vector<char> is_taken;  // per vertex
  std::vector<Loop> loops;
};

// Up to `most` loops to be cut at once; none if there is no handle.
std::vector<Loop> loops_of_round(const SurfaceMesh& mesh, Index most, int& searches,
                                 Progress& progress) {
  const MeshComponents components = connected_components(mesh, progress);
  std::vector<Index> roots(static_cast<std::size_t>(components.count), kNone);
  for (Index v = mesh.vertex_slots(); v-- > 0;) roots[components.of_vertex[v]] = v;
  ++searches;
  std::vector<Loop> found = loops_from(mesh, roots, progress);
  if (found.empty()) return {};

  const std::size_t longest = kLongest * found.front().size();
  PathTree tree(mesh);
  Disjoint as_found(mesh, most), shorter(mesh, most);
  for (const Loop& loop : found) {
    if (loop.size() <= longest) as_found.add(loop);
    if (most > 1) shorter.add(shortened_nearby(mesh, tree, loop, longest, progress));
  }
  // Loops found nearby may separate the surface; those found from afar do not.
  keep_inseparable(mesh, shorter.loops, progress);
  std::vector<Loop>& chosen =
      2 * shorter.loops.size() > as_found.loops.size() ? shorter.loops : as_found.loops;
  if (chosen.size() > 1) return std::move(chosen);
  return {shortened(mesh, std::move(found.front()), searches, progress)};
}

// Opens the surface along loops that have no vertex in common, and closes each side with a fan.
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

}  // namespace

Index genus_of(const SurfaceMesh& mesh, Progress& progress) {
  return connected_components(mesh, progress).count - mesh.euler_characteristic() / 2;
}

GenusLimitReport limit_genus(SurfaceMesh& mesh, Index maximum, Progress& progress) {
  GenusLimitReport report;
  for (Index genus = genus_of(mesh, progress); genus > maximum; genus = genus_of(mesh, progress)) {
    const std::vector<Loop> loops =
        loops_of_round(mesh, genus - maximum, report.searches, progress);
    if (loops.empty()) break;
    cut_along(mesh, loops, progress);
    report.cut += static_cast<Index>(loops.size());
    ++report.rounds;
  }
  if (report.cut > 0) mesh.compact(progress);
  return report;
}

}  // namespace shrinkwrap
