// Stable radix sort by integer keys, parallel.
#pragma once

#include <array>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {

/// Sorts items by the bits [first_bit, first_bit + bits) of `key_of(item)`, an unsigned integer;
/// items of equal bits keep their order. Takes as much memory again. O(items * bits / 11).
template <class Item, class KeyOf>
void radix_sort(std::vector<Item>& items, int first_bit, int bits, Progress& progress,
                const KeyOf& key_of) {
  constexpr Index kGrain = 1 << 14;
  constexpr Index kMostBlocks = 64;
  constexpr int kDigitBits = 11;
  constexpr int kDigits = 1 << kDigitBits;
  const Index count = static_cast<Index>(items.size());
  const Index grain = std::max<Index>(kGrain, count / kMostBlocks + 1);
  std::vector<Item> scratch(items.size());
  std::vector<std::array<Index, kDigits>> cursor(block_count(count, grain));
  for (int shift = first_bit; shift < first_bit + bits; shift += kDigitBits) {
    const auto digit_of = [&](const Item& item) {
      return static_cast<std::size_t>((key_of(item) >> shift) & (kDigits - 1));
    };
    parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
      cursor[block].fill(0);
      for (Index i = begin; i < end; ++i) ++cursor[block][digit_of(items[i])];
    });
    Index sum = 0;
    for (std::size_t digit = 0; digit < kDigits; ++digit)
      for (auto& histogram : cursor) {
        const Index in_block = histogram[digit];
        histogram[digit] = sum;
        sum += in_block;
      }
    parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
      for (Index i = begin; i < end; ++i) scratch[cursor[block][digit_of(items[i])]++] = items[i];
    });
    items.swap(scratch);
  }
}

}  // namespace shrinkwrap
