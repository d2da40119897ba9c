// Triangle meshes of vcglib, for the stages that start from a mesh and for the report.
#pragma once

#include "point_cloud_from_vcg.h"
#include "result_mesh.h"

namespace shrinkwrap {

/// A vcg mesh as plain arrays, with its selected faces.
struct VcgTriangles {
  ResultMesh mesh;  ///< live vertices and faces, in container order; no vertex is a sample
  std::vector<Index> selected_faces;  ///< indices into mesh.triangles, ascending
};

/// Pre: triangles only (a face of more corners gives its first three). O(V + F).
template <class TriangleMesh>
VcgTriangles triangles_from_vcg(const TriangleMesh& source) {
  VcgTriangles result;
  VcgPoints vertices = points_from_vcg(source);
  std::vector<Index> new_index(source.vert.size(), kNone);
  for (std::size_t i = 0; i < vertices.vertex_index.size(); ++i)
    new_index[vertices.vertex_index[i]] = static_cast<Index>(i);
  result.mesh.position = std::move(vertices.points);
  result.mesh.input_index.assign(result.mesh.position.size(), kNone);
  result.mesh.triangles.reserve(static_cast<std::size_t>(source.FN()));
  for (const auto& face : source.face) {
    if (face.IsD()) continue;
    Triangle triangle;
    for (int corner = 0; corner < 3; ++corner)
      triangle[corner] = new_index[static_cast<std::size_t>(face.cV(corner) - &source.vert[0])];
    if (face.IsS())
      result.selected_faces.push_back(static_cast<Index>(result.mesh.triangles.size()));
    result.mesh.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace shrinkwrap
