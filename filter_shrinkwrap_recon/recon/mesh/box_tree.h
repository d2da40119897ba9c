// Bounding boxes of faces, in a tree of fours over the Morton order of the faces.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Finds the faces whose bounding boxes overlap. Four boxes lie side by side in memory and are
/// compared at once; each entry of a level is the union of a group of four of the level below. 36
/// bytes a face.
///
/// Boxes are of single precision, relative to the middle of all faces. They need no margin: such
/// rounding is monotone, so intervals that have a point in common still have one afterwards.
class BoxTree {
 public:
  using Box = std::array<float, 6>;  ///< lowest x, y, z, then highest x, y, z

  BoxTree() = default;  ///< of no faces
  /// Leaves out faces with a coordinate that is not finite, with an index out of range or with one
  /// twice. Θ(F), parallel.
  BoxTree(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
          Progress& progress);
  /// The faces of another tree whose boxes overlap `box`, in its frame and order: the same boxes
  /// overlap one within it, and are found in fewer steps. O(log F) and O(n) for n such faces.
  BoxTree(const BoxTree& whole, const Box& box);

  Box box_of(const std::vector<Vec3>& positions, const Triangle& t) const;
  /// Of several triangles, not none.
  Box box_of(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) const;
  static bool overlap(const Box& a, const Box& b) {
    return a[0] <= b[3] && b[0] <= a[3] && a[1] <= b[4] && b[1] <= a[4] && a[2] <= b[5] &&
           b[2] <= a[5];
  }

  /// Calls `fn(face)` for each face whose box overlaps `box`, in Morton order.
  template <class Fn>
  void for_each_overlap(const Box& box, const Fn& fn) const;

  /// Calls `fn(face)` for the faces that may meet a triangle, in Morton order, until it returns
  /// true; returns whether it did. Passed over are faces whose box does not overlap the
  /// triangle's, lies all on one side of its plane, or in it beyond one of its edges: the box of a
  /// long slanting triangle holds much that the triangle is far from. Adds to `groups`, if given,
  /// how many groups of the tree overlap it, which is what a search costs beside its calls.
  template <class Fn>
  bool any_near(const std::vector<Vec3>& positions, const Triangle& t, const Fn& fn,
                std::int64_t* groups = nullptr) const;

  /// Pairs of faces whose boxes overlap are shared out among clusters of faces, some 64 each: calls
  /// `fn(f, g)`, each unordered pair once, over all clusters in [0, cluster_count()).
  Index cluster_count() const { return level_begin_.empty() ? 0 : level_size(cluster_level()); }
  template <class Fn>
  void for_each_overlapping_pair(Index cluster, const Fn& fn) const;

  /// Gives a face another box. O(log F). The first call takes another 4 bytes a face, and of a part
  /// sorts its faces. Pre: the tree has the face.
  void set_box(Index face, const Box& box);

 private:
  // Four boxes, each bound in a row of its own.
  struct Group {
    std::array<Eigen::Array4f, 3> low, high;
  };
  static constexpr Index kLowestLane[16] = {0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0};
  static constexpr int kMaxLevels = 17;
  static constexpr int kStackSize = 3 * kMaxLevels + 4;

  static Group empty_group();
  // The levels for as many faces as `order_` has, with empty boxes.
  void lay_out_levels();
  // All levels above the lowest, from it.
  void fill_upper_levels(Progress& progress);
  Index place_of(Index face) const;
  static Box box_in(const Group& group, Index lane) {
    return {group.low[0][lane],  group.low[1][lane],  group.low[2][lane],
            group.high[0][lane], group.high[1][lane], group.high[2][lane]};
  }
  static void put_box(Group& group, Index lane, const Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
      group.low[axis][lane] = box[axis];
      group.high[axis][lane] = box[axis + 3];
    }
  }
  static Box union_of(const Group& group);

  // One bit for each of the four boxes that overlaps.
  [[gnu::always_inline]] static inline unsigned overlaps(const Group& group, const Box& box) {
    const Eigen::Array4f x = (group.low[0] - box[3]).max(box[0] - group.high[0]);
    const Eigen::Array4f y = (group.low[1] - box[4]).max(box[1] - group.high[1]);
    const Eigen::Array4f z = (group.low[2] - box[5]).max(box[2] - group.high[2]);
    const Eigen::Array4f gap = x.max(y).max(z);
    return unsigned{gap[0] <= 0.0f} | unsigned{gap[1] <= 0.0f} << 1 |
           unsigned{gap[2] <= 0.0f} << 2 | unsigned{gap[3] <= 0.0f} << 3;
  }

  // What holds a triangle: the slabs between its corners across its edges and across its plane.
  struct Slab {
    std::array<float, 3> axis;
    float low, high;  // of the triangle along the axis, with a margin for rounding
  };
  using Slabs = std::array<Slab, 4>;
  static constexpr int kManyGroups = 48;  // that a box overlaps, before slabs are worth their time
  Slabs slabs_of(const std::vector<Vec3>& positions, const Triangle& t) const;
  static unsigned in_slabs(const Group& group, const Slabs& slabs, unsigned candidates);

  static constexpr int kClusterLevel = 2;
  int top_level() const { return static_cast<int>(level_begin_.size()) - 1; }
  int cluster_level() const { return std::min(kClusterLevel, top_level()); }
  Index level_size(int level) const {
    const std::size_t end = level == top_level() ? group_.size() : level_begin_[level + 1];
    return static_cast<Index>(end - level_begin_[level]);
  }
  const Group& group(int level, Index i) const { return group_[level_begin_[level] + i]; }

  // Calls `visit(i)` for the groups i >= first of a level that have a box in a group that overlaps,
  // ascending.
  template <class Visit>
  void descend(const Box& box, int to_level, Index first, const Visit& visit) const;
  // The pairs between two groups of a level; within one if they are the same.
  template <class Fn>
  void pairs_between(int level, Index a, Index b, const Box& box_of_b, const Fn& fn) const;

  Vec3 center_ = Vec3::Zero();
  double scale_ = 1.0;
  std::vector<Index> order_;  // faces along the Morton curve; four to a group of the lowest level
  std::vector<Index> place_;  // of each face in `order_`; filled when a box is set
  bool is_part_ = false;      // of another tree: `place_` then has its places only, by face
  std::vector<Group> group_;  // all levels, the lowest first
  std::vector<std::size_t> level_begin_;  // of each level in `group_`
};

