// What CGAL says of a mesh, in a file of its own because it takes long to compile.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/copy_face_graph.h>

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
  namespace processing = CGAL::Polygon_mesh_processing;
  constexpr double kRounding = 1e-15;  // of a coordinate
  double largest = 0.0;
  for (const Vec3& p : mesh.position) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  std::vector<Mesh> components;
  processing::split_connected_components(to_cgal(mesh), components);
  Mesh thick;
  for (const Mesh& component : components)
    if (std::abs(processing::volume(component)) > kRounding * largest * processing::area(component))
      CGAL::copy_face_graph(component, thick);
  return processing::does_bound_a_volume(thick);
}

}  // namespace shrinkwrap::robustness
