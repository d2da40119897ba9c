// From the algorithm's result to a vcg mesh, with everything that the samples carried.
#pragma once

#include <vcg/complex/complex.h>

#include <type_traits>
#include <typeinfo>
#include <vector>

#include "point_cloud_from_vcg.h"
#include "report/result_mesh.h"

namespace shrinkwrap {
namespace internal {

constexpr std::size_t kNoVertex = static_cast<std::size_t>(-1);

// Whether vertices have data that others could have too; components of other kinds do not count.
template <class CloudMesh>
bool carries_data(const CloudMesh& cloud) {
  return vcg::tri::HasPerVertexColor(cloud) || vcg::tri::HasPerVertexQuality(cloud) ||
         vcg::tri::HasPerVertexRadius(cloud) || vcg::tri::HasPerVertexTexCoord(cloud) ||
         !cloud.vert_attr.empty();
}

// Zero, also of types that leave their memory as it was.
template <class Value>
Value zero() {
  if constexpr (std::is_arithmetic<Value>::value)
    return Value(0);
  else
    return Value(0, 0, 0);
}

// Copies the custom per-vertex attributes of exactly one type, by sample. (The library's own
// look-up takes any type of the same size for it.)
template <class Value, class CloudMesh, class Mesh>
void copy_vertex_attributes(const CloudMesh& cloud, const std::vector<std::size_t>& cloud_vertex,
                            Mesh& mesh) {
  for (const auto& attribute : cloud.vert_attr) {
    if (attribute._name.empty() || attribute._padding != 0 || attribute._type != typeid(Value))
      continue;
    typename CloudMesh::template PerVertexAttributeHandle<Value> from(attribute._handle,
                                                                      attribute.n_attr);
    auto to =
        vcg::tri::Allocator<Mesh>::template GetPerVertexAttribute<Value>(mesh, attribute._name);
    for (std::size_t v = 0; v < cloud_vertex.size(); ++v)
      to[v] = cloud_vertex[v] == kNoVertex ? zero<Value>() : from[cloud_vertex[v]];
  }
}

// Computes the normals that the mesh has, of vertices and of faces each by itself: optional ones
// only while they are enabled, and only those of the type of the coordinates. (Elements without
// normals name a type for them all the same.)
template <class Mesh>
void update_normals(Mesh& mesh) {
  using Coordinates = typename Mesh::CoordType;
  if constexpr (std::is_same<typename Mesh::FaceType::NormalType, Coordinates>::value)
    if (vcg::tri::HasPerFaceNormal(mesh)) vcg::tri::UpdateNormal<Mesh>::PerFaceNormalized(mesh);
  if constexpr (std::is_same<typename Mesh::VertexType::NormalType, Coordinates>::value)
    if (vcg::tri::HasPerVertexNormal(mesh)) {
      vcg::tri::UpdateNormal<Mesh>::PerVertexAngleWeighted(mesh);
      vcg::tri::UpdateNormal<Mesh>::NormalizePerVertex(mesh);
    }
}

}  // namespace internal

/// Replaces the content of `mesh`, custom attributes too, by a result. A vertex that stands for a
/// sample gets what that vertex of the cloud has (of the components that both meshes have enabled:
/// colour, quality, radius, texture coordinates ..., and custom attributes of type float, double,
/// int and vcg::Point3); others get what the vertex of `data_index` has, or the defaults.
/// Coordinates are the result's, normals, if there are any, are computed and point outwards (points
/// without faces keep theirs), nothing is selected but `marked_faces`; the bounding box is updated.
/// Pre: `result` was made from `points` of `cloud`, which is another mesh. O(V + F).
template <class CloudMesh, class Mesh>
void mesh_to_vcg(const ResultMesh& result, const CloudMesh& cloud, const VcgPoints& points,
                 Mesh& mesh, const std::vector<Index>& marked_faces = {}) {
  using Coordinates = typename Mesh::CoordType;
  using Scalar = typename Mesh::ScalarType;

  mesh.Clear();
  // It would keep these, and optional components their values.
  mesh.ClearAttributes();
  mesh.textures.clear();
  mesh.normalmaps.clear();
  mesh.vert.resize(0);
  mesh.face.resize(0);
  vcg::tri::Allocator<Mesh>::AddVertices(mesh, result.position.size());
  vcg::tri::Allocator<Mesh>::AddFaces(mesh, result.triangles.size());

  const std::vector<Index>& source =
      result.data_index.empty() ? result.input_index : result.data_index;
  std::vector<std::size_t> cloud_vertex(result.position.size(), internal::kNoVertex);
  for (std::size_t v = 0; v < result.position.size(); ++v) {
    auto& vertex = mesh.vert[v];
    if (const Index input = source[v]; input != kNone) {
      cloud_vertex[v] = points.vertex_index[static_cast<std::size_t>(input)];
      vertex.ImportData(cloud.vert[cloud_vertex[v]]);
      vertex.Flags() = 0;
    }
    const Vec3& p = result.position[v];
    vertex.P() = Coordinates(static_cast<Scalar>(p[0]), static_cast<Scalar>(p[1]),
                             static_cast<Scalar>(p[2]));
  }
  for (std::size_t f = 0; f < result.triangles.size(); ++f)
    for (int corner = 0; corner < 3; ++corner)
      mesh.face[f].V(corner) = &mesh.vert[static_cast<std::size_t>(result.triangles[f][corner])];
  for (const Index f : marked_faces) mesh.face[static_cast<std::size_t>(f)].SetS();

  internal::copy_vertex_attributes<float>(cloud, cloud_vertex, mesh);
  internal::copy_vertex_attributes<double>(cloud, cloud_vertex, mesh);
  internal::copy_vertex_attributes<int>(cloud, cloud_vertex, mesh);
  internal::copy_vertex_attributes<vcg::Point3f>(cloud, cloud_vertex, mesh);
  internal::copy_vertex_attributes<vcg::Point3d>(cloud, cloud_vertex, mesh);

  vcg::tri::UpdateBounding<Mesh>::Box(mesh);
  // Points keep the normals that they brought.
  if (!result.triangles.empty()) internal::update_normals(mesh);
}

}  // namespace shrinkwrap
