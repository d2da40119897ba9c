// What CGAL says of a mesh, in a file of its own because it takes long to compile.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/copy_face_graph.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "judge.h"

namespace shrinkwrap::robustness {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Face = Mesh::Face_index;

Mesh to_cgal(const ResultMesh& mesh) {
  Mesh surface;
  std::vector<Mesh::Vertex_index> vertices;
  vertices.reserve(mesh.position.size());
  for (const Vec3& p : mesh.position) vertices.push_back(surface.add_vertex({p.x(), p.y(), p.z()}));
  for (const auto& [a, b, c] : mesh.triangles)
    surface.add_face(vertices[static_cast<std::size_t>(a)], vertices[static_cast<std::size_t>(b)],
                     vertices[static_cast<std::size_t>(c)]);
  return surface;
}

// Moved along each axis to where the coordinates are small, if that rounds nothing: CGAL's rays are
// rounded, far from the origin by as much as parts may be apart.
ResultMesh near_origin(ResultMesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : mesh.position) box.extend(p);
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = box.min()[axis];
    const auto is_exact = [&](const Vec3& p) {
      const double moved = p[axis] - origin;
      return moved + origin == p[axis] && p[axis] - moved == origin;
    };
    if (std::all_of(mesh.position.begin(), mesh.position.end(), is_exact))
      for (Vec3& p : mesh.position) p[axis] -= origin;
  }
  return mesh;
}

// Whether a closed surface encloses no more than moving it by the rounding of a coordinate would.
bool is_rounding(const Mesh& surface, double largest_coordinate) {
  constexpr double kRounding = 1e-15;
  const auto apex = surface.point(*surface.vertices().begin());  // the origin may be far away
  double volume = 0.0, area = 0.0;  // six times, twice; x largest coordinate
  for (const Face f : surface.faces()) {
    std::vector<Kernel::Vector_3> corner;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f)))
      corner.push_back((surface.point(v) - apex) / largest_coordinate);
    volume += CGAL::determinant(corner[0], corner[1], corner[2]);
    area += std::sqrt(
        CGAL::cross_product(corner[1] - corner[0], corner[2] - corner[0]).squared_length());
  }
  return std::abs(volume) <= 3.0 * kRounding * area;
}

}  // namespace

IntersectingFaces count_intersecting_faces(const ResultMesh& mesh) {
  const Mesh surface = to_cgal(mesh);
  std::vector<std::pair<Face, Face>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs));
  // A degenerate face is paired with itself.
  std::set<Face> faces, degenerate;
  for (const auto& [f, g] : pairs)
    if (f == g) degenerate.insert(f);
  for (const auto& [f, g] : pairs) {
    if (degenerate.count(f) > 0 || degenerate.count(g) > 0) continue;
    faces.insert(f);
    faces.insert(g);
  }
  return {static_cast<Index>(faces.size()), static_cast<Index>(degenerate.size())};
}

bool bounds_a_volume(const ResultMesh& mesh) {
  double largest = 0.0;
  for (const Vec3& p : mesh.position) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  std::vector<Mesh> components;
  CGAL::Polygon_mesh_processing::split_connected_components(to_cgal(near_origin(mesh)), components);
  Mesh thick;
  for (const Mesh& component : components)
    if (!is_rounding(component, largest)) CGAL::copy_face_graph(component, thick);
  // Of no component CGAL says no.
  return thick.is_empty() || CGAL::Polygon_mesh_processing::does_bound_a_volume(thick);
}

}  // namespace shrinkwrap::robustness
