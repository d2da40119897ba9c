// The whole method in one call, for programs on vcglib.
#pragma once

#include <tbb/task_arena.h>

#include <type_traits>

#include "mesh_to_vcg.h"
#include "point_cloud_from_vcg.h"
#include "progress_from_vcg.h"
#include "reconstruct.h"
#include "report/carried_data.h"

namespace shrinkwrap {

/// Reconstructs `cloud` into `mesh`, whose content is replaced on success and left alone otherwise.
/// Needs no normals; the mesh needs the precision of the cloud. Vertices that are no samples get
/// colours and other data of the nearest sample. Throws InvalidInput, also if `mesh` is the cloud,
/// Cancelled or ReconstructionFailed. Returns what is known of the run; its mesh was moved out.
///
///     MyMesh cloud, mesh;
///     vcg::tri::io::Importer<MyMesh>::Open(cloud, "cloud.ply");
///     shrinkwrap::shrinkwrap_reconstruct(cloud, mesh);
template <class CloudMesh, class Mesh>
Reconstruction shrinkwrap_reconstruct(const CloudMesh& cloud, Mesh& mesh,
                                      ReconstructionOptions options = {},
                                      vcg::CallBackPos* callback = nullptr,
                                      bool selected_only = false) {
  static_assert(sizeof(typename Mesh::ScalarType) >= sizeof(typename CloudMesh::ScalarType),
                "samples would lose digits on their way into the mesh");
  if (static_cast<const void*>(&cloud) == static_cast<const void*>(&mesh))
    throw InvalidInput("the mesh is to be another than the cloud, whose data it gets");
  options.host_scalar = std::is_same<typename Mesh::ScalarType, float>::value
                            ? HostScalar::single_precision
                            : HostScalar::double_precision;
  const VcgPoints points = points_from_vcg(cloud, selected_only);
  Progress progress(progress_from_vcg(callback), stages_of(options));
  Reconstruction result = reconstruct(points.points, options, progress);
  if (internal::carries_data(cloud)) {
    tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
    arena.execute(
        [&] { carry_data({&result.mesh}, points.points, result.outliers.input_index, progress); });
  }
  mesh_to_vcg(result.mesh, cloud, points, mesh);
  result.mesh = ResultMesh();
  return result;
}

}  // namespace shrinkwrap