template <class Visit>
void BoxTree::descend(const Box& box, int to_level, Index first, const Visit& visit) const {
  if (order_.empty()) return;
  struct Entry {
    int level;
    Index group;
  };
  std::array<Entry, kStackSize> stack;
  int top = 0;
  stack[top++] = {top_level(), 0};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.level == to_level) {
      visit(entry.group);
      continue;
    }
    const unsigned hits = overlaps(group(entry.level, entry.group), box);
    if (hits == 0) continue;
    const int below = entry.level - 1;
    for (Index lane = 4; lane-- > 0;) {
      const Index child = 4 * entry.group + lane;
      // Groups of `to_level` under this child end before (child + 1) * 4^(below - to_level).
      if ((hits >> lane & 1) != 0 &&
          (static_cast<std::int64_t>(child) + 1) << 2 * (below - to_level) > first)
        stack[top++] = {below, child};
    }
  }
}

template <class Fn>
void BoxTree::for_each_overlap(const Box& box, const Fn& fn) const {
  descend(box, 0, 0, [&](Index i) {
    const unsigned hits = overlaps(group(0, i), box);
    for (unsigned left = hits; left != 0; left &= left - 1)
      fn(order_[4 * static_cast<std::size_t>(i) + kLowestLane[left]]);
  });
}

inline unsigned BoxTree::in_slabs(const Group& group, const Slabs& slabs, unsigned candidates) {
  Eigen::Array4f gap = Eigen::Array4f::Zero();
  for (const Slab& slab : slabs) {
    Eigen::Array4f low = Eigen::Array4f::Zero(), high = low;  // of the boxes along the axis
    for (std::size_t i = 0; i < 3; ++i) {
      const bool rises = slab.axis[i] >= 0.0f;
      low += slab.axis[i] * (rises ? group.low[i] : group.high[i]);
      high += slab.axis[i] * (rises ? group.high[i] : group.low[i]);
    }
    gap = gap.max(low - slab.high).max(slab.low - high);
  }
  return candidates & (unsigned{gap[0] <= 0.0f} | unsigned{gap[1] <= 0.0f} << 1 |
                       unsigned{gap[2] <= 0.0f} << 2 | unsigned{gap[3] <= 0.0f} << 3);
}

template <class Fn>
bool BoxTree::any_near(const std::vector<Vec3>& positions, const Triangle& t, const Fn& fn,
                       std::int64_t* groups) const {
  if (order_.empty()) return false;
  const Box box = box_of(positions, t);
  Slabs slabs;
  struct Entry {
    int level;
    Index group;
  };
  std::array<Entry, kStackSize> stack;
  int top = 0, seen = 0;
  stack[top++] = {top_level(), 0};
  bool is_found = false;
  while (top > 0 && !is_found) {
    const Entry entry = stack[--top];
    const Group& boxes = group(entry.level, entry.group);
    unsigned hits = overlaps(boxes, box);
    if (hits == 0) continue;
    if (++seen == kManyGroups) slabs = slabs_of(positions, t);
    if (seen >= kManyGroups) hits = in_slabs(boxes, slabs, hits);
    if (entry.level > 0) {
      for (Index lane = 4; lane-- > 0;)
        if ((hits >> lane & 1) != 0) stack[top++] = {entry.level - 1, 4 * entry.group + lane};
      continue;
    }
    for (unsigned left = hits; left != 0 && !is_found; left &= left - 1)
      is_found = fn(order_[4 * static_cast<std::size_t>(entry.group) + kLowestLane[left]]);
  }
  if (groups != nullptr) *groups += seen;
  return is_found;
}

template <class Fn>
void BoxTree::pairs_between(int level, Index a, Index b, const Box& box_of_b, const Fn& fn) const {
  const Group& group_a = group(level, a);
  const unsigned candidates = overlaps(group_a, box_of_b);
  for (unsigned i_left = candidates; i_left != 0; i_left &= i_left - 1) {
    const Index i = kLowestLane[i_left], child_a = 4 * a + i;
    unsigned hits = overlaps(group(level, b), box_in(group_a, i));
    if (a == b) hits &= ~0u << i;
    for (unsigned j_left = hits; j_left != 0; j_left &= j_left - 1) {
      const Index j = kLowestLane[j_left], child_b = 4 * b + j;
      if (level > 0)
        pairs_between(level - 1, child_a, child_b, box_in(group(level, b), j), fn);
      else if (child_a != child_b)
        fn(order_[child_a], order_[child_b]);
    }
  }
}

template <class Fn>
void BoxTree::for_each_overlapping_pair(Index cluster, const Fn& fn) const {
  const int level = cluster_level();
  descend(union_of(group(level, cluster)), level, cluster, [&](Index other) {
    pairs_between(level, cluster, other, union_of(group(level, other)), fn);
  });
}

}  // namespace shrinkwrap
