// A sparse binary voxel image: bricks of 4 x 4 x 4 voxels, each one 64-bit mask.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/types.h"

namespace shrinkwrap {

using Voxel = std::array<Index, 3>;

inline Voxel operator+(const Voxel& a, const Voxel& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// Voxel or brick k of the 27 around one, itself included (k = 13).
inline Voxel around(const Voxel& centre, Index k) {
  return centre + Voxel{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
}

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
  /// Number of a voxel in its brick: x fastest, then y, then z.
  static Index offset_of(const Voxel& v) { return (v[2] & 3) << 4 | (v[1] & 3) << 2 | (v[0] & 3); }
  static Voxel voxel_in(const Voxel& brick, Index offset) {
    return {brick[0] * kEdge + (offset & 3), brick[1] * kEdge + (offset >> 2 & 3),
            brick[2] * kEdge + (offset >> 4)};
  }

 private:
  std::size_t slot_of(const Voxel& brick) const {
    std::uint64_t key = 0;
    for (const Index c : brick) key = (key ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15ull;
    std::size_t slot = static_cast<std::size_t>(key ^ key >> 29) & (slot_.size() - 1);
    while (slot_[slot] != kNone && !is_same(brick_[slot_[slot]], brick))
      slot = (slot + 1) & (slot_.size() - 1);
    return slot;
  }

  static bool is_same(const Voxel& a, const Voxel& b) {
    return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
  }

  std::vector<Voxel> brick_;
  std::vector<Index> slot_;
};

/// One bit per voxel of a brick, at `BrickIndex::offset_of`.
using BrickMask = std::uint64_t;
constexpr BrickMask kAllSolid = ~BrickMask{0};

/// For every voxel of a brick the state of the voxel one further along an axis; `next` is the mask
/// of the brick one further.
inline BrickMask state_ahead(int axis, BrickMask mask, BrickMask next) {
  switch (axis) {
    case 0:
      return (mask >> 1 & 0x7777777777777777u) | (next << 3 & 0x8888888888888888u);
    case 1:
      return (mask >> 4 & 0x0FFF0FFF0FFF0FFFu) | (next << 12 & 0xF000F000F000F000u);
    default:
      return mask >> 16 | next << 48;
  }
}
/// The same for the voxel one before; `previous` is the mask of the brick one before.
inline BrickMask state_behind(int axis, BrickMask mask, BrickMask previous) {
  switch (axis) {
    case 0:
      return (mask << 1 & 0xEEEEEEEEEEEEEEEEu) | (previous >> 3 & 0x1111111111111111u);
    case 1:
      return (mask << 4 & 0xFFF0FFF0FFF0FFF0u) | (previous >> 12 & 0x000F000F000F000Fu);
    default:
      return mask << 16 | previous >> 48;
  }
}

/// Solid and empty voxels. Bricks in which something happens are there together with all 26 bricks
/// around them; an unknown brick is like the uniform ones that touch it.
class VoxelImage {
 public:
  BrickIndex bricks;
  std::vector<BrickMask> mask;  ///< per brick
  /// Per brick: made of blocks of 2 x 2 x 2 voxels, from even coordinates on, that were one voxel
  /// each. Those beyond the end are not; empty: none is.
  std::vector<char> in_blocks;

  /// The index of a brick, which is empty if it is new.
  Index add(const Voxel& brick) {
    const Index index = bricks.insert(brick);
    if (index == static_cast<Index>(mask.size())) mask.push_back(0);
    return index;
  }
  bool is_solid(const Voxel& v) const {
    const Index brick = bricks.find(BrickIndex::brick_of(v));
    return brick != kNone && (mask[brick] >> BrickIndex::offset_of(v) & 1);
  }
  /// Makes a voxel solid.
  void fill(const Voxel& v) {
    const Voxel brick = BrickIndex::brick_of(v);
    const Index index = add(brick);
    if (mask[index] == 0)
      for (Index k = 0; k < 27; ++k) add(around(brick, k));
    mask[index] |= BrickMask{1} << BrickIndex::offset_of(v);
  }
  /// The mask of a brick, seen from a known one beside it.
  BrickMask mask_beside(Index known, const Voxel& brick) const {
    return mask_beside(mask, known, brick);
  }

  /// States of the 8 voxels v + (k & 1, k >> 1 & 1, k >> 2) for every voxel v of a brick.
  std::array<BrickMask, 8> states_ahead(Index brick) const {
    std::array<BrickMask, 8> state = masks_around(mask, brick, 0);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 8; ++k)
        if (!(k >> axis & 1))
          state[k | 1 << axis] = state_ahead(axis, state[k], state[k | 1 << axis]);
    return state;
  }
  /// States of the 8 voxels v - (1, 1, 1) + (k & 1, k >> 1 & 1, k >> 2): those around the lowest
  /// corner of v.
  std::array<BrickMask, 8> states_behind(Index brick) const { return states_behind(mask, brick); }
  /// The same of what other masks say of the voxels.
  std::array<BrickMask, 8> states_behind(const std::vector<BrickMask>& masks, Index brick) const {
    std::array<BrickMask, 8> state = masks_around(masks, brick, -1);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 8; ++k)
        if (!(k >> axis & 1)) state[k] = state_behind(axis, state[k | 1 << axis], state[k]);
    return state;
  }

 private:
  BrickMask mask_beside(const std::vector<BrickMask>& masks, Index known,
                        const Voxel& brick) const {
    const Index index = bricks.find(brick);
    if (index != kNone) return masks[index];
    return masks[known] == kAllSolid ? kAllSolid : 0;
  }
  std::array<BrickMask, 8> masks_around(const std::vector<BrickMask>& masks, Index brick,
                                        Index begin) const {
    std::array<BrickMask, 8> around;
    for (int k = 0; k < 8; ++k)
      around[k] = mask_beside(
          masks, brick,
          bricks.brick(brick) + Voxel{begin + (k & 1), begin + (k >> 1 & 1), begin + (k >> 2)});
    return around;
  }
};

}  // namespace shrinkwrap
