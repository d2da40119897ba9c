#include "expect_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <set>
#include <utility>

namespace shrinkwrap::testing {
namespace {

Index find_root(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

// Of directed edges sorted by (from, to): those that are not one of a pair of opposite ones.
Index count_bad_edges(const std::vector<std::pair<Index, Index>>& directed, Index& edges) {
  Index bad = 0;
  edges = 0;
  const auto count_of = [&](Index from, Index to) {
    const auto range = std::equal_range(directed.begin(), directed.end(), std::pair(from, to));
    return range.second - range.first;
  };
  for (std::size_t i = 0; i < directed.size(); ++i) {
    if (i > 0 && directed[i] == directed[i - 1]) continue;
    const auto [from, to] = directed[i];
    const auto opposite = count_of(to, from);
    if (from > to && opposite > 0) continue;  // counted from the other end
    ++edges;
    if (count_of(from, to) != 1 || opposite != 1) ++bad;
  }
  return bad;
}

enum class Fan { closed, open, none };

// The faces at a vertex are one closed fan if the edges opposite to it form one cycle, and an open
// one if they form one path.
Fan fan_of(std::vector<std::pair<Index, Index>> links) {
  std::sort(links.begin(), links.end());
  std::set<Index> ends;
  for (const auto& link : links) ends.insert(link.second);
  const auto first = std::find_if(links.begin(), links.end(),
                                  [&](const auto& link) { return ends.count(link.first) == 0; });
  const bool is_path = first != links.end();
  const Index begin = is_path ? first->first : links.front().first;
  Index current = begin;
  for (std::size_t steps = 1; steps <= links.size(); ++steps) {
    const auto next = std::lower_bound(links.begin(), links.end(), std::pair(current, Index{0}));
    if (next == links.end() || next->first != current) return Fan::none;
    current = next->second;
    if (current == begin) return steps == links.size() ? Fan::closed : Fan::none;
  }
  return is_path ? Fan::open : Fan::none;
}

}  // namespace

Topology topology_of(Index vertices, const std::vector<Triangle>& triangles) {
  Topology result;
  std::vector<std::pair<Index, Index>> directed;
  std::vector<std::vector<std::pair<Index, Index>>> links(vertices);
  std::vector<Index> parent(vertices);
  std::iota(parent.begin(), parent.end(), 0);
  result.faces = static_cast<Index>(triangles.size());
  for (const Triangle& t : triangles) {
    const bool known =
        std::all_of(t.begin(), t.end(), [&](Index v) { return v >= 0 && v < vertices; });
    if (!known || t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++result.bad_faces;
      continue;
    }
    for (int corner = 0; corner < 3; ++corner) {
      const Index a = t[corner], b = t[(corner + 1) % 3], c = t[(corner + 2) % 3];
      directed.emplace_back(a, b);
      links[a].emplace_back(b, c);
      parent[find_root(parent, a)] = find_root(parent, b);
    }
  }
  std::sort(directed.begin(), directed.end());
  result.bad_edges = count_bad_edges(directed, result.edges);
  for (Index v = 0; v < vertices; ++v) {
    if (links[v].empty()) continue;
    ++result.vertices;
    if (find_root(parent, v) == v) ++result.components;
    const Fan fan = fan_of(links[v]);
    result.bad_vertices += fan != Fan::closed;
    result.split_vertices += fan == Fan::none;
  }
  return result;
}

void expect_closed_manifold(Index vertices, const std::vector<Triangle>& triangles,
                            Index components, Index genus) {
  const Topology topology = topology_of(vertices, triangles);
  EXPECT_GT(topology.faces, 0);
  EXPECT_EQ(topology.vertices, vertices) << "vertices without a face";
  EXPECT_EQ(topology.bad_faces, 0) << "faces with a repeated or unknown vertex";
  EXPECT_EQ(topology.bad_edges, 0) << "border, non-manifold or misoriented edges";
  EXPECT_EQ(topology.bad_vertices, 0) << "vertices of more than one fan";
  if (!topology.closed_manifold()) return;
  EXPECT_EQ(topology.components, components);
  EXPECT_EQ(topology.genus(), genus);
}

void expect_closed_manifold(const SurfaceMesh& mesh, Index components, Index genus) {
  EXPECT_TRUE(mesh.is_consistent());
  const std::vector<Triangle> triangles = mesh.triangles();
  EXPECT_EQ(static_cast<Index>(triangles.size()), mesh.face_count());
  // Removed slots are left out, so that a mesh may be judged before it is compacted.
  std::vector<Index> live(mesh.position.size(), kNone);
  Index count = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    if (!mesh.is_removed_vertex(v)) live[v] = count++;
  EXPECT_EQ(count, mesh.vertex_count());
  std::vector<Triangle> renumbered = triangles;
  for (Triangle& t : renumbered)
    for (Index& v : t) v = v >= 0 && v < mesh.vertex_slots() ? live[v] : kNone;
  expect_closed_manifold(count, renumbered, components, genus);
}

void expect_complete_matching(const CompleteMatching& matching, const PointCloud& cloud) {
  const SurfaceMesh& mesh = matching.mesh;
  ASSERT_EQ(matching.sample_of_vertex.size(), mesh.position.size());
  std::vector<int> matched(cloud.position.size(), 0);
  Index extra = 0, moved = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    EXPECT_FALSE(mesh.is_removed_vertex(v)) << "the mesh has free slots";
    const Index sample = to_index(matching.sample_of_vertex[v]);
    if (sample == kNone) {
      ++extra;
      continue;
    }
    ASSERT_GE(sample, 0);
    ASSERT_LT(sample, cloud.size());
    ++matched[sample];
    if (mesh.position[v] != cloud.position[sample]) ++moved;
  }
  EXPECT_EQ(moved, 0) << "vertices away from their sample";
  EXPECT_EQ(std::count(matched.begin(), matched.end(), 0), 0) << "samples that are no vertex";
  EXPECT_EQ(std::count_if(matched.begin(), matched.end(), [](int times) { return times > 1; }), 0)
      << "samples that are several vertices";
  EXPECT_EQ(extra, matching.report.extra_vertices);
}

void expect_same_mesh(const SurfaceMesh& a, const SurfaceMesh& b) {
  ASSERT_EQ(a.position.size(), b.position.size());
  EXPECT_EQ(a.triangles(), b.triangles());
  if (a.position.empty()) return;
  EXPECT_EQ(std::memcmp(a.position.data(), b.position.data(), a.position.size() * sizeof(Vec3)), 0)
      << "positions differ";
}

double signed_volume(const SurfaceMesh& mesh) {
  double six_fold = 0.0;
  for (const Triangle& t : mesh.triangles())
    six_fold += mesh.position[t[0]].dot(mesh.position[t[1]].cross(mesh.position[t[2]]));
  return six_fold / 6.0;
}

std::vector<Index> faces_of_pairs(const std::vector<std::pair<Index, Index>>& pairs) {
  std::set<Index> faces;
  for (const auto& [f, g] : pairs) faces.insert({f, g});
  return {faces.begin(), faces.end()};
}

double normal_consistency(const SurfaceMesh& mesh, const Shape& shape, const Frame& to_shape) {
  double sum = 0.0, area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles()) {
    const Vec3 &p = mesh.position[a], &q = mesh.position[b], &r = mesh.position[c];
    const Vec3 area_vector = (q - p).cross(r - p);
    sum += area_vector.dot(shape.normal(to_shape.to_input((p + q + r) / 3.0)));
    area += area_vector.norm();
  }
  return area > 0.0 ? sum / area : 0.0;
}

}  // namespace shrinkwrap::testing
