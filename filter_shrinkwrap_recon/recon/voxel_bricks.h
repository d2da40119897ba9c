// A sparse voxel grid: bricks of 4 x 4 x 4 voxels where something happens, one state for a whole
// brick elsewhere.
#pragma once

#include <array>
#include <vector>

#include "types.h"

namespace shrinkwrap {

using Voxel = std::array<Index, 3>;

/// Maps the coordinates of bricks to indices; memory follows the number of bricks, not the volume.
class BrickIndex {
 public:
  static constexpr Index kEdge = 4;
  static constexpr Index kVoxels = kEdge * kEdge * kEdge;

  BrickIndex() : slot_(1 << 12, kNone) {}

  Index size() const { return static_cast<Index>(brick_.size()); }
  const Voxel& brick(Index i) const { return brick_[i]; }  ///< in units of bricks
  Index find(const Voxel& brick) const { return slot_[slot_of(brick)]; }
  /// The index of a brick, which is new (equal to the former size()) if it was not there.
  Index insert(const Voxel& brick) {
    std::size_t slot = slot_of(brick);
    if (slot_[slot] != kNone) return slot_[slot];
    if (2 * (brick_.size() + 1) > slot_.size()) {
      slot_.assign(2 * slot_.size(), kNone);
      for (Index i = 0; i < size(); ++i) slot_[slot_of(brick_[i])] = i;
      slot = slot_of(brick);
    }
    slot_[slot] = size();
    brick_.push_back(brick);
    return size() - 1;
  }

  static Voxel brick_of(const Voxel& v) { return {v[0] >> 2, v[1] >> 2, v[2] >> 2}; }
  static Index offset_of(const Voxel& v) { return (v[2] & 3) << 4 | (v[1] & 3) << 2 | (v[0] & 3); }

 private:
  std::size_t slot_of(const Voxel& brick) const {
    std::uint64_t key = 0;
    for (const Index c : brick) key = (key ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15ull;
    std::size_t slot = static_cast<std::size_t>(key ^ key >> 29) & (slot_.size() - 1);
    while (slot_[slot] != kNone && brick_[slot_[slot]] != brick)
      slot = (slot + 1) & (slot_.size() - 1);
    return slot;
  }

  std::vector<Voxel> brick_;
  std::vector<Index> slot_;
};

}  // namespace shrinkwrap
