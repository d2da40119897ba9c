// Parallel loops over index ranges, on oneTBB. The blocks depend only on the range and the grain,
// never on the number of threads, so that per-block results combined in block order are the same
// for any number of threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

inline Index block_count(Index count, Index grain) {
  return (count + grain - 1) / grain;
}

/// Calls `body(block, begin, end)` for the blocks of [0, count) of `grain` indices each.
/// Progress runs from 0 to 1 of the current range of `progress`; throws Cancelled between blocks.
/// Pre: grain > 0; bodies of different blocks write to different places.
template <class Body>
void parallel_blocks(Index count, Index grain, Progress& progress, const Body& body) {
  const Index blocks = block_count(count, grain);
  std::atomic<Index> done{0};
  tbb::parallel_for(
      tbb::blocked_range<Index>(0, blocks, 1),
      [&](const tbb::blocked_range<Index>& range) {
        for (Index block = range.begin(); block != range.end(); ++block) {
          const Index begin = block * grain;
          body(block, begin, std::min(begin + grain, count));
          progress.update(static_cast<double>(++done) / blocks);
        }
      },
      tbb::simple_partitioner());
}

/// Calls `body(i)` for every i in [0, count).
template <class Body>
void parallel_for_each(Index count, Index grain, Progress& progress, const Body& body) {
  parallel_blocks(count, grain, progress, [&](Index, Index begin, Index end) {
    for (Index i = begin; i < end; ++i) body(i);
  });
}

/// Sum, in block order, of `body(begin, end)` over the blocks: the same bits for any number of
/// threads.
template <class Value, class Body>
Value parallel_sum(Index count, Index grain, Progress& progress, Value zero, const Body& body) {
  std::vector<Value> partial(static_cast<std::size_t>(block_count(count, grain)), zero);
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    partial[static_cast<std::size_t>(block)] = body(begin, end);
  });
  for (const Value& value : partial) zero += value;
  return zero;
}

/// Concatenation, in block order, of the vectors that `body(begin, end, out)` fills.
template <class Value, class Body>
std::vector<Value> parallel_collect(Index count, Index grain, Progress& progress,
                                    const Body& body) {
  std::vector<std::vector<Value>> partial(static_cast<std::size_t>(block_count(count, grain)));
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    body(begin, end, partial[static_cast<std::size_t>(block)]);
  });
  std::size_t total = 0;
  for (const auto& part : partial) total += part.size();
  std::vector<Value> result;
  result.reserve(total);
  for (auto& part : partial) {
    result.insert(result.end(), part.begin(), part.end());
    part = std::vector<Value>();  // so that nothing is held twice for long
  }
  return result;
}

/// Numbers, ascending from 0, the indices of [0, count) for which `is_numbered(i)` holds; kNone for
/// the others. Returns how many have a number. `is_numbered` is asked twice.
template <class Predicate>
Index parallel_number(Index count, Index grain, Progress& progress, const Predicate& is_numbered,
                      std::vector<Index>& number) {
  number.resize(static_cast<std::size_t>(count));
  std::vector<Index> first(static_cast<std::size_t>(block_count(count, grain)));
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    for (Index i = begin; i < end; ++i) first[block] += is_numbered(i) ? 1 : 0;
  });
  Index sum = 0;
  for (Index& in_block : first) {
    const Index before = sum;
    sum += in_block;
    in_block = before;
  }
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    Index next = first[block];
    for (Index i = begin; i < end; ++i) number[i] = is_numbered(i) ? next++ : kNone;
  });
  return sum;
}

}  // namespace shrinkwrap
