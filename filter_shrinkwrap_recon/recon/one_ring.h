// What walks around vertices tell.
#pragma once

#include <vector>

#include "sort_unique.h"
#include "surface_mesh.h"

namespace shrinkwrap {

struct OneRing {
  Vec3 difference_sum = Vec3::Zero();  ///< of the neighbours minus the vertex
  Vec3 normal = Vec3::Zero();          ///< area-weighted, unit
  Index valence = 0;

  Vec3 laplacian() const { return difference_sum / valence; }
};

inline OneRing gather_one_ring(const SurfaceMesh& mesh, Index v) {
  OneRing ring;
  const Vec3& p = mesh.position[v];
  mesh.for_each_outgoing(v, [&](Index h) {
    const Vec3 edge = mesh.position[mesh.target(h)] - p;
    ring.difference_sum += edge;
    ring.normal += edge.cross(mesh.position[mesh.opposite(h)] - p);
    ++ring.valence;
  });
  const double length = ring.normal.norm();
  ring.normal = length > 0.0 ? Vec3(ring.normal / length) : Vec3(0.0, 0.0, 1.0);
  return ring;
}

/// The faces that have one of these vertices, ascending.
inline std::vector<Index> faces_around(const SurfaceMesh& mesh,
                                       const std::vector<Index>& vertices) {
  std::vector<Index> faces;
  for (const Index v : vertices)
    mesh.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
  sort_unique(faces);
  return faces;
}

/// The vertices of these faces, ascending.
inline std::vector<Index> corners_of(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  std::vector<Index> corners;
  for (const Index f : faces)
    for (const Index v : mesh.triangle(f)) corners.push_back(v);
  sort_unique(corners);
  return corners;
}

}  // namespace shrinkwrap
