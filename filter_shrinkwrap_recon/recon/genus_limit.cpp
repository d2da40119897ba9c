#include "genus_limit.h"

#include <algorithm>

#include "disjoint_sets.h"
#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr int kMostSearches = 12;  // for one handle, each from a place on the loop before
constexpr Index kUpdateInterval = 1 << 14;

// Shortest paths, by number of edges, from one vertex to all of its component.
class PathTree {
 public:
  PathTree(const SurfaceMesh& mesh, Index root, Progress& progress)
      : distance_(mesh.position.size(), kNone), toward_root_(mesh.position.size(), kNone) {
    distance_[root] = 0;
    reached_.push_back(root);
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      if (i % kUpdateInterval == 0) progress.update(0.0);
      const Index v = reached_[i];
      mesh.for_each_outgoing(v, [&](Index h) {
        const Index u = mesh.target(h);
        if (distance_[u] != kNone) return;
        distance_[u] = distance_[v] + 1;
        toward_root_[u] = mesh.twin(h);
        reached_.push_back(u);
      });
    }
  }

  const std::vector<Index>& reached() const { return reached_; }
  bool has_edge(const SurfaceMesh& mesh, Index h) const {
    return toward_root_[mesh.origin(h)] == h || toward_root_[mesh.target(h)] == mesh.twin(h);
  }
  Index loop_length(const SurfaceMesh& mesh, Index h) const {
    return distance_[mesh.origin(h)] + distance_[mesh.target(h)] + 1;
  }
  // The cycle of an edge and the paths from its ends to where they meet.
  std::vector<Index> loop(const SurfaceMesh& mesh, Index h) const {
    std::vector<Index> from_origin, from_target;
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

// The shortest loop through `root`, up to where its two ends part, that does not separate the
// surface; empty if its component has no handle. The edges outside the path tree join faces, those
// of long loops first; what joins nothing new closes a loop around or through a handle.
std::vector<Index> loop_through(const SurfaceMesh& mesh, Index root, Progress& progress) {
  const PathTree tree(mesh, root, progress);
  std::vector<std::pair<Index, Index>> edges;  // loop length, half-edge
  for (const Index v : tree.reached())
    mesh.for_each_outgoing(v, [&](Index h) {
      if (h < mesh.twin(h) && !tree.has_edge(mesh, h))
        edges.emplace_back(tree.loop_length(mesh, h), h);
    });
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  progress.update(0.0);
  DisjointSets sets(mesh.face_slots());
  std::vector<Index> shortest;
  for (const auto& [length, h] : edges) {
    if (sets.unite(SurfaceMesh::face(h), SurfaceMesh::face(mesh.twin(h)))) continue;
    std::vector<Index> loop = tree.loop(mesh, h);
    if (shortest.empty() || loop.size() < shortest.size()) shortest = std::move(loop);
  }
  return shortest;
}

std::vector<Index> short_loop(const SurfaceMesh& mesh, Index root, Progress& progress) {
  std::vector<Index> loop = loop_through(mesh, root, progress);
  for (int search = 1; search < kMostSearches && !loop.empty(); ++search) {
    std::vector<Index> shorter = loop_through(mesh, loop[loop.size() / 2], progress);
    if (shorter.size() >= loop.size()) break;
    loop = std::move(shorter);
  }
  return loop;
}

// Opens the surface along a loop and closes each side with a fan.
void cut_along(SurfaceMesh& mesh, const std::vector<Index>& loop, Progress& progress) {
  std::vector<Vec3> position = mesh.position;
  std::vector<Triangle> triangles = mesh.triangles();
  const std::size_t count = loop.size();
  const Index first_copy = static_cast<Index>(position.size());
  Vec3 centre = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Index v = loop[i], next = loop[(i + 1) % count], previous = loop[(i + count - 1) % count];
    centre += position[v] / static_cast<double>(count);
    position.push_back(position[v]);
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
    triangles.push_back(
        {first_copy + static_cast<Index>(i), first_copy + static_cast<Index>(next), right_centre});
  }
  mesh = SurfaceMesh::from_triangles(std::move(position), triangles, progress);
}

}  // namespace

Index genus_of(const SurfaceMesh& mesh, Progress& progress) {
  return connected_components(mesh, progress).count - mesh.euler_characteristic() / 2;
}

Index limit_genus(SurfaceMesh& mesh, Index maximum, Progress& progress) {
  Index genus = genus_of(mesh, progress), cut = 0;
  while (genus > maximum) {
    // A vertex of each component, until one has a handle.
    const MeshComponents components = connected_components(mesh, progress);
    std::vector<Index> root(static_cast<std::size_t>(components.count), kNone);
    for (Index v = mesh.vertex_slots(); v-- > 0;) root[components.of_vertex[v]] = v;
    std::vector<Index> loop;
    for (std::size_t c = 0; c < root.size() && loop.empty(); ++c)
      loop = short_loop(mesh, root[c], progress);
    if (loop.empty()) break;
    cut_along(mesh, loop, progress);
    ++cut;
    genus = genus_of(mesh, progress);
  }
  if (cut > 0) mesh.compact(progress);
  return cut;
}

}  // namespace shrinkwrap
