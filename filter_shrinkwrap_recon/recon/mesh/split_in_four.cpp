#include "mesh/split_in_four.h"

#include <limits>
#include <string>
#include <utility>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 13;

}  // namespace

std::vector<Index> edge_vertices(const SurfaceMesh& mesh) {
  if (mesh.face_slots() > std::numeric_limits<Index>::max() / 12)
    throw InvalidInput("a mesh of " + std::to_string(mesh.face_count()) +
                       " faces is too large to be subdivided: choose the control mesh");
  const Index halfedges = mesh.halfedge_slots();
  std::vector<Index> edge_vertex(static_cast<std::size_t>(halfedges));
  Index next_vertex = mesh.vertex_slots();
  for (Index h = 0; h < halfedges; ++h)
    if (h < mesh.twin(h)) edge_vertex[h] = edge_vertex[mesh.twin(h)] = next_vertex++;
  return edge_vertex;
}

SurfaceMesh split_in_four(const SurfaceMesh& mesh, const std::vector<Index>& edge_vertex,
                          std::vector<Vec3> position, Progress& progress) {
  const Index halfedges = mesh.halfedge_slots();
  // The edge of h falls into two halves, which run along the faces at both its ends.
  const auto at_corner = [](Index h) { return 3 * (4 * SurfaceMesh::face(h) + h % 3); };
  const auto first_half = [&](Index h) { return at_corner(h); };
  const auto second_half = [&](Index h) { return at_corner(SurfaceMesh::next(h)) + 2; };
  std::vector<Index> origin(4 * static_cast<std::size_t>(halfedges)), twin(origin.size());
  parallel_for_each(halfedges, kGrain, progress, [&](Index h) {
    const Index corner = at_corner(h), center = 3 * (4 * SurfaceMesh::face(h) + 3);
    const Index behind = SurfaceMesh::prev(h);
    origin[corner] = mesh.origin(h);
    origin[corner + 1] = edge_vertex[h];
    origin[corner + 2] = edge_vertex[behind];
    origin[center + h % 3] = edge_vertex[h];
    twin[first_half(h)] = second_half(mesh.twin(h));
    twin[second_half(h)] = first_half(mesh.twin(h));
    // The corner's inner edge runs from the middle ahead to that behind, the center's back.
    twin[corner + 1] = center + behind % 3;
    twin[center + behind % 3] = corner + 1;
  });
  return SurfaceMesh::from_halfedges(std::move(position), std::move(origin), std::move(twin));
}

}  // namespace shrinkwrap
