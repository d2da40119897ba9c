// Meshes in the caller's frame and terms: what leaves the pipeline, and what stages run one by one
// hand over.
#pragma once

#include <vector>

#include "complete_matching/complete_matching.h"
#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// A mesh in the caller's frame. Vertices that stand for samples have the caller's coordinates, to
/// the bit, unless the samples were moved onto a surface at which the run stopped.
struct ResultMesh {
  std::vector<Vec3> position;
  std::vector<Index>
      input_index;  ///< of each vertex in the caller's points; kNone if it is no sample
  /// Of each vertex the point of the caller whose colour and other data it has (carried_data.h).
  /// Empty: only samples have any, their own.
  std::vector<Index> data_index;
  std::vector<Triangle> triangles;
  std::vector<float> vertex_quality;  ///< empty, or what to colour the vertices by
  std::vector<float> face_quality;    ///< empty, or what to colour the faces by
};

/// An intermediate mesh (initial, control, parametric) in the frame of the input; no vertex is a
/// sample.
ResultMesh to_result(const SurfaceMesh& mesh, const Frame& frame, Progress& progress);

/// A complete matching: vertex i is the i-th distinct sample in the caller's order, extra vertices
/// follow. Faces keep their order. `points` are those that the cloud was prepared from.
ResultMesh to_result(const CompleteMatching& matching, const PointCloud& cloud,
                     const std::vector<Vec3>& points, Progress& progress);

/// Drops faces (indices ascending) and the extra vertices that are left without a face: a mesh with
/// openings.
void drop_faces(ResultMesh& mesh, const std::vector<Index>& faces, Progress& progress);
/// What `drop_faces(mesh, dropped)` made of the indices of faces (both ascending); those dropped
/// are left out.
std::vector<Index> indices_after_drop(const std::vector<Index>& faces,
                                      const std::vector<Index>& dropped);

/// The way back for a stage that starts from such a mesh: in the unit frame, same vertex and face
/// order. Throws InvalidInput if it is not a closed, consistently oriented 2-manifold of finite
/// vertices.
SurfaceMesh to_surface(const ResultMesh& mesh, const Frame& frame);

}  // namespace shrinkwrap
