// The faces of a mesh that meet others, and their pairs, found anew.
#pragma once

#include "mesh/self_intersection.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap::testing {

inline Index count_pairs(const SurfaceMesh& mesh) {
  Progress progress;
  return static_cast<Index>(self_intersections(mesh.position, mesh.triangles(), progress).size());
}

inline Index count_meeting_faces(const SurfaceMesh& mesh) {
  Progress progress;
  return static_cast<Index>(
      self_intersecting_faces(mesh.position, mesh.triangles(), progress).size());
}

}  // namespace shrinkwrap::testing
