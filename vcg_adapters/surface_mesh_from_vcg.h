// Triangle meshes of vcglib, for the stages that start from a mesh and for the report.
#pragma once

#include <vcg/complex/complex.h>

#include "point_cloud_from_vcg.h"
#include "report/result_mesh.h"

namespace shrinkwrap {

/// A vcg mesh as plain arrays: live vertices and faces, in container order, and the face quality if
/// the mesh has one; no vertex is a sample. Pre: triangles only (a face of more corners gives its
/// first three). O(V + F).
template <class TriangleMesh>
ResultMesh triangles_from_vcg(const TriangleMesh& source) {
  ResultMesh result;
  const bool has_quality = vcg::tri::HasPerFaceQuality(source);
  VcgPoints vertices = points_from_vcg(source);
  std::vector<Index> new_index(source.vert.size(), kNone);
  for (std::size_t i = 0; i < vertices.vertex_index.size(); ++i)
    new_index[vertices.vertex_index[i]] = static_cast<Index>(i);
  result.position = std::move(vertices.points);
  result.input_index.assign(result.position.size(), kNone);
  result.triangles.reserve(static_cast<std::size_t>(source.FN()));
  for (const auto& face : source.face) {
    if (face.IsD()) continue;
    Triangle triangle;
    for (int corner = 0; corner < 3; ++corner)
      triangle[corner] = new_index[static_cast<std::size_t>(face.cV(corner) - &source.vert[0])];
    if (has_quality) result.face_quality.push_back(static_cast<float>(face.cQ()));
    result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace shrinkwrap
