// Bricks of voxels as keys to sort by: neighbours in space are near each other.
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <vector>

#include "geometry/morton.h"
#include "geometry/voxel_bricks.h"

namespace shrinkwrap {

using BrickKey = std::uint64_t;
constexpr Index kBrickKeyOffset = 1 << 19;

/// Pre: coordinates from -2^19 to 2^20.
inline BrickKey key_of(const Voxel& brick) {
  const auto part = [](Index c) { return static_cast<std::uint32_t>(c + kBrickKeyOffset); };
  return morton_key(part(brick[0]), part(brick[1]), part(brick[2]));
}

inline Voxel brick_of_key(BrickKey key) {
  const auto [x, y, z] = morton_coordinates(key);
  const auto part = [](std::uint32_t c) { return static_cast<Index>(c) - kBrickKeyOffset; };
  return {part(x), part(y), part(z)};
}

/// Sorts the keys, on all threads, and drops repetitions.
inline void parallel_sort_unique(std::vector<BrickKey>& keys) {
  tbb::parallel_sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace shrinkwrap
