// Section 2.1: voxel-based nearest-point search, exact.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

/// Nearest samples by voxels (eq. 1: i = (x - x_min)/delta, and so on). The paper stops at the
/// first shell of voxels that holds a sample, which is not always the nearest, and its voxels have
/// one size. Here only occupied voxels are stored, each split into eight until few points are left
/// in it, so that memory is O(N) whatever the extent and the cost of a query does not depend on how
/// evenly the samples lie. Voxels are visited nearest first, until every unvisited one is provably
/// farther than the answer.
///
/// Immutable after construction: queries are safe from any number of threads.
class VoxelSearch {
 public:
  /// One answer: index into the points given, and its squared distance.
  struct Hit {
    Index index = kNone;
    double squared_distance = std::numeric_limits<double>::infinity();
    /// Nearer first; of equal distances the lower index.
    bool operator<(const Hit& other) const {
      return squared_distance < other.squared_distance ||
             (squared_distance == other.squared_distance && index < other.index);
    }
  };
  /// Consecutive positions in the order of the voxels: [begin, end).
  struct Range {
    Index begin = 0, end = 0;
  };

  VoxelSearch() = default;
  /// Pre: finite points, at most 2^31 - 1. O(N) if they come in Morton order, O(N log N)
  /// otherwise, and for points of one finest cell, of which there are few, O(n log^2 n).
  VoxelSearch(std::vector<Vec3> points, Progress& progress);  ///< throws Cancelled
  explicit VoxelSearch(std::vector<Vec3> points);             ///< silent

  bool empty() const { return point_.empty(); }
  Index size() const { return static_cast<Index>(point_.size()); }

  /// The nearest point; of several at one distance the one of lowest index. index == kNone if there
  /// are no points.
  Hit nearest(const Vec3& query) const;

  /// The nearest point no farther than `max_distance` for which `accept(index)` holds; index ==
  /// kNone if there is none. `accept` is asked only about points nearer than the best so far.
  template <class Accept>
  Hit nearest_if(const Vec3& query, double max_distance, const Accept& accept) const {
    Hit best;
    best.squared_distance = max_distance * max_distance;
    bool found = false;
    search(query, best.squared_distance, [&](const Range& range, double& limit) {
      for (Index i = range.begin; i < range.end; ++i) {
        const Hit hit{index_[i], (point_[i] - query).squaredNorm()};
        if (hit.squared_distance > limit || (found && !(hit < best)) || !accept(hit.index))
          continue;
        best = hit;
        found = true;
        limit = hit.squared_distance;
      }
    });
    return found ? best : Hit{};
  }

  /// The k nearest, nearest first (ties by index); fewer if there are fewer points. `hits` is
  /// replaced; with capacity for k nothing is allocated.
  void k_nearest(const Vec3& query, int k, std::vector<Hit>& hits) const;

  /// Points in the order of the voxels, for loops over whole neighbourhoods.
  const std::vector<Vec3>& ordered_points() const { return point_; }
  /// Of each point in the order of the voxels, its index in the points given.
  const std::vector<Index>& ordered_index() const { return index_; }
  /// Splits the order into the largest voxels of at most `max_points` points each, ascending.
  /// Ranges longer than that are points at one place. Pre: max_points >= kLeafPoints.
  std::vector<Range> groups(Index max_points) const;
  /// Calls `fn(range)`, ascending, for voxels that together hold all points within `distance` of
  /// the box [low, high], until it returns false.
  template <class Fn>
  void for_each_near_box(const Vec3& low, const Vec3& high, double distance, const Fn& fn) const;

  /// Beyond this many points a voxel is split, unless they all lie at one place.
  static constexpr Index kLeafPoints = 12;

 private:
  // An interval of floats around each coordinate of a box or point; the fourth lane is zero.
  struct FloatBox {
    Eigen::Array4f low = Eigen::Array4f::Zero(), high = Eigen::Array4f::Zero();
  };
  struct Node {
    FloatBox box;               // of the points, rounded outwards
    Index begin = 0, end = 0;   // their range
    Index first_child = kNone;  // children are consecutive; kNone: not split
    Index children = 0;
  };
  // Up to 21 splits into eight while keys differ, then into halves.
  static constexpr int kStackSize = 21 * 7 + 40;

  // Where a query may start: the coarse voxel it lies in.
  struct Start {
    Index node = 0;       // holds all points of the voxel; 0, the root, where there is none
    double margin = 0.0;  // distance of the query from the faces of the voxel, a little less
  };

