// Which faces of a mesh meet which, kept up to date while faces change.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "box_tree.h"
#include "progress.h"
#include "surface_mesh.h"
#include "triangle_pair.h"

namespace shrinkwrap {

/// The pairs of faces of a mesh that cut, touch or overlap each other (see `self_intersections`),
/// as they are and as they would be: a change is tried by `find` for the triangles that it would
/// make, and `replace` keeps the result. Pairs that are known are looked up, not tested again.
///
/// Tests have a hard bound, for heaps in which all faces meet each other: a triangle for which it
/// does not suffice is never said to meet few.
class FaceMeetings {
 public:
  /// A face slot, and a face that it meets.
  using Pair = std::pair<Index, Index>;

  /// Finds all pairs, beyond the bound; the mesh must outlive the object. O(F log F) for a surface.
  FaceMeetings(const SurfaceMesh& mesh, std::int64_t max_tests, Progress& progress);

  Index pair_count() const { return pair_count_; }
  std::vector<Index> faces() const;  ///< that meet others, ascending
  const std::vector<Index>& faces_met_by(Index f) const;
  /// Pairs with one or two of these faces, each once, ascending.
  std::vector<Pair> pairs_of(const std::vector<Index>& faces) const;

  /// Appends a pair of `slot` and g for each face g that the triangle meets and that `skip(g)` does
  /// not leave out. Returns false, with part of them, if there are more than `most`, or if the
  /// tests do not suffice.
  template <class Skip>
  bool find(const Triangle& t, Index slot, std::size_t most, const Skip& skip,
            std::vector<Pair>& pairs) const;
  /// Whether two triangles that are no faces meet.
  bool meet(const Triangle& f, const Triangle& g) const { return test_.meet(f, g); }
  /// Faces of a box that holds these triangles, as far as the tests suffice, which it counts as.
  std::vector<Index> faces_around(const std::vector<Triangle>& triangles) const;

  /// The boxes of these faces are those of the mesh from now on.
  void update_boxes(const std::vector<Index>& faces);
  /// The pairs of these faces are `pairs` from now on.
  void replace(const std::vector<Index>& faces, const std::vector<Pair>& pairs);

  std::int64_t tests() const { return max_tests_ - tests_left_; }
  bool has_tests_left() const { return tests_left_ > 0; }

 private:
  const SurfaceMesh& mesh_;
  TrianglePairs test_;
  BoxTree tree_;
  std::unordered_map<Index, std::vector<Index>> met_;  // both ways; order within is of no avail
  Index pair_count_ = 0;
  std::int64_t max_tests_;
  mutable std::int64_t tests_left_;
};

template <class Skip>
bool FaceMeetings::find(const Triangle& t, Index slot, std::size_t most, const Skip& skip,
                        std::vector<Pair>& pairs) const {
  bool is_known = true;
  const std::size_t given = pairs.size();
  tree_.any_near(mesh_.position, t, [&](Index g) {
    if (skip(g)) return false;
    is_known = --tests_left_ >= 0;
    if (is_known && test_.meet(t, mesh_.triangle(g))) {
      pairs.emplace_back(slot, g);
      is_known = pairs.size() - given <= most;
    }
    return !is_known;
  });
  tests_left_ = std::max<std::int64_t>(tests_left_, 0);
  return is_known;
}

}  // namespace shrinkwrap
