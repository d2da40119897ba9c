#include "morton.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>

#include "parallel.h"

namespace shrinkwrap {
namespace {

struct KeyedIndex {
  std::uint64_t key;
  Index index;
};

constexpr Index kGrain = 1 << 14;
constexpr int kDigitBits = 11;
constexpr int kDigits = 1 << kDigitBits;
constexpr int kPasses = 6;  // 6 x 11 bits cover the 63 bits of a key

// One stable pass of a radix sort: per-block histograms, one prefix sum, per-block scatter.
void radix_pass(const std::vector<KeyedIndex>& from, std::vector<KeyedIndex>& to, int shift,
                Progress& progress) {
  const Index count = static_cast<Index>(from.size());
  const Index grain = std::max<Index>(kGrain, count / 64 + 1);
  std::vector<std::array<Index, kDigits>> offset(block_count(count, grain));
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    auto& histogram = offset[block];
    histogram.fill(0);
    for (Index i = begin; i < end; ++i) ++histogram[(from[i].key >> shift) & (kDigits - 1)];
  });
  Index sum = 0;
  for (int digit = 0; digit < kDigits; ++digit)
    for (auto& histogram : offset) {
      const Index in_block = histogram[digit];
      histogram[digit] = sum;
      sum += in_block;
    }
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    auto& cursor = offset[block];
    for (Index i = begin; i < end; ++i)
      to[cursor[(from[i].key >> shift) & (kDigits - 1)]++] = from[i];
  });
}

}  // namespace

std::vector<Index> morton_order(const std::vector<Vec3>& points) {
  Progress silent;
  return morton_order(points, silent);
}

std::vector<Index> morton_order(const std::vector<Vec3>& points, Progress& progress) {
  const Index count = static_cast<Index>(points.size());
  if (count == 0) return {};
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = std::max((high - low).maxCoeff(), 1e-300);
  const double cells = 2097151.0 / extent;

  std::vector<KeyedIndex> keys(points.size()), scratch(points.size());
  parallel_for_each(count, kGrain, progress, [&](Index i) {
    const Vec3 cell = (points[i] - low) * cells;
    keys[i] = {
        morton_key(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                   static_cast<std::uint32_t>(cell.z())),
        i};
  });
  if (count < 4096) {
    std::stable_sort(keys.begin(), keys.end(),
                     [](const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; });
  } else {
    for (int pass = 0; pass < kPasses; ++pass) {
      radix_pass(keys, scratch, pass * kDigitBits, progress);
      keys.swap(scratch);
    }
  }
  // Points of one cell: by coordinates, then by index, so that equal points become neighbours.
  for (Index begin = 0; begin < count;) {
    Index end = begin + 1;
    while (end < count && keys[end].key == keys[begin].key) ++end;
    if (end - begin > 1)
      std::sort(keys.begin() + begin, keys.begin() + end,
                [&](const KeyedIndex& a, const KeyedIndex& b) {
                  const Vec3 &p = points[a.index], &q = points[b.index];
                  for (int axis = 0; axis < 3; ++axis)
                    if (p[axis] != q[axis]) return p[axis] < q[axis];
                  return a.index < b.index;
                });
    begin = end;
  }
  progress.update(1.0);
  std::vector<Index> order(points.size());
  for (Index i = 0; i < count; ++i) order[i] = keys[i].index;
  return order;
}

}  // namespace shrinkwrap