  static FloatBox outward(const Vec3& low, const Vec3& high);
  void build(const std::vector<std::uint64_t>& keys, Progress& progress);
  Start start_of(const Vec3& query) const;
  void split_at_median(Range range);
  void compute_boxes(Progress& progress);

  // Lower bound of the squared distance between a box and a node. Intervals are rounded outwards;
  // the factor makes up for the rounding of the arithmetic. Finite, as limits may exceed all
  // floats.
  static float squared_distance_bound(const FloatBox& box, const Node& node) {
    const Eigen::Array4f d = (node.box.low - box.high).max(box.low - node.box.high).max(0.0f);
    return std::min(d.matrix().squaredNorm() * 0.999999f, std::numeric_limits<float>::max());
  }

  // Visits leaves whose points may be within the squared distance `limit`, nearest first.
  // `scan(range, limit)` may lower the limit.
  template <class Scan>
  void search(const Vec3& query, double limit, const Scan& scan) const;
  // The same for the leaves below `root`, but those below `skipped`.
  template <class Scan>
  void search_below(Index root, Index skipped, const FloatBox& box, double& limit,
                    const Scan& scan) const;

  void make(Progress& progress);

  std::vector<Vec3> point_;   // in the order of the voxels
  std::vector<Index> index_;  // of each of them in the points given
  std::vector<Node> node_;    // root first; parents before children
  // Coarse voxels, 2^start_bits_ per axis, at most one per four points: queries near the points
  // start there, far down.
  Vec3 low_ = Vec3::Zero();
  double start_voxels_ = 0.0;  // per unit length
  double start_slack_ = 0.0;   // more than what rounding may do to a margin
  int start_bits_ = 0;
  std::vector<Index> start_;  // by key; kNone if no single node holds the voxel's points
};

template <class Scan>
void VoxelSearch::search(const Vec3& query, double limit, const Scan& scan) const {
  if (node_.empty()) return;
  const FloatBox box = outward(query, query);
  const Start start = start_of(query);
  search_below(start.node, kNone, box, limit, scan);
  if (start.node != 0 && (start.margin <= 0.0 || limit >= start.margin * start.margin))
    search_below(0, start.node, box, limit, scan);
}

template <class Scan>
void VoxelSearch::search_below(Index root, Index skipped, const FloatBox& box, double& limit,
                               const Scan& scan) const {
  // A bound and a node in one integer: non-negative floats sort like their bits.
  std::array<std::uint64_t, kStackSize> stack;
  int top = 0;
  const auto bound_of = [](std::uint64_t entry) {
    const std::uint32_t bits = static_cast<std::uint32_t>(entry >> 32);
    float bound;
    std::memcpy(&bound, &bits, sizeof bound);
    return static_cast<double>(bound);
  };
  stack[top++] = static_cast<std::uint32_t>(root);
  while (top > 0) {
    const std::uint64_t entry = stack[--top];
    if (bound_of(entry) > limit) continue;
    const Node& node = node_[static_cast<std::uint32_t>(entry)];
    if (node.first_child == kNone) {
      scan(Range{node.begin, node.end}, limit);
      continue;
    }
    const int bottom = top;
    for (Index child = node.first_child; child < node.first_child + node.children; ++child) {
      const float bound = squared_distance_bound(box, node_[child]);
      if (bound > limit || child == skipped) continue;
      std::uint32_t bits;
      std::memcpy(&bits, &bound, sizeof bits);
      const std::uint64_t fresh =
          static_cast<std::uint64_t>(bits) << 32 | static_cast<std::uint32_t>(child);
      int slot = top++;
      for (; slot > bottom && stack[slot - 1] < fresh; --slot) stack[slot] = stack[slot - 1];
      stack[slot] = fresh;
    }
  }
}

template <class Fn>
void VoxelSearch::for_each_near_box(const Vec3& low, const Vec3& high, double distance,
                                    const Fn& fn) const {
  if (node_.empty()) return;
  const FloatBox box = outward(low, high);
  const double limit = distance * distance;
  std::array<Index, kStackSize> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = node_[stack[--top]];
    if (squared_distance_bound(box, node) > limit) continue;
    if (node.first_child == kNone) {
      if (!fn(Range{node.begin, node.end})) return;
    } else {
      for (Index child = node.first_child + node.children; child-- > node.first_child;)
        stack[top++] = child;
    }
  }
}

}  // namespace shrinkwrap
