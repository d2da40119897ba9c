// Samples that lie where others do, but for a little, become vertices at last.
#pragma once

#include <vector>

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

/// Inserts the copies of samples (near_copies.h) as vertices, at their own places. Around each
/// sample that has copies, the mesh is a height field over some plane, and its copies are inserted
/// there into the triangles below them, whose edges become Delaunay as seen along the normal of the
/// plane: of all directions that are tried the one that shows the triangles and the distances of
/// the copies best. So no face turns away from it, and none meets another as long as no other part
/// of the surface is that near. Triangles of faces that span openings span them too. Where a copy
/// lies in one that stays open, its border is moved out to it, or it goes into the nearest face
/// beside.
///
/// The copies become the vertices after all others, in the order of `cloud.conditioning`, and stand
/// for the samples `cloud.size()` and up (see `PointCloud::input_index_of`). Pre: vertex i below
/// `cloud.size()` is sample i; closed mesh without removed slots. Post: closed 2-manifold of the
/// same topology; faces keep their slots, further ones follow. O(C) expected.
void insert_near_copies(CompleteMatching& matching, const PointCloud& cloud,
                        const std::vector<Vec3>& points, Progress& progress);

}  // namespace shrinkwrap
