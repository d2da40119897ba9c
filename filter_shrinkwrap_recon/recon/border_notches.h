// Borders of openings made smooth: notches between neighbouring border samples are filled.
#pragma once

#include "point_cloud.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// Faces of membranes hold a vertex from `first_extra` on; their outline becomes the border of an
/// opening. It is ragged where samples are irregular, for a membrane takes the place of triangles
/// between samples. Where the outline turns in at a sample by an angle below 154 degrees, and the
/// triangle of the sample and its two neighbours continues the faces around and has no edge above
/// 4 local spacings, flips of membrane edges make that triangle, and so on along the border.
/// Returns the number of triangles made.
/// Pre: closed mesh, vertex i below `first_extra` is sample i of the cloud, at its position.
/// Post: closed 2-manifold of the same topology and vertices; only membrane faces have changed.
/// O(border).
Index fill_border_notches(SurfaceMesh& mesh, const PointCloud& cloud, Index first_extra,
                          Progress& progress);

}  // namespace shrinkwrap
