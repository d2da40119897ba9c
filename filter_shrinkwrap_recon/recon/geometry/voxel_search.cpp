#include "geometry/voxel_search.h"

#include <tbb/parallel_sort.h>

#include "common/parallel.h"
#include "geometry/morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;
constexpr int kKeyLevels = 21;  // bits per axis of a Morton key

// Floats that are certainly below and above a double, by less than three units in the last place.
// Not by comparing with the double: GCC 12 vectorises a narrowing and the widening after it into
// nothing.
constexpr float kLargest = 3e38f;
constexpr float kTiny = 1e-37f;
float to_float(double x) {
  return static_cast<float>(std::clamp<double>(x, -kLargest, kLargest));
}
float rounded_down(double x) {
  const float f = to_float(x);
  return f - (std::abs(f) * 0x1p-23f + kTiny);
}
float rounded_up(double x) {
  const float f = to_float(x);
  return f + (std::abs(f) * 0x1p-23f + kTiny);
}

// The voxel level at which two different keys part, counted from the finest.
int level_of_difference(std::uint64_t a, std::uint64_t b) {
  int level = 0;
  for (std::uint64_t difference = (a ^ b) >> 3; difference != 0; difference >>= 3) ++level;
  return level;
}

}  // namespace

VoxelSearch::VoxelSearch(std::vector<Vec3> points) : point_(std::move(points)) {
  Progress silent;
  make(silent);
}

VoxelSearch::VoxelSearch(std::vector<Vec3> points, Progress& progress) : point_(std::move(points)) {
  make(progress);
}

void VoxelSearch::make(Progress& progress) {
  if (point_.empty()) return;
  const Index count = size();
  index_.resize(point_.size());
  for (Index i = 0; i < count; ++i) index_[i] = i;
  const Box box = bounding_box(point_);
  low_ = box.low;
  const double extent = (box.high - box.low).maxCoeff();
  while (start_bits_ < 8 && std::int64_t{8} << (3 * start_bits_) <= count / 4) ++start_bits_;
  start_voxels_ = std::ldexp(morton_cells_per_length(box), start_bits_ - kKeyLevels);
  start_slack_ = 1e-9 * std::max(extent, 1e-300);
  start_.assign(std::size_t{1} << (3 * start_bits_), kNone);
  std::vector<std::uint64_t> keys = morton_keys(point_, box, progress);
  if (!std::is_sorted(keys.begin(), keys.end())) {
    tbb::parallel_sort(index_.begin(), index_.end(), [&](Index a, Index b) {
      return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
    });
    std::vector<Vec3> ordered_points(point_.size());
    std::vector<std::uint64_t> ordered_keys(point_.size());
    for (Index i = 0; i < count; ++i) {
      ordered_points[i] = point_[index_[i]];
      ordered_keys[i] = keys[index_[i]];
    }
    point_.swap(ordered_points);
    keys.swap(ordered_keys);
  }
  build(keys, progress);
  compute_boxes(progress);
}

// Breadth first: the node array is its own queue, and children come out consecutive and in order.
void VoxelSearch::build(const std::vector<std::uint64_t>& keys, Progress& progress) {
  const int start_shift = 3 * (kKeyLevels - start_bits_);
  node_.reserve(point_.size() / 2 + 1);
  Node root;
  root.end = size();
  node_.push_back(root);
  for (std::size_t n = 0; n < node_.size(); ++n) {
    if (n % kGrain == 0) progress.update(1.0);  // how many nodes there will be is not known
    const Index begin = node_[n].begin, end = node_[n].end;
    // The first node met whose points share a start voxel holds them all: parents come first.
    Index& start = start_[keys[begin] >> start_shift];
    if (start == kNone && keys[begin] >> start_shift == keys[end - 1] >> start_shift)
      start = static_cast<Index>(n);
    if (end - begin <= kLeafPoints) continue;
    const auto add_child = [&](Index child_begin, Index child_end) {
      Node child;
      child.begin = child_begin;
      child.end = child_end;
      if (node_[n].children++ == 0) node_[n].first_child = static_cast<Index>(node_.size());
      node_.push_back(child);
    };
    if (keys[begin] != keys[end - 1]) {
      const int shift = 3 * level_of_difference(keys[begin], keys[end - 1]);
      for (Index child = begin; child < end;) {
        const std::uint64_t voxel = keys[child] >> shift;
        const auto rest =
            std::partition_point(keys.begin() + child, keys.begin() + end,
                                 [&](std::uint64_t key) { return key >> shift == voxel; });
        const Index child_end = static_cast<Index>(rest - keys.begin());
        add_child(child, child_end);
        child = child_end;
      }
    } else {  // finer than keys tell apart, as when a far outlier stretches the bounding cube
      const bool one_place = std::all_of(point_.begin() + begin, point_.begin() + end,
                                         [&](const Vec3& p) { return p == point_[begin]; });
      if (one_place) continue;
      split_at_median({begin, end});
      const Index middle = begin + (end - begin) / 2;
      add_child(begin, middle);
      add_child(middle, end);
    }
  }
  node_.shrink_to_fit();
}

