// Self-intersections of a triangle mesh: exact, near-linear.
#pragma once

#include <utility>
#include <vector>

#include "common/progress.h"
#include "mesh/box_tree.h"
#include "mesh/surface_mesh.h"
#include "mesh/triangle_pair.h"

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

/// Pairs of faces that meet, as far as they may be kept, and the faces of all of them.
struct KeptMeetings {
  std::vector<std::pair<Index, Index>> pairs;  ///< f < g, ascending
  std::vector<Index> faces;                    ///< that meet any other, ascending
  bool has_all_pairs = true;                   ///< surely
};

/// The same pairs, but of each cluster of the tree only the first `most_per_cluster` that come up
/// in it, so that a heap in which all faces meet each other takes no memory from the rest of the
/// mesh. The faces are exact nevertheless. Beyond the bound, pairs of faces that are both known to
/// meet others are not tested. Memory O(F) and the pairs kept.
KeptMeetings keep_meetings(const BoxTree& tree, const TrianglePairs& test,
                           const std::vector<Triangle>& triangles, std::size_t most_per_cluster,
                           Progress& progress);

/// The same with a tree made here, and a bound that no surface reaches.
KeptMeetings keep_meetings(const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& triangles, Progress& progress);

/// The faces, ascending, of pairs that are there now and were not before. If either lacks pairs:
/// those that meet others now and met none before.
std::vector<Index> newly_meeting_faces(const KeptMeetings& before, const KeptMeetings& now);

/// The faces of such pairs, ascending, straight from the mesh: memory O(F) however many pairs there
/// are, and pairs of faces that are known already are not tested.
std::vector<Index> self_intersecting_faces(const std::vector<Vec3>& positions,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress);

/// The same with a tree and a pair test made of the positions and triangles beforehand.
std::vector<Index> self_intersecting_faces(const BoxTree& tree, const TrianglePairs& test,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress);

}  // namespace shrinkwrap
