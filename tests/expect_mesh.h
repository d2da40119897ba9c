// What the tests expect of a mesh, judged from its list of triangles and by nothing of the library.
#pragma once

#include <utility>
#include <vector>

#include "complete_matching/complete_matching.h"
#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {

/// Topology of a list of triangles, counted from the faces alone.
struct Topology {
  Index vertices = 0;  ///< used by faces
  Index edges = 0;
  Index faces = 0;
  Index components = 0;
  Index bad_faces = 0;       ///< repeated or unknown vertex
  Index bad_edges = 0;       ///< not exactly two faces that run along them in opposite directions
  Index bad_vertices = 0;    ///< whose faces are not one closed fan
  Index split_vertices = 0;  ///< of these: nor one fan between two border edges
  bool closed_manifold() const {
    return faces > 0 && bad_faces == 0 && bad_edges == 0 && bad_vertices == 0;
  }
  Index euler_characteristic() const { return vertices - edges + faces; }
  /// Summed over the components. Pre: closed_manifold().
  Index genus() const { return components - euler_characteristic() / 2; }
};
Topology topology_of(Index vertices, const std::vector<Triangle>& triangles);

/// Fails unless the mesh is a closed, consistently oriented 2-manifold of so many components and of
/// that genus (summed over the components), and unless its own counts and links agree with it.
void expect_closed_manifold(const SurfaceMesh& mesh, Index components, Index genus);
/// The same for a list of triangles that uses all `vertices`.
void expect_closed_manifold(Index vertices, const std::vector<Triangle>& triangles,
                            Index components, Index genus);

/// Fails unless every sample is exactly one vertex, at its exact position, and the vertices that
/// are no sample are as many as the report says.
void expect_complete_matching(const CompleteMatching& matching, const PointCloud& cloud);

/// Fails unless the two are the same, index for index and bit for bit.
void expect_same_mesh(const SurfaceMesh& a, const SurfaceMesh& b);

/// Volume that a closed mesh encloses; positive if its faces are oriented outwards.
double signed_volume(const SurfaceMesh& mesh);

/// The faces of some pairs, ascending, each once.
std::vector<Index> faces_of_pairs(const std::vector<std::pair<Index, Index>>& pairs);

/// Mean over the area of the cosine between the normal of a face and that of the shape at its
/// centroid. `to_shape`: from the frame of the mesh to the shape's.
double normal_consistency(const SurfaceMesh& mesh, const Shape& shape, const Frame& to_shape = {});

}  // namespace shrinkwrap::testing
