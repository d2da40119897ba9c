#include "judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "expect_mesh.h"

namespace shrinkwrap::robustness {
namespace {

using Coordinates = std::array<double, 3>;

Coordinates coordinates_of(const Vec3& p) {
  return {p.x() + 0.0, p.y() + 0.0, p.z() + 0.0};  // -0 becomes 0
}

std::vector<Coordinates> sorted(const std::vector<Vec3>& points) {
  std::vector<Coordinates> all;
  all.reserve(points.size());
  for (const Vec3& p : points)
    if (std::isfinite(p.x()) && std::isfinite(p.y()) && std::isfinite(p.z()))
      all.push_back(coordinates_of(p));
  std::sort(all.begin(), all.end());
  return all;
}

Index remove_repetitions(std::vector<Coordinates>& sorted_points) {
  const auto end = std::unique(sorted_points.begin(), sorted_points.end());
  const auto repeated = static_cast<Index>(sorted_points.end() - end);
  sorted_points.erase(end, sorted_points.end());
  return repeated;
}

void compare_with_samples(const std::vector<Vec3>& points, const std::vector<Index>& left_out,
                          const ResultMesh& mesh, Judgement& judgement) {
  std::vector<Vec3> wanted;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::binary_search(left_out.begin(), left_out.end(), static_cast<Index>(i)))
      wanted.push_back(points[i]);
  // A repetition of a point left out is left out with it.
  std::vector<Vec3> unwanted;
  for (const Index i : left_out) unwanted.push_back(points[static_cast<std::size_t>(i)]);
  std::vector<Coordinates> samples, vertices = sorted(mesh.position);
  {
    std::vector<Coordinates> kept = sorted(wanted);
    remove_repetitions(kept);
    const std::vector<Coordinates> dropped = sorted(unwanted);
    std::set_difference(kept.begin(), kept.end(), dropped.begin(), dropped.end(),
                        std::back_inserter(samples));
  }
  const auto not_finite = static_cast<Index>(mesh.position.size() - vertices.size());
  judgement.samples = static_cast<Index>(samples.size());
  judgement.vertices = static_cast<Index>(mesh.position.size());
  judgement.extra = not_finite;
  for (const Coordinates& vertex : vertices)
    judgement.extra += !std::binary_search(samples.begin(), samples.end(), vertex);
  judgement.repeated = remove_repetitions(vertices);
  judgement.missing = count_difference(samples, vertices);

  const auto given = static_cast<Index>(points.size());
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    const Index input = v < mesh.input_index.size() ? mesh.input_index[v] : kNone;
    if (input == kNone) continue;
    if (input < 0 || input >= given ||
        coordinates_of(mesh.position[v]) != coordinates_of(points[static_cast<std::size_t>(input)]))
      ++judgement.moved;
  }
}

Index count_border_edges(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (const auto& edge :
         {std::minmax(t[0], t[1]), std::minmax(t[1], t[2]), std::minmax(t[2], t[0])})
      edges.emplace_back(edge.first, edge.second);
  std::sort(edges.begin(), edges.end());
  Index border = 0;
  for (auto begin = edges.begin(); begin != edges.end();) {
    const auto end = std::upper_bound(begin, edges.end(), *begin);
    if (end - begin == 1) ++border;
    begin = end;
  }
  return border;
}

Index count_unused(const ResultMesh& mesh) {
  std::vector<bool> used(mesh.position.size(), false);
  for (const Triangle& triangle : mesh.triangles)
    for (const Index v : triangle)
      if (v >= 0 && v < static_cast<Index>(used.size())) used[static_cast<std::size_t>(v)] = true;
  return static_cast<Index>(std::count(used.begin(), used.end(), false));
}

// By the sign of the volume, scaled first: one of 1e-40 or 1e40 is beyond the range of the sum. Of
// a mesh as thin as the rounding of the sum, which points of garbage give, either side will do.
bool is_outward(const ResultMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : mesh.position) box.extend(p);
  const Vec3 origin = 0.5 * box.min() + 0.5 * box.max();
  const double size = 0.5 * box.max().maxCoeff() - 0.5 * box.min().minCoeff();
  constexpr double kRounding = 1e-15;
  double volume = 0.0, sum_of_sizes = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto corner = [&](Index v) {
      return Vec3((mesh.position[static_cast<std::size_t>(v)] - origin) / size);
    };
    volume += corner(a).dot(corner(b).cross(corner(c)));
    sum_of_sizes += corner(a).norm() * corner(b).norm() * corner(c).norm();
  }
  return volume > -kRounding * sum_of_sizes;
}

}  // namespace

Judgement judge(const std::vector<Vec3>& points, const std::vector<Index>& left_out,
                const ResultMesh& mesh, bool count_intersections) {
  Judgement judgement;
  compare_with_samples(points, left_out, mesh, judgement);
  const testing::Topology topology = testing::topology_of(judgement.vertices, mesh.triangles);
  judgement.unused = count_unused(mesh);
  judgement.border_edges = count_border_edges(mesh.triangles);
  judgement.components = topology.components;
  judgement.manifold = topology.faces > 0 && judgement.unused == 0 && topology.bad_faces == 0 &&
                       topology.bad_edges == judgement.border_edges && topology.split_vertices == 0;
  if (!judgement.manifold) return judgement;
  if (count_intersections) {
    const IntersectingFaces faces = count_intersecting_faces(mesh);
    judgement.intersecting = faces.intersecting;
    judgement.degenerate = faces.degenerate;
  }
  if (!judgement.closed()) return judgement;
  judgement.genus = topology.genus();
  judgement.outward = is_outward(mesh);
  if (judgement.intersecting == 0 && judgement.degenerate == 0 && judgement.components > 1)
    judgement.outward = judgement.outward && bounds_a_volume(mesh);
  return judgement;
}

}  // namespace shrinkwrap::robustness
