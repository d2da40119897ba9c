// Self-intersections of a triangle mesh: exact, near-linear.
#pragma once

#include <utility>
#include <vector>

#include "box_tree.h"
#include "progress.h"
#include "surface_mesh.h"
#include "triangle_pair.h"

namespace shrinkwrap {

/// Pairs of faces (f < g, ascending) that cut, touch or overlap each other away from the corners
/// and edges they share. Exact predicates decide. Corners are shared if their indices are equal.
/// Degenerate faces (collinear corners), removed ones, and faces with corners that are not finite
/// are left out. O(F log F) for a surface, and in the number of pairs.
std::vector<std::pair<Index, Index>> self_intersections(const std::vector<Vec3>& positions,
                                                        const std::vector<Triangle>& triangles,
                                                        Progress& progress);

/// The same with a tree and a pair test made of the positions and triangles beforehand.
std::vector<std::pair<Index, Index>> self_intersections(const BoxTree& tree,
                                                        const TrianglePairs& test,
                                                        const std::vector<Triangle>& triangles,
                                                        Progress& progress);

/// The faces of such pairs, ascending, each once.
std::vector<Index> intersecting_faces(const std::vector<std::pair<Index, Index>>& pairs);

/// The same faces straight from the mesh: memory O(F) however many pairs there are, and pairs of
/// faces that are known already are not tested.
std::vector<Index> self_intersecting_faces(const std::vector<Vec3>& positions,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress);

/// The same with a tree and a pair test made of the positions and triangles beforehand.
std::vector<Index> self_intersecting_faces(const BoxTree& tree, const TrianglePairs& test,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress);

}  // namespace shrinkwrap
