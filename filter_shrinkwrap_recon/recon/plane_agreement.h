// Whether a mesh goes where its samples say.
#pragma once

#include <vector>

#include "point_cloud.h"
#include "result_mesh.h"

namespace shrinkwrap {

/// The share of the area of a mesh of the samples, 0 to 1, in faces that stand across the tangent
/// planes there: a face whose normal has a cosine below 0.3, in the mean, with those of its
/// vertices (0 for one that is no sample of the cloud). Such faces bridge gaps, or run through
/// walls, where the surface that they were made on was wrong; at sharp edges and over openings
/// there are some in any mesh. `normals`: one per sample of the cloud, unit, turned outwards. O(F),
/// the same for any number of threads.
double area_across_planes(const ResultMesh& mesh, const PointCloud& cloud,
                          const std::vector<Vec3f>& normals, Progress& progress);

}  // namespace shrinkwrap
