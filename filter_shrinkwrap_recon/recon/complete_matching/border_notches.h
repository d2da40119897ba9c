// Borders of openings made smooth: notches between neighbouring border samples are filled.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// The outline of the faces that are to be dropped becomes the border of an opening. It is ragged
/// where samples are irregular, for a membrane takes the place of triangles between samples. Where
/// the outline turns in at a sample by 26 degrees more than on average (around a hole of n samples,
/// 360 / n: a round hole has no notches, however few its samples; none if it turns out), and the
/// triangle of the sample and its two neighbours continues the faces around and has no edge above
/// 4 local spacings, flips of edges between dropped faces make that triangle, and so on along the
/// border. It is dropped no more: `is_dropped`, per face slot. Returns the number of triangles
/// made.
/// Pre: closed mesh, vertex i below `cloud.size()` is sample i, at its position.
/// Post: closed 2-manifold of the same topology and vertices; only dropped faces have changed, and
/// a notch that cannot be filled has changed none. O(F + N).
Index fill_border_notches(SurfaceMesh& mesh, const PointCloud& cloud, std::vector<char>& is_dropped,
                          Progress& progress);

}  // namespace shrinkwrap
