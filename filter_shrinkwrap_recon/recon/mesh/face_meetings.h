// Which faces of a mesh meet which, kept up to date while faces change.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "common/progress.h"
#include "mesh/box_tree.h"
#include "mesh/surface_mesh.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {

/// The pairs of faces of a mesh that cut, touch or overlap each other (see `self_intersections`),
/// as they are and as they would be: a change is tried by `find` for the triangles that it would
/// make, and `replace` keeps the result. Pairs that are known are looked up, not tested again.
///
/// Tests have a hard bound, for heaps in which all faces meet each other: a triangle for which it
/// does not suffice is never said to meet few. So have the pairs that are kept, `kPairsPerFace` for
/// each face of the mesh: of a heap some are then not known of, and the faces that a change
/// replaces count as meeting fewer than they do. What is found for new faces is complete, so that
/// even then no change that seems to lower the number of pairs raises it.
class FaceMeetings {
 public:
  /// A face slot, and a face that it meets.
  using Pair = std::pair<Index, Index>;

  /// Pairs kept of each cluster of 64 faces: as many for each face, but in small meshes more, up to
  /// `kLeastPairs` in all. Surfaces have less than one a face.
  static constexpr std::size_t kPairsPerFace = 20;
  static constexpr std::size_t kLeastPairs = 100000;

  /// Finds the pairs, whatever the bound of tests; the mesh must outlive the object. `absent_faces`
  /// (ascending) meet nothing, and must not change. O(F log F) for a surface, and in the pairs of
  /// overlapping boxes: O(F^2) for a heap in which all do. Memory O(F).
  FaceMeetings(const SurfaceMesh& mesh, std::int64_t max_tests, Progress& progress,
               std::vector<Index> absent_faces = {});
  /// Of a patch of faces (ascending, not none) alone, as they are known: for changes among them
  /// while other patches change whose boxes do not overlap the patch's (`box_around`). Triangles
  /// between corners of the patch meet faces of no such other patch. What is told of all faces is
  /// told of these. O(n log n) for n faces whose boxes overlap the patch's.
  FaceMeetings(const FaceMeetings& whole, const std::vector<Index>& patch, std::int64_t max_tests);
  /// What has become of a patch, by the account of its own that was made for it. Its tests count
  /// here too. Pre: as many are left.
  void take_over(const std::vector<Index>& patch, const FaceMeetings& part);
  BoxTree::Box box_around(const std::vector<Index>& faces) const;

  Index pair_count() const { return pair_count_; }  ///< that are known
  bool has_all_pairs() const { return has_all_pairs_; }
  Index faces_at_first() const { return faces_at_first_; }  ///< that met others; exact
  std::vector<Index> faces() const;  ///< of the pairs that are known, ascending
  /// Faces that meet others, ascending, however many pairs are known. Searches for them if not all.
  std::vector<Index> all_faces(Progress& progress) const;
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
  std::int64_t tests_left() const { return tests_left_; }
  /// Allows for more tests.
  void grant(std::int64_t tests) {
    max_tests_ += tests;
    tests_left_ += tests;
  }
  bool has_tests_left() const { return tests_left_ > 0; }

 private:
  const SurfaceMesh& mesh_;
  std::vector<Index> absent_faces_;
  TrianglePairs test_;
  BoxTree tree_;
  std::unordered_map<Index, std::vector<Index>> met_;  // both ways; order within is of no avail
  Index pair_count_ = 0;
  Index faces_at_first_ = 0;
  bool has_all_pairs_ = true;
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
