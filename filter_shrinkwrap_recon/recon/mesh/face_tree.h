// The face of a mesh nearest to a point, by a tree of boxes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/progress.h"
#include "geometry/triangle_geometry.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// A complete tree of boxes, four to a node, over the face slots of a mesh in their order: no
/// pointers, 32 bytes a face. It is as good as the order of the faces; that of a canonical mesh is
/// near enough to a Morton curve. Boxes are rounded outwards to floats, so that answers are exact.
/// The mesh must outlive the tree and have no removed faces. Queries are safe from any number of
/// threads.
class FaceTree {
 public:
  struct Hit {
    Index face = kNone;
    double weight_b = 0.0, weight_c = 0.0;  ///< of the second and third corner
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  /// How far the faces are from one query, for the queries near it. Where nearly all faces are
  /// equally far, as from the centre of a sphere, boxes rule out none of them; but what was far
  /// from the last query cannot be much nearer to the next. One for each thread; starts out empty,
  /// and stays so while searches look at few faces.
  class Anchor {
   public:
    std::int64_t looks() const { return looks_; }  ///< at faces, of all searches

   private:
    friend class FaceTree;
    // Looks of a search that make it worth while to measure the next one.
    static Index many(Index faces) { return std::max<Index>(256, faces / 64); }

    Vec3 place_ = Vec3::Zero();
    std::vector<float> distance_;  // per face; below 0: it was not looked at
    bool measures_next_ = false;
    std::int64_t looks_ = 0;
  };

  /// O(F), parallel.
  FaceTree(const SurfaceMesh& mesh, Progress& progress);

  /// The face nearest to the query, nearer than `squared_limit` (infinite: any) and accepted;
  /// face == kNone if there is none. Of several at one distance the first met, which depends on
  /// nothing but the arguments. `hint`: a face that is probably near, or kNone. `accept(face)` is
  /// asked only of faces nearer than the best so far. The answer does not depend on the `anchor`.
  template <class Accept>
  Hit nearest(const Vec3& query, double squared_limit, Index hint, const Accept& accept,
              Anchor& anchor) const;
  template <class Accept>
  Hit nearest(const Vec3& query, double squared_limit, Index hint, const Accept& accept) const {
    Anchor none;
    return nearest(query, squared_limit, hint, accept, none);
  }

 private:
  static constexpr Index kWidth = 4;     // boxes to a node
  static constexpr int kMaxLevels = 16;  // 4^16 exceeds what an Index counts
  using Lanes = Eigen::Array4f;
  struct Group {
    std::array<Lanes, 3> low, high;  // per axis
  };
  struct FloatBox {
    std::array<float, 3> low, high;
  };
  struct Entry {
    float bound;
    int level;  // of a node; kFace: a face
    Index index;
  };
  static constexpr int kFace = -1;

  static float rounded_down(double x) {
    const float f = static_cast<float>(x);
    return f - std::abs(f) * 2.4e-7f - std::numeric_limits<float>::min();
  }
  static float rounded_up(double x) { return -rounded_down(-x); }

  Group& group(int level, Index i) { return group_[level_begin_[level] + i]; }
  const Group& group(int level, Index i) const { return group_[level_begin_[level] + i]; }
  FloatBox box_of_face(Index f) const;
  static FloatBox box_of_group(const Group& group);
  static void put(Group& group, Index lane, const FloatBox& box);

  const SurfaceMesh& mesh_;
  Index faces_ = 0;
  int levels_ = 0;
  std::array<Index, kMaxLevels> level_begin_{};
  std::vector<Group> group_;  // the boxes of faces first, the root last
};

template <class Accept>
FaceTree::Hit FaceTree::nearest(const Vec3& query, double squared_limit, Index hint,
                                const Accept& accept, Anchor& anchor) const {
  Hit best;
  best.squared_distance = squared_limit;
  if (faces_ == 0) return best;
  const bool measures = anchor.measures_next_;
  if (measures) {
    anchor.place_ = query;
    anchor.distance_.assign(static_cast<std::size_t>(faces_), -1.0f);
  }
  const bool has_anchor = !measures && !anchor.distance_.empty();
  // Beyond what rounding can do to a distance, also that of a needle.
  constexpr double kMargin = 1e-5;
  const double moved = has_anchor ? (1.0 + kMargin) * (query - anchor.place_).norm() : 0.0;
  Index looks = 0, spared = 0;
  const auto look_at = [&](Index f) {
    if (has_anchor && anchor.distance_[f] >= 0.0f) {
      const double least = (1.0 - kMargin) * anchor.distance_[f] - moved;
      if (least > 0.0 && least * least >= best.squared_distance) {
        ++spared;
        return;
      }
    }
    ++looks;
    const Triangle t = mesh_.triangle(f);
    const TriangleFoot foot =
        foot_on_triangle(query, mesh_.position[t[0]], mesh_.position[t[1]], mesh_.position[t[2]]);
    if (measures) anchor.distance_[f] = static_cast<float>(std::sqrt(foot.squared_distance));
    if (foot.squared_distance < best.squared_distance && accept(f))
      best = {f, foot.weight_b, foot.weight_c, foot.squared_distance};
  };
  if (hint != kNone) look_at(hint);

  FloatBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = rounded_down(query[axis]);
    box.high[axis] = rounded_up(query[axis]);
  }
  std::array<Entry, (kWidth - 1) * kMaxLevels + 2> stack;
  int top = 0;
  stack[top++] = {0.0f, levels_ - 1, 0};
  while (top > 0) {
    const Entry entry = stack[--top];
    const float limit = rounded_up(best.squared_distance);
    if (!(entry.bound < limit)) continue;
    if (entry.level == kFace) {
      if (entry.index != hint) look_at(entry.index);
      continue;
    }
    const Group& node = group(entry.level, entry.index);
    Lanes bound = Lanes::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes beyond_low = node.low[axis] - box.high[axis],
                  beyond_high = box.low[axis] - node.high[axis];
      bound += beyond_low.max(beyond_high).max(0.0f).square();
    }
    bound *= 0.999999f;
    // Nearest on top of the stack; the factor above makes up for the rounding of the sum.
    const int bottom = top;
    for (Index lane = 0; lane < kWidth; ++lane) {
      const float lower = bound[lane];
      if (!(lower < limit)) continue;
      int slot = top++;
      for (; slot > bottom && stack[slot - 1].bound < lower; --slot) stack[slot] = stack[slot - 1];
      stack[slot] = {lower, entry.level - 1, kWidth * entry.index + lane};
    }
  }
  anchor.looks_ += looks;
  anchor.measures_next_ = !measures && looks > spared && looks > Anchor::many(faces_);
  return best;
}

}  // namespace shrinkwrap
