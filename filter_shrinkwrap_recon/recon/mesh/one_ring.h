// What walks around vertices tell.
#pragma once

#include "mesh/surface_mesh.h"

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

}  // namespace shrinkwrap
