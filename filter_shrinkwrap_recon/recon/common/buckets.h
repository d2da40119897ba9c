// Counting sort of indices, parallel.
#pragma once

#include <algorithm>
#include <atomic>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {

/// Items sorted by bucket: those of bucket b are item[begin[b]] to item[begin[b + 1]].
struct Buckets {
  std::vector<Index> begin;  ///< per bucket, and the end
  std::vector<Index> item;   ///< ascending within each bucket
};

/// Sorts the items [0, items) into buckets; `bucket_of(item)` is in [0, buckets), or kNone for an
/// item that is left out, and is asked twice. Meant for buckets of few items. O(items + buckets).
template <class BucketOf>
Buckets sort_into_buckets(Index items, Index buckets, Progress& progress,
                          const BucketOf& bucket_of) {
  constexpr Index kGrain = 1 << 14;
  Buckets result;
  std::vector<std::atomic<Index>> cursor(static_cast<std::size_t>(buckets));
  parallel_for_each(items, kGrain, progress, [&](Index i) {
    const Index bucket = bucket_of(i);
    if (bucket != kNone) cursor[bucket].fetch_add(1, std::memory_order_relaxed);
  });
  result.begin.resize(static_cast<std::size_t>(buckets) + 1);
  Index sum = 0;
  for (Index b = 0; b < buckets; ++b) {
    result.begin[b] = sum;
    sum += cursor[b].load(std::memory_order_relaxed);
    cursor[b].store(result.begin[b], std::memory_order_relaxed);
  }
  result.begin[buckets] = sum;
  result.item.resize(static_cast<std::size_t>(sum));
  parallel_for_each(items, kGrain, progress, [&](Index i) {
    const Index bucket = bucket_of(i);
    if (bucket != kNone) result.item[cursor[bucket].fetch_add(1, std::memory_order_relaxed)] = i;
  });
  // Which thread came first must not show.
  parallel_for_each(buckets, kGrain, progress, [&](Index b) {
    std::sort(result.item.begin() + result.begin[b], result.item.begin() + result.begin[b + 1]);
  });
  return result;
}

}  // namespace shrinkwrap
