// Whether a mesh goes where its samples say.
#pragma once

#include <vector>

#include "report/result_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// The normal of each point of the input, unit: that of its sample, or of the sample that it is a
/// near copy of; zero if it is neither. As long as the last such point asks for.
/// Pre: `orient_normals` was called on the cloud.
std::vector<Vec3f> normals_of_points(const PointCloud& cloud);

/// The share of the area of a mesh, 0 to 1, in faces that stand across the tangent planes of their
/// vertices: a face whose normal has a cosine below 0.3, in the mean, with theirs (0 for a vertex
/// that has none). Such faces bridge gaps, or run through walls, where the surface that they were
/// made on was wrong; at sharp edges there are some in any mesh. Faces with a quality, which span
/// openings, are left out. `normals`: of the points that the mesh has its vertices from, turned
/// outwards (normals_of_points). `frame`: one in which the mesh is of moderate size.
/// O(F), the same for any number of threads.
double area_across_planes(const ResultMesh& mesh, const Frame& frame,
                          const std::vector<Vec3f>& normals, Progress& progress);

}  // namespace shrinkwrap
