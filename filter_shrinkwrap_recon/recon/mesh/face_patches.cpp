#include "mesh/face_patches.h"

#include <algorithm>
#include <unordered_set>

#include "common/sort_unique.h"

namespace shrinkwrap {

std::vector<Index> faces_around(const SurfaceMesh& mesh, const std::vector<Index>& vertices) {
  std::vector<Index> faces;
  for (const Index v : vertices)
    mesh.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
  sort_unique(faces);
  return faces;
}

std::vector<Index> corners_of(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  std::vector<Index> corners;
  for (const Index f : faces)
    for (const Index v : mesh.triangle(f)) corners.push_back(v);
  sort_unique(corners);
  return corners;
}

std::vector<Index> faces_near(const SurfaceMesh& mesh, std::vector<Index> faces, int rings) {
  for (int ring = 0; ring < rings; ++ring) faces = faces_around(mesh, corners_of(mesh, faces));
  return faces;
}

std::vector<Index> edges_of(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  std::vector<Index> edges;
  for (const Index f : faces)
    for (Index h = 3 * f; h < 3 * f + 3; ++h) edges.push_back(std::min(h, mesh.twin(h)));
  sort_unique(edges);
  return edges;
}

std::vector<std::vector<Index>> border_loops_of(const SurfaceMesh& mesh,
                                                const std::vector<char>& is_in) {
  const auto is_border = [&](Index h) {
    return is_in[SurfaceMesh::face(h)] && !is_in[SurfaceMesh::face(mesh.twin(h))];
  };
  std::vector<std::vector<Index>> loops;
  std::vector<char> is_passed(static_cast<std::size_t>(mesh.halfedge_slots()), 0);
  std::vector<Index> place(mesh.position.size(), kNone);  // of vertices, on the path
  std::vector<Index> path;
  // The path from there on has come back to where it began.
  const auto close_from = [&](Index begin) {
    const auto first = path.begin() + begin;
    for (auto h = first; h != path.end(); ++h) place[mesh.origin(*h)] = kNone;
    if (path.end() - first >= 3) loops.emplace_back(first, path.end());
    path.erase(first, path.end());
  };
  for (Index start = 0; start < mesh.halfedge_slots(); ++start) {
    if (is_passed[start] || !is_border(start)) continue;
    Index h = start;
    do {
      is_passed[h] = 1;
      const Index v = mesh.origin(h);
      if (place[v] != kNone) close_from(place[v]);
      place[v] = static_cast<Index>(path.size());
      path.push_back(h);
      for (h = SurfaceMesh::next(h); !is_border(h);) h = SurfaceMesh::next(mesh.twin(h));
    } while (h != start);
    close_from(0);
  }
  return loops;
}

std::vector<std::vector<Index>> clusters_of(
    const SurfaceMesh& mesh, const std::vector<Index>& faces,
    const std::function<const std::vector<Index>&(Index)>& linked) {
  std::vector<char> is_taken(faces.size(), 0);
  std::unordered_set<Index> seen;  // vertices: each star is looked at once, however large it is
  std::vector<std::vector<Index>> clusters;
  for (std::size_t first = 0; first < faces.size(); ++first) {
    if (is_taken[first]) continue;
    std::vector<Index> cluster;
    const auto take = [&](Index f) {
      const auto place = std::lower_bound(faces.begin(), faces.end(), f) - faces.begin();
      const auto i = static_cast<std::size_t>(place);
      if (i == faces.size() || faces[i] != f || is_taken[i]) return;
      is_taken[i] = 1;
      cluster.push_back(f);
    };
    take(faces[first]);
    for (std::size_t i = 0; i < cluster.size(); ++i) {
      const Index f = cluster[i];
      if (linked)
        for (const Index g : linked(f)) take(g);
      for (const Index v : mesh.triangle(f))
        if (seen.insert(v).second)
          mesh.for_each_outgoing(v, [&](Index h) { take(SurfaceMesh::face(h)); });
    }
    std::sort(cluster.begin(), cluster.end());
    clusters.push_back(std::move(cluster));
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return clusters;
}

}  // namespace shrinkwrap
