// Morton (Z-order) keys: nearby points get nearby indices, so that every later loop runs in cache.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/progress.h"
#include "common/types.h"
#include "geometry/bounding_box.h"

namespace shrinkwrap {

/// Interleaves the low 21 bits of three coordinates; x is the lowest bit.
inline std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const auto spread = [](std::uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & 0x001f00000000ffffull;
    v = (v | v << 16) & 0x001f0000ff0000ffull;
    v = (v | v << 8) & 0x100f00f00f00f00full;
    v = (v | v << 4) & 0x10c30c30c30c30c3ull;
    return (v | v << 2) & 0x1249249249249249ull;
  };
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

/// The coordinates of a key: x, y, z.
inline std::array<std::uint32_t, 3> morton_coordinates(std::uint64_t key) {
  const auto gather = [](std::uint64_t v) {
    v &= 0x1249249249249249ull;
    v = (v | v >> 2) & 0x10c30c30c30c30c3ull;
    v = (v | v >> 4) & 0x100f00f00f00f00full;
    v = (v | v >> 8) & 0x001f0000ff0000ffull;
    v = (v | v >> 16) & 0x001f00000000ffffull;
    return static_cast<std::uint32_t>((v | v >> 32) & 0x1fffff);
  };
  return {gather(key), gather(key >> 1), gather(key >> 2)};
}

/// Highest coordinate of a cell: keys have 21 bits an axis.
constexpr double kMortonCells = 2097151.0;
/// Cells to a unit of length, of the cubic cells over the bounding cube of a box.
double morton_cells_per_length(const Box& box);
/// The keys of points by the cells over the bounding cube of `box`. Pre: finite points within it.
/// O(N), parallel.
std::vector<std::uint64_t> morton_keys(const std::vector<Vec3>& points, const Box& box,
                                       Progress& progress);

/// The order of points along a Morton curve of 2^21 cells per axis over their bounding cube; points
/// of one cell by coordinates (x, y, z), equal points by index. Pre: finite points. O(n), parallel
/// radix sort. Throws Cancelled.
std::vector<Index> morton_order(const std::vector<Vec3>& points, Progress& progress);
std::vector<Index> morton_order(const std::vector<Vec3>& points);  ///< silent

}  // namespace shrinkwrap
