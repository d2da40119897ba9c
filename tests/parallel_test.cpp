// Sorting, numbering and uniting in parallel: against the plain loops that they stand for, with
// one thread and with several.
#include "common/parallel.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <random>

#include "common/buckets.h"
#include "common/radix_sort.h"
#include "common/shared_sets.h"

namespace shrinkwrap {
namespace {

constexpr Index kItems = 200000;

std::vector<Index> random_values(Index count, Index below, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Index> values(count);
  for (Index& value : values) value = static_cast<Index>(random() % below);
  return values;
}

template <class Body>
void with_threads(const Body& body) {
  for (int threads : {1, 4}) {
    SCOPED_TRACE(testing::Message() << threads << " threads");
    tbb::task_arena(threads).execute(body);
  }
}

TEST(Parallel, NumbersWhatThePredicateChooses) {
  const std::vector<Index> values = random_values(kItems, 3, 1);
  with_threads([&] {
    Progress silent;
    std::vector<Index> number;
    const Index count = parallel_number(
        kItems, 1000, silent, [&](Index i) { return values[i] == 0; }, number);
    Index expected = 0;
    for (Index i = 0; i < kItems; ++i)
      ASSERT_EQ(number[i], values[i] == 0 ? expected++ : kNone) << i;
    EXPECT_EQ(count, expected);
  });
}

TEST(Parallel, BucketsHoldTheirItemsInOrder) {
  constexpr Index kBuckets = 70000;
  const std::vector<Index> bucket = random_values(kItems, kBuckets + 1, 2);  // the last: left out
  std::vector<std::vector<Index>> expected(kBuckets);
  for (Index i = 0; i < kItems; ++i)
    if (bucket[i] < kBuckets) expected[bucket[i]].push_back(i);
  with_threads([&] {
    Progress silent;
    const Buckets buckets = sort_into_buckets(kItems, kBuckets, silent, [&](Index i) {
      return bucket[i] < kBuckets ? bucket[i] : kNone;
    });
    ASSERT_EQ(buckets.begin.size(), expected.size() + 1);
    for (Index b = 0; b < kBuckets; ++b)
      ASSERT_EQ(std::vector<Index>(buckets.item.begin() + buckets.begin[b],
                                   buckets.item.begin() + buckets.begin[b + 1]),
                expected[b]);
  });
}

TEST(Parallel, RadixSortIsStableAndSeesItsBitsOnly) {
  struct Item {
    std::uint64_t key;
    Index place;
  };
  std::mt19937_64 random(3);
  std::vector<Item> items(kItems);
  for (Index i = 0; i < kItems; ++i) items[i] = {random() & 0x3f00f00fffffffffull, i};
  const auto seen = [](const Item& item) { return item.key >> 20 & ((1ull << 42) - 1); };
  std::vector<Item> expected = items;
  std::stable_sort(expected.begin(), expected.end(),
                   [&](const Item& a, const Item& b) { return seen(a) < seen(b); });
  with_threads([&] {
    Progress silent;
    std::vector<Item> sorted = items;
    // 42 bits take four digits of 11: the two bits above them are zero in every key.
    radix_sort(sorted, 20, 42, silent, [](const Item& item) { return item.key; });
    for (Index i = 0; i < kItems; ++i) ASSERT_EQ(sorted[i].place, expected[i].place) << i;
  });
}

TEST(Parallel, SetsAreRepresentedByTheirLowestElement) {
  const std::vector<Index> a = random_values(kItems, kItems, 4), b = random_values(kItems, 1000, 5);
  const auto other = [&](Index i) { return std::min(a[i] + b[i], kItems - 1); };
  // By flooding: the label of an element is the lowest that reaches it.
  std::vector<Index> label(kItems);
  for (Index i = 0; i < kItems; ++i) label[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (Index i = 0; i < kItems; i += 2) {
      const Index low = std::min(label[a[i]], label[other(i)]);
      changed |= label[a[i]] != low || label[other(i)] != low;
      label[a[i]] = label[other(i)] = low;
    }
  }
  with_threads([&] {
    Progress silent;
    SharedSets sets(kItems, silent);
    parallel_for_each(kItems / 2, 100, silent,
                      [&](Index i) { sets.unite(a[2 * i], other(2 * i)); });
    for (Index i = 0; i < kItems; ++i) ASSERT_EQ(sets.find(i), label[i]) << i;
  });
}

}  // namespace
}  // namespace shrinkwrap
