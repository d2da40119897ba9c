#include "mesh/box_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/parallel.h"
#include "common/radix_sort.h"
#include "geometry/morton.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 13;
constexpr float kFar = std::numeric_limits<float>::max();
constexpr int kCellBits = 10;  // per axis of the curve that orders the faces
constexpr int kDigits = 1 << kCellBits;

// Coordinates are at most 1, sums of three products in single precision are off by less than 1e-6.
constexpr double kSlabMargin = 2e-6;

// What is sorted: the place on the curve in the high half, the face in the low half.
using KeyedFace = std::uint64_t;

bool is_usable(const std::vector<Vec3>& positions, const Triangle& t) {
  const Index vertices = static_cast<Index>(positions.size());
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
  for (Index v : t)
    if (v < 0 || v >= vertices || !positions[v].allFinite()) return false;
  return true;
}

}  // namespace

BoxTree::Group BoxTree::empty_group() {
  Group group;
  for (Index lane = 0; lane < 4; ++lane)
    put_box(group, lane, {kFar, kFar, kFar, -kFar, -kFar, -kFar});
  return group;
}

BoxTree::Box BoxTree::union_of(const Group& group) {
  Box box = box_in(group, 0);
  for (Index lane = 1; lane < 4; ++lane)
    for (int axis = 0; axis < 3; ++axis) {
      box[axis] = std::min(box[axis], group.low[axis][lane]);
      box[axis + 3] = std::max(box[axis + 3], group.high[axis][lane]);
    }
  return box;
}

BoxTree::Box BoxTree::box_of(const std::vector<Vec3>& positions, const Triangle& t) const {
  const Vec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
  const Vec3 low = (a.cwiseMin(b).cwiseMin(c) - center_) * scale_;
  const Vec3 high = (a.cwiseMax(b).cwiseMax(c) - center_) * scale_;
  return {static_cast<float>(low.x()),  static_cast<float>(low.y()),  static_cast<float>(low.z()),
          static_cast<float>(high.x()), static_cast<float>(high.y()), static_cast<float>(high.z())};
}

BoxTree::Box BoxTree::box_of(const std::vector<Vec3>& positions,
                             const std::vector<Triangle>& triangles) const {
  Box all = box_of(positions, triangles.front());
  for (const Triangle& t : triangles) {
    const Box box = box_of(positions, t);
    for (int axis = 0; axis < 3; ++axis) {
      all[axis] = std::min(all[axis], box[axis]);
      all[axis + 3] = std::max(all[axis + 3], box[axis + 3]);
    }
  }
  return all;
}

BoxTree::Slabs BoxTree::slabs_of(const std::vector<Vec3>& positions, const Triangle& t) const {
  std::array<Vec3, 3> corner;
  for (std::size_t i = 0; i < 3; ++i) corner[i] = (positions[t[i]] - center_) * scale_;
  const Vec3 normal = unit_or_zero(Vec3((corner[1] - corner[0]).cross(corner[2] - corner[0])));
  Slabs slabs;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 axis =
        i == 3 ? normal : unit_or_zero(Vec3((corner[(i + 1) % 3] - corner[i]).cross(normal)));
    Slab& slab = slabs[i];
    const double along[3] = {axis.dot(corner[0]), axis.dot(corner[1]), axis.dot(corner[2])};
    slab.low = static_cast<float>(std::min({along[0], along[1], along[2]}) - kSlabMargin);
    slab.high = static_cast<float>(std::max({along[0], along[1], along[2]}) + kSlabMargin);
    for (std::size_t k = 0; k < 3; ++k)
      slab.axis[k] = static_cast<float>(axis[static_cast<Eigen::Index>(k)]);
  }
  return slabs;
}

