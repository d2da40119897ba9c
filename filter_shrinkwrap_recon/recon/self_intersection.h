// Self-intersections of a triangle mesh: exact, near-linear.
#pragma once

#include <utility>
#include <vector>

#include "progress.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// Pairs of faces (f < g, ascending) that cut, touch or overlap each other away from the corners and edges they
/// share. Exact predicates decide. Corners are shared if their indices are equal. O(F log F) for a surface.
std::vector<std::pair<Index, Index>> self_intersections(const std::vector<Vec3>& positions,
                                                        const std::vector<Triangle>& triangles, Progress& progress);

/// The faces of such pairs, ascending, each once.
std::vector<Index> intersecting_faces(const std::vector<std::pair<Index, Index>>& pairs);

}  // namespace shrinkwrap
