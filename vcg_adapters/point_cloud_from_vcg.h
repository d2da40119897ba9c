// Points and meshes of vcglib, for the algorithm.
#pragma once

#include <cstddef>
#include <vector>

#include "common/types.h"

namespace shrinkwrap {

/// The samples of a vcg mesh, and where they came from.
struct VcgPoints {
  std::vector<Vec3> points;               ///< exact: a float coordinate is a double coordinate
  std::vector<std::size_t> vertex_index;  ///< of each point in the vertex container of the mesh
};

/// The live vertices of a vcg mesh, in container order; the selected ones alone if `selected_only`.
/// O(V).
template <class CloudMesh>
VcgPoints points_from_vcg(const CloudMesh& cloud, bool selected_only = false) {
  VcgPoints result;
  if (!selected_only) {
    result.points.reserve(static_cast<std::size_t>(cloud.VN()));
    result.vertex_index.reserve(static_cast<std::size_t>(cloud.VN()));
  }
  for (std::size_t i = 0; i < cloud.vert.size(); ++i) {
    const auto& vertex = cloud.vert[i];
    if (vertex.IsD() || (selected_only && !vertex.IsS())) continue;
    const auto& p = vertex.cP();
    result.points.emplace_back(p[0], p[1], p[2]);
    result.vertex_index.push_back(i);
  }
  return result;
}

}  // namespace shrinkwrap
