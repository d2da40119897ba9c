// Outliers that the mesh through the other samples shows to be no strays.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"
#include "samples/outliers.h"

namespace shrinkwrap {

/// Makes samples again of the outliers that lie on a mesh through the other samples, and takes them
/// off the report. Samples far apart beside many close ones, as the vertices of a CAD model are,
/// seem stray by their distances; but that faces between samples far from each other, made without
/// one, meet it all the same is no chance. Farther ones may be strays in an opening. Returns how
/// many there are. Pre: `cloud` is the rest of `points`, as `exclude_outliers` left it, not
/// denoised; `mesh` is of it, in its frame. Post: the cloud has the samples in their order, with
/// neighbours, spacing, normals and planes, in the same frame. O(F + N) if there are outliers,
/// parallel; the same for any number of threads. Throws Cancelled, and cloud and report are then as
/// they were.
Index keep_outliers_on_surface(PointCloud& cloud, OutlierReport& report,
                               const std::vector<Vec3>& points, const SurfaceMesh& mesh,
                               const OutlierOptions& options, Progress& progress);

/// Makes samples again of the outliers that are among `vertices`, at their very coordinates: those
/// that an earlier stage kept. Vertices may be at any places, finite or not. Normals are arbitrary.
/// Pre, Post and Throws: as above.
void keep_outliers_among(PointCloud& cloud, OutlierReport& report, const std::vector<Vec3>& points,
                         const std::vector<Vec3>& vertices, Progress& progress);

}  // namespace shrinkwrap
