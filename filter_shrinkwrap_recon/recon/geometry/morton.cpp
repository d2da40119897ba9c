#include "geometry/morton.h"

#include <algorithm>
#include <utility>

#include "common/parallel.h"
#include "common/radix_sort.h"

namespace shrinkwrap {
namespace {

struct KeyedIndex {
  std::uint64_t key;
  Index index;
};

constexpr Index kGrain = 1 << 14;
constexpr Index kFewPoints = 4096;  // below, a sort by comparison is faster
constexpr int kKeyBits = 63;

}  // namespace

double morton_cells_per_length(const Box& box) {
  return kMortonCells / std::max((box.high - box.low).maxCoeff(), 1e-300);
}

std::vector<std::uint64_t> morton_keys(const std::vector<Vec3>& points, const Box& box,
                                       Progress& progress) {
  const double cells_per_length = morton_cells_per_length(box);
  std::vector<std::uint64_t> keys(points.size());
  parallel_for_each(static_cast<Index>(points.size()), kGrain, progress, [&](Index i) {
    const Vec3 cell = (points[i] - box.low) * cells_per_length;
    keys[i] = morton_key(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                         static_cast<std::uint32_t>(cell.z()));
  });
  return keys;
}

std::vector<Index> morton_order(const std::vector<Vec3>& points) {
  Progress silent;
  return morton_order(points, silent);
}

std::vector<Index> morton_order(const std::vector<Vec3>& points, Progress& progress) {
  const Index count = static_cast<Index>(points.size());
  if (count == 0) return {};
  std::vector<KeyedIndex> keys(points.size());
  {
    const std::vector<std::uint64_t> key = morton_keys(points, bounding_box(points), progress);
    parallel_for_each(count, kGrain, progress, [&](Index i) { keys[i] = {key[i], i}; });
  }
  if (count < kFewPoints) {
    std::stable_sort(keys.begin(), keys.end(),
                     [](const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; });
  } else {
    radix_sort(keys, 0, kKeyBits, progress, [](const KeyedIndex& item) { return item.key; });
  }
  // Points of one cell: by coordinates, then by index, so that equal points become neighbours. A
  // cell belongs to the block in which it begins.
  const auto before = [&](const KeyedIndex& a, const KeyedIndex& b) {
    const Vec3 &p = points[a.index], &q = points[b.index];
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] != q[axis]) return p[axis] < q[axis];
    return a.index < b.index;
  };
  std::vector<Index> order(points.size());
  const std::vector<std::pair<Index, Index>> shared_cells =
      parallel_collect<std::pair<Index, Index>>(
          count, kGrain, progress, [&](Index first, Index last, auto& cells) {
            for (Index begin = first; begin < last;) {
              const bool begins_here = begin == 0 || keys[begin].key != keys[begin - 1].key;
              const Index limit = begins_here ? count : last;
              Index end = begin + 1;
              while (end < limit && keys[end].key == keys[begin].key) ++end;
              if (end - begin > 1 && begins_here) cells.emplace_back(begin, end);
              begin = end;
            }
          });
  parallel_for_each(static_cast<Index>(shared_cells.size()), 64, progress, [&](Index cell) {
    const auto [begin, end] = shared_cells[cell];
    std::sort(keys.begin() + begin, keys.begin() + end, before);
  });
  parallel_for_each(count, kGrain, progress, [&](Index i) { order[i] = keys[i].index; });
  return order;
}

}  // namespace shrinkwrap
