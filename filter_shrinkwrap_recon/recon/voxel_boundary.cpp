#include "voxel_boundary.h"

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 64;

// The six squares and four diagonals of a cell of 2 x 2 x 2 voxels, by numbers of voxels: x + 2 y
// + 4 z.
constexpr int kSquares[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 4, 5},
                                {2, 3, 6, 7}, {0, 2, 4, 6}, {1, 3, 5, 7}};

// Cells in which voxels of one kind meet at an edge or a corner only.
BrickMask ill_composed(const std::array<BrickMask, 8>& s) {
  BrickMask bad = 0;
  for (const auto& q : kSquares) {
    const BrickMask across = ~(s[q[0]] ^ s[q[3]]) & ~(s[q[1]] ^ s[q[2]]);
    bad |= across & (s[q[0]] ^ s[q[1]]);
  }
  for (int k = 0; k < 4; ++k) {
    BrickMask any_other = 0, all_other = kAllSolid;
    for (int j = 0; j < 8; ++j) {
      if (j == k || j == 7 - k) continue;
      any_other |= s[j];
      all_other &= s[j];
    }
    bad |= (s[k] & s[7 - k] & ~any_other) | (~s[k] & ~s[7 - k] & all_other);
  }
  return bad;
}

Voxel in_cell(const Voxel& cell, int k) {
  return cell + Voxel{k & 1, k >> 1 & 1, k >> 2};
}

template <class Fn>
void for_each_bit(BrickMask mask, const Fn& fn) {
  for (; mask != 0; mask &= mask - 1) fn(static_cast<Index>(__builtin_ctzll(mask)));
}

Index count_bits(BrickMask mask) {
  return static_cast<Index>(__builtin_popcountll(mask));
}

// Squares of a brick, each between a voxel and the one ahead along an axis.
struct Squares {
  BrickMask between[3];
  Index count() const {
    return count_bits(between[0]) + count_bits(between[1]) + count_bits(between[2]);
  }
};

Squares squares_of(const VoxelImage& image, Index brick) {
  Squares squares;
  for (int axis = 0; axis < 3; ++axis) {
    Voxel next = image.bricks.brick(brick);
    ++next[axis];
    const BrickMask mask = image.mask[brick];
    squares.between[axis] = mask ^ state_ahead(axis, mask, image.mask_beside(brick, next));
  }
  return squares;
}

// Corners of voxels that the boundary touches, by the voxel whose lowest corner they are.
BrickMask corners_of(const VoxelImage& image, Index brick) {
  BrickMask any = 0, all = kAllSolid;
  for (const BrickMask state : image.states_behind(brick)) {
    any |= state;
    all &= state;
  }
  return any & ~all;
}

// Exclusive sums; the total comes last.
std::vector<Index> running_sums(std::vector<Index> counts) {
  Index total = 0;
  for (Index& count : counts) {
    const Index begin = total;
    total += count;
    count = begin;
  }
  counts.push_back(total);
  return counts;
}

}  // namespace

void make_well_composed(VoxelImage& image, Progress& progress) {
  std::vector<Voxel> cells = parallel_collect<Voxel>(
      image.bricks.size(), kGrain, progress, [&](Index begin, Index end, std::vector<Voxel>& bad) {
        for (Index brick = begin; brick < end; ++brick)
          for_each_bit(ill_composed(image.states_ahead(brick)), [&](Index offset) {
            bad.push_back(BrickIndex::voxel_in(image.bricks.brick(brick), offset));
          });
      });
  std::vector<Voxel> next;
  while (!cells.empty()) {
    next.clear();
    for (const Voxel& cell : cells) {
      bool state[8];
      for (int k = 0; k < 8; ++k) state[k] = image.is_solid(in_cell(cell, k));
      const auto fill = [&](int k) {
        const Voxel v = in_cell(cell, k);
        image.fill(v);
        state[k] = true;
        for (int q = 0; q < 8; ++q) next.push_back(v + Voxel{-(q & 1), -(q >> 1 & 1), -(q >> 2)});
      };
      for (const auto& [a, b, c, d] : kSquares) {
        if (state[a] && state[d] && !state[b] && !state[c]) fill(b);
        if (!state[a] && !state[d] && state[b] && state[c]) fill(a);
      }
      int sum = 0;
      for (const bool s : state) sum += s;
      if (sum != 2 && sum != 6) continue;
      const bool odd = sum == 2;
      for (int k = 0; k < 4; ++k)
        if (state[k] == odd && state[7 - k] == odd) {
          fill(odd ? k ^ 1 : k);
          break;
        }
    }
    progress.update(1.0);
    cells.swap(next);
  }
}

SurfaceMesh boundary_of(const VoxelImage& image, const VoxelLattice& lattice, Progress& progress) {
  const Index bricks = image.bricks.size();
  std::vector<BrickMask> corners(static_cast<std::size_t>(bricks));
  std::vector<Index> corner_count(corners.size()), square_count(corners.size());
  parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
    corners[brick] = corners_of(image, brick);
    corner_count[brick] = count_bits(corners[brick]);
    square_count[brick] = squares_of(image, brick).count();
  });
  const std::vector<Index> first_vertex = running_sums(std::move(corner_count));
  const std::vector<Index> first_square = running_sums(std::move(square_count));

  const auto vertex_at = [&](Index brick, const Voxel& corner) {
    const Voxel holder = BrickIndex::brick_of(corner);
    const Index at = holder == image.bricks.brick(brick) ? brick : image.bricks.find(holder);
    const BrickMask before = (BrickMask{1} << BrickIndex::offset_of(corner)) - 1;
    return first_vertex[at] + count_bits(corners[at] & before);
  };
  std::vector<Vec3> position(static_cast<std::size_t>(first_vertex.back()));
  std::vector<Triangle> triangles(2 * static_cast<std::size_t>(first_square.back()));
  parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
    const Voxel here = image.bricks.brick(brick);
    Index vertex = first_vertex[brick];
    for_each_bit(corners[brick], [&](Index offset) {
      position[vertex++] = lattice.corner_of(BrickIndex::voxel_in(here, offset));
    });
    const Squares squares = squares_of(image, brick);
    std::size_t triangle = 2 * static_cast<std::size_t>(first_square[brick]);
    for (int axis = 0; axis < 3; ++axis)
      for_each_bit(squares.between[axis], [&](Index offset) {
        const Voxel v = BrickIndex::voxel_in(here, offset);
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        Index quad[4];
        for (int k = 0; k < 4; ++k) {
          Voxel corner = v;
          ++corner[axis];
          corner[u] += k == 1 || k == 2;
          corner[w] += k >= 2;
          quad[k] = vertex_at(brick, corner);
        }
        if (!(image.mask[brick] >> offset & 1)) std::swap(quad[1], quad[3]);
        const int first = (v[0] + v[1] + v[2]) & 1;  // alternate the diagonals
        triangles[triangle++] = {quad[first], quad[first + 1], quad[first + 2]};
        triangles[triangle++] = {quad[first], quad[first + 2], quad[(first + 3) & 3]};
      });
  });
  if (triangles.empty()) return SurfaceMesh();
  return SurfaceMesh::from_triangles(std::move(position), triangles, progress);
}

}  // namespace shrinkwrap