VoxelSearch::Start VoxelSearch::start_of(const Vec3& query) const {
  const double voxels = static_cast<double>(1 << start_bits_);
  std::uint32_t voxel[3];
  double margin = 0.5;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = (query[axis] - low_[axis]) * start_voxels_;
    if (!(x >= 0.0 && x < voxels)) return {};
    voxel[axis] = static_cast<std::uint32_t>(x);
    const double fraction = x - voxel[axis];
    margin = std::min({margin, fraction, 1.0 - fraction});
  }
  const Index node = start_[morton_key(voxel[0], voxel[1], voxel[2])];
  if (node == kNone) return {};
  return {node, margin / start_voxels_ - start_slack_};
}

void VoxelSearch::split_at_median(Range range) {
  std::vector<std::pair<Vec3, Index>> part;
  part.reserve(static_cast<std::size_t>(range.end - range.begin));
  Vec3 low = point_[range.begin], high = low;
  for (Index i = range.begin; i < range.end; ++i) {
    part.emplace_back(point_[i], index_[i]);
    low = low.cwiseMin(point_[i]);
    high = high.cwiseMax(point_[i]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const auto before = [axis](const auto& a, const auto& b) {
    return a.first[axis] != b.first[axis] ? a.first[axis] < b.first[axis] : a.second < b.second;
  };
  const auto middle = part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2);
  std::nth_element(part.begin(), middle, part.end(), before);
  // Points at one place must stay in the order of their indices, whatever nth_element did to them.
  const auto by_index = [](const auto& a, const auto& b) { return a.second < b.second; };
  std::sort(part.begin(), middle, by_index);
  std::sort(middle, part.end(), by_index);
  for (Index i = range.begin; i < range.end; ++i) {
    point_[i] = part[static_cast<std::size_t>(i - range.begin)].first;
    index_[i] = part[static_cast<std::size_t>(i - range.begin)].second;
  }
}

void VoxelSearch::compute_boxes(Progress& progress) {
  parallel_for_each(static_cast<Index>(node_.size()), kGrain, progress, [&](Index n) {
    Node& node = node_[n];
    if (node.first_child != kNone) return;
    Vec3 low = point_[node.begin], high = low;
    for (Index i = node.begin + 1; i < node.end; ++i) {
      low = low.cwiseMin(point_[i]);
      high = high.cwiseMax(point_[i]);
    }
    node.box = outward(low, high);
  });
  for (std::size_t n = node_.size(); n-- > 0;) {
    Node& node = node_[n];
    if (node.first_child == kNone) continue;
    node.box = node_[node.first_child].box;
    for (Index child = node.first_child + 1; child < node.first_child + node.children; ++child) {
      node.box.low = node.box.low.min(node_[child].box.low);
      node.box.high = node.box.high.max(node_[child].box.high);
    }
  }
}

VoxelSearch::FloatBox VoxelSearch::outward(const Vec3& low, const Vec3& high) {
  FloatBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = rounded_down(low[axis]);
    box.high[axis] = rounded_up(high[axis]);
  }
  return box;
}

VoxelSearch::Hit VoxelSearch::nearest(const Vec3& query) const {
  Hit best;
  search(query, best.squared_distance, [&](Range range, double& limit) {
    // A long range is points at one place in the order of their indices: the first will do.
    if (range.end - range.begin > kLeafPoints) range.end = range.begin + 1;
    for (Index i = range.begin; i < range.end; ++i) {
      const double squared_distance = (point_[i] - query).squaredNorm();
      if (squared_distance > best.squared_distance) continue;
      const Hit hit{index_[i], squared_distance};
      if (best.index == kNone || hit < best) best = hit;
    }
    limit = best.squared_distance;
  });
  return best;
}

void VoxelSearch::k_nearest(const Vec3& query, int k, std::vector<Hit>& hits) const {
  hits.clear();
  if (k <= 0) return;
  const std::size_t wanted = std::min(static_cast<std::size_t>(k), point_.size());
  hits.reserve(wanted);
  search(query, std::numeric_limits<double>::infinity(), [&](Range range, double& limit) {
    if (range.end - range.begin > kLeafPoints)  // points at one place, in the order of indices
      range.end = std::min<Index>(range.end, range.begin + static_cast<Index>(wanted));
    for (Index i = range.begin; i < range.end; ++i) {
      const Hit hit{index_[i], (point_[i] - query).squaredNorm()};
      if (hit.squared_distance > limit) continue;
      if (hits.size() == wanted) {
        if (!(hit < hits.back())) continue;
        hits.pop_back();
      }
      std::size_t slot = hits.size();
      hits.push_back(hit);
      for (; slot > 0 && hit < hits[slot - 1]; --slot) hits[slot] = hits[slot - 1];
      hits[slot] = hit;
      if (hits.size() == wanted) limit = hits.back().squared_distance;
    }
  });
}

std::vector<VoxelSearch::Range> VoxelSearch::groups(Index max_points) const {
  std::vector<Range> result;
  if (node_.empty()) return result;
  std::vector<Index> stack{0};
  while (!stack.empty()) {
    const Node& node = node_[stack.back()];
    stack.pop_back();
    if (node.first_child == kNone || node.end - node.begin <= max_points) {
      result.push_back({node.begin, node.end});
    } else {
      for (Index child = node.first_child + node.children; child-- > node.first_child;)
        stack.push_back(child);
    }
  }
  return result;
}

}  // namespace shrinkwrap