BoxTree::BoxTree(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                 Progress& progress) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& p : positions)
    if (p.allFinite()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  if (!(low.x() <= high.x())) return;
  center_ = 0.5 * low + 0.5 * high;
  scale_ = 1.0 / std::max((high - center_).maxCoeff(), 1e-300);

  // Boxes and places on the curve; what is not usable goes to the end and is cut off.
  const Index faces = static_cast<Index>(triangles.size());
  constexpr KeyedFace kUnusable = ~KeyedFace{0};
  std::vector<KeyedFace> keyed(triangles.size());
  parallel_for_each(faces, kGrain, progress, [&](Index f) {
    const Triangle& t = triangles[f];
    if (!is_usable(positions, t)) {
      keyed[f] = kUnusable;
      return;
    }
    const Box box = box_of(positions, t);
    std::uint32_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float middle = 0.5f * (box[axis] + box[axis + 3]) + 1.0f;
      cell[axis] = static_cast<std::uint32_t>(
          std::clamp(middle * (kDigits / 2), 0.0f, static_cast<float>(kDigits - 1)));
    }
    keyed[f] = morton_key(cell[0], cell[1], cell[2]) << 32 | static_cast<std::uint32_t>(f);
  });
  keyed.erase(std::remove(keyed.begin(), keyed.end(), kUnusable), keyed.end());
  radix_sort(keyed, 32, 3 * kCellBits, progress, [](KeyedFace face) { return face; });
  order_.resize(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i)
    order_[i] = static_cast<Index>(keyed[i] & 0xffffffffu);
  keyed = {};
  if (order_.empty()) return;

  lay_out_levels();
  const Index count = static_cast<Index>(order_.size());
  parallel_for_each(count, kGrain, progress, [&](Index i) {
    put_box(group_[i / 4], i % 4, box_of(positions, triangles[order_[i]]));
  });
  fill_upper_levels(progress);
}

BoxTree::BoxTree(const BoxTree& whole, const Box& box)
    : center_(whole.center_), scale_(whole.scale_), is_part_(true) {
  std::vector<Box> boxes;
  whole.descend(box, 0, 0, [&](Index i) {
    const Group& group = whole.group(0, i);
    for (unsigned left = overlaps(group, box); left != 0; left &= left - 1) {
      const Index lane = kLowestLane[left];
      order_.push_back(whole.order_[4 * static_cast<std::size_t>(i) + lane]);
      boxes.push_back(box_in(group, lane));
    }
  });
  if (order_.empty()) return;
  lay_out_levels();
  for (std::size_t i = 0; i < boxes.size(); ++i)
    put_box(group_[i / 4], static_cast<Index>(i % 4), boxes[i]);
  Progress silent;
  fill_upper_levels(silent);
}

void BoxTree::lay_out_levels() {
  std::size_t total = 0;
  for (std::size_t entries = order_.size();; entries = (entries + 3) / 4) {
    level_begin_.push_back(total);
    total += (entries + 3) / 4;
    if (entries <= 4) break;
  }
  group_.assign(total, empty_group());
}

void BoxTree::fill_upper_levels(Progress& progress) {
  for (std::size_t level = 1; level < level_begin_.size(); ++level) {
    const std::size_t below = level_begin_[level - 1];
    const Index entries = static_cast<Index>(level_begin_[level] - below);
    parallel_for_each(entries, kGrain, progress, [&](Index i) {
      put_box(group_[level_begin_[level] + i / 4], i % 4, union_of(group_[below + i]));
    });
  }
}

Index BoxTree::place_of(Index face) const {
  if (!is_part_) return place_[face];
  return *std::lower_bound(place_.begin(), place_.end(), face,
                           [&](Index place, Index f) { return order_[place] < f; });
}

void BoxTree::set_box(Index face, const Box& box) {
  if (place_.empty() && is_part_) {
    place_.resize(order_.size());
    std::iota(place_.begin(), place_.end(), 0);
    std::sort(place_.begin(), place_.end(),
              [&](Index a, Index b) { return order_[a] < order_[b]; });
  } else if (place_.empty()) {
    const Index highest = *std::max_element(order_.begin(), order_.end());
    place_.assign(static_cast<std::size_t>(highest) + 1, kNone);
    for (std::size_t i = 0; i < order_.size(); ++i) place_[order_[i]] = static_cast<Index>(i);
  }
  Index entry = place_of(face);
  Box entry_box = box;
  for (const std::size_t begin : level_begin_) {
    Group& group = group_[begin + entry / 4];
    put_box(group, entry % 4, entry_box);
    entry_box = union_of(group);
    entry /= 4;
  }
}

}  // namespace shrinkwrap
