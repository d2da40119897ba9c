#include "initial_mesh/voxel_boundary.h"

#include "common/parallel.h"

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

// Corners of voxels that the boundary touches, by the voxel whose lowest corner they are.
BrickMask corners_of(const VoxelImage& image, Index brick) {
  BrickMask any = 0, all = kAllSolid;
  for (const BrickMask state : image.states_behind(brick)) {
    any |= state;
    all &= state;
  }
  return any & ~all;
}

// Squares of a brick, each between a voxel and the one ahead along an axis.
BrickMask squares_along(const VoxelImage& image, Index brick, int axis) {
  Voxel next = image.bricks.brick(brick);
  ++next[axis];
  const BrickMask mask = image.mask[brick];
  return mask ^ state_ahead(axis, mask, image.mask_beside(brick, next));
}

// Voxels of odd coordinates along an axis, and how far apart the bits of neighbours along it are.
constexpr BrickMask kOdd[3] = {0xAAAAAAAAAAAAAAAAu, 0xF0F0F0F0F0F0F0F0u, 0xFFFF0000FFFF0000u};
constexpr int kStep[3] = {1, 4, 16};

// Voxels of blocks of 2 x 2 x 2 that are alike.
BrickMask uniform_blocks(BrickMask mask) {
  const auto lowest = [](BrickMask m) {
    for (int axis = 0; axis < 3; ++axis) m &= m >> kStep[axis] & ~kOdd[axis];
    return m;
  };
  BrickMask blocks = lowest(mask) | lowest(~mask);
  for (const int step : kStep) blocks |= blocks << step;
  return blocks;
}

// Corners of voxels that become vertices, and squares.
struct Layout {
  std::vector<BrickMask> vertices;
  // Corners in the middle of large squares, which are four squares between two blocks. They are
  // vertices only if an edge of the large square is cut in two, as it is beside small squares.
  std::vector<BrickMask> centres;

  bool has_large_squares() const { return !centres.empty(); }
};

Layout layout_of(const VoxelImage& image, Progress& progress) {
  const Index bricks = image.bricks.size();
  Layout layout;
  layout.vertices.resize(static_cast<std::size_t>(bricks));
  parallel_for_each(bricks, kGrain, progress,
                    [&](Index brick) { layout.vertices[brick] = corners_of(image, brick); });
  if (image.in_blocks.empty()) return layout;

  std::vector<BrickMask> blocks(layout.vertices.size(), 0), midpoints(layout.vertices.size());
  parallel_for_each(static_cast<Index>(image.in_blocks.size()), kGrain, progress, [&](Index brick) {
    if (image.in_blocks[brick]) blocks[brick] = uniform_blocks(image.mask[brick]);
  });
  // Corners with nothing but blocks around: on an edge of blocks that is whole if one coordinate is
  // odd, on a square between two blocks if two are.
  layout.centres.resize(layout.vertices.size());
  parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
    BrickMask corners = layout.vertices[brick];
    for (const BrickMask state : image.states_behind(blocks, brick)) corners &= state;
    const BrickMask odd_sum = kOdd[0] ^ kOdd[1] ^ kOdd[2];
    midpoints[brick] = corners & odd_sum;
    layout.centres[brick] = corners & ~odd_sum & (kOdd[0] | kOdd[1]);
  });
  parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
    BrickMask whole = layout.centres[brick];  // all four edges are
    for (int axis = 0; axis < 3 && whole != 0; ++axis) {
      Voxel next = image.bricks.brick(brick);
      ++next[axis];
      const Index ahead = image.bricks.find(next);
      const BrickMask both =
          state_ahead(axis, midpoints[brick], ahead == kNone ? 0 : midpoints[ahead]) &
          state_behind(axis, midpoints[brick], 0);
      whole &= ~kOdd[axis] | both;
    }
    layout.vertices[brick] &= ~(midpoints[brick] | whole);
  });
  return layout;
}

// Squares of a brick along an axis, by the voxel behind them.
struct Squares {
  BrickMask single = 0;
  BrickMask large = 0;  // by that of the four voxels whose coordinates are odd
};

Squares squares_of(const VoxelImage& image, const Layout& layout, Index brick, int axis) {
  Squares squares;
  squares.single = squares_along(image, brick, axis);
  if (!layout.has_large_squares()) return squares;
  Voxel next = image.bricks.brick(brick);
  ++next[axis];
  const Index ahead = image.bricks.find(next);
  squares.large =
      state_ahead(axis, layout.centres[brick], ahead == kNone ? 0 : layout.centres[ahead]) &
      kOdd[0] & kOdd[1] & kOdd[2];
  BrickMask parts = squares.large;
  for (int other = 0; other < 3; ++other)
    if (other != axis) parts |= parts >> kStep[other];
  squares.single &= ~parts;
  return squares;
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

// The mesh of a layout.
class Boundary {
 public:
  Boundary(const VoxelImage& image, Progress& progress)
      : image_(image), layout_(layout_of(image, progress)) {}

  SurfaceMesh mesh(const VoxelLattice& lattice, Progress& progress) {
    const Index bricks = image_.bricks.size();
    std::vector<Index> vertex_count(static_cast<std::size_t>(bricks)),
        triangle_count(vertex_count.size());
    parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
      vertex_count[brick] = count_bits(layout_.vertices[brick]);
      triangle_count[brick] = triangles_of(brick);
    });
    first_vertex_ = running_sums(std::move(vertex_count));
    const std::vector<Index> first_triangle = running_sums(std::move(triangle_count));

    std::vector<Vec3> position(static_cast<std::size_t>(first_vertex_.back()));
    std::vector<Triangle> triangles(static_cast<std::size_t>(first_triangle.back()));
    parallel_for_each(bricks, kGrain, progress, [&](Index brick) {
      Index vertex = first_vertex_[brick];
      for_each_bit(layout_.vertices[brick], [&](Index offset) {
        position[vertex++] =
            lattice.corner_of(BrickIndex::voxel_in(image_.bricks.brick(brick), offset));
      });
      Triangle* out = triangles.data() + first_triangle[brick];
      for (int axis = 0; axis < 3; ++axis) {
        const Squares squares = squares_of(image_, layout_, brick, axis);
        for_each_bit(squares.single, [&](Index offset) { add_square(brick, axis, offset, out); });
        for_each_bit(squares.large,
                     [&](Index offset) { add_large_square(brick, axis, offset, out); });
      }
    });
    if (triangles.empty()) return SurfaceMesh();
    return SurfaceMesh::from_triangles(std::move(position), triangles, progress);
  }

 private:
  // The corners of a large square and the middles of its edges, in turn around its centre.
  struct Ring {
    Voxel centre;
    std::array<Voxel, 8> corner;
  };
  Ring ring_of(Index brick, int axis, Index offset) const {
    static constexpr Index kAcross[8] = {-1, 0, 1, 1, 1, 0, -1, -1},
                           kUp[8] = {-1, -1, -1, 0, 1, 1, 1, 0};
    Ring ring;
    ring.centre = BrickIndex::voxel_in(image_.bricks.brick(brick), offset);
    ++ring.centre[axis];
    for (std::size_t k = 0; k < 8; ++k) {
      ring.corner[k] = ring.centre;
      ring.corner[k][(axis + 1) % 3] += kAcross[k];
      ring.corner[k][(axis + 2) % 3] += kUp[k];
    }
    return ring;
  }

  Index holder_of(Index brick, const Voxel& corner) const {
    const Voxel holder = BrickIndex::brick_of(corner);
    return holder == image_.bricks.brick(brick) ? brick : image_.bricks.find(holder);
  }
  bool is_vertex(Index brick, const Voxel& corner) const {
    return layout_.vertices[holder_of(brick, corner)] >> BrickIndex::offset_of(corner) & 1;
  }
  Index vertex_at(Index brick, const Voxel& corner) const {
    const Index holder = holder_of(brick, corner);
    const BrickMask before = (BrickMask{1} << BrickIndex::offset_of(corner)) - 1;
    return first_vertex_[holder] + count_bits(layout_.vertices[holder] & before);
  }

  Index triangles_of(Index brick) const {
    Index count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Squares squares = squares_of(image_, layout_, brick, axis);
      count += 2 * count_bits(squares.single);
      for_each_bit(squares.large, [&](Index offset) {
        const Ring ring = ring_of(brick, axis, offset);
        if (!is_vertex(brick, ring.centre)) {
          count += 2;
          return;
        }
        for (const Voxel& corner : ring.corner) count += is_vertex(brick, corner);
      });
    }
    return count;
  }

  void add_square(Index brick, int axis, Index offset, Triangle*& out) const {
    const Voxel v = BrickIndex::voxel_in(image_.bricks.brick(brick), offset);
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    Index quad[4];
    for (int k = 0; k < 4; ++k) {
      Voxel corner = v;
      ++corner[axis];
      corner[u] += k == 1 || k == 2;
      corner[w] += k >= 2;
      quad[k] = vertex_at(brick, corner);
    }
    add_quad(quad, is_solid(brick, offset), (v[0] + v[1] + v[2]) & 1, out);
  }

  void add_large_square(Index brick, int axis, Index offset, Triangle*& out) const {
    const Ring ring = ring_of(brick, axis, offset);
    const bool outwards = is_solid(brick, offset);
    if (!is_vertex(brick, ring.centre)) {
      Index quad[4];
      for (std::size_t k = 0; k < 4; ++k) quad[k] = vertex_at(brick, ring.corner[2 * k]);
      const Voxel& c = ring.centre;
      add_quad(quad, outwards, ((c[0] >> 1) + (c[1] >> 1) + (c[2] >> 1)) & 1, out);
      return;
    }
    const Index centre = vertex_at(brick, ring.centre), first = vertex_at(brick, ring.corner[0]);
    Index last = first;
    const auto add = [&](Index next) {
      *out++ = outwards ? Triangle{centre, last, next} : Triangle{centre, next, last};
      last = next;
    };
    for (std::size_t k = 1; k < 8; ++k)
      if (is_vertex(brick, ring.corner[k])) add(vertex_at(brick, ring.corner[k]));
    add(first);
  }

  bool is_solid(Index brick, Index offset) const { return image_.mask[brick] >> offset & 1; }

  // `first`: at which corner the diagonal begins; they alternate.
  static void add_quad(Index (&quad)[4], bool outwards, int first, Triangle*& out) {
    if (!outwards) std::swap(quad[1], quad[3]);
    *out++ = {quad[first], quad[first + 1], quad[first + 2]};
    *out++ = {quad[first], quad[first + 2], quad[(first + 3) & 3]};
  }

  const VoxelImage& image_;
  const Layout layout_;
  std::vector<Index> first_vertex_;  // per brick
};

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

std::vector<Index> euler_characteristics(const VoxelImage& image, Progress& progress) {
  std::vector<Index> result(static_cast<std::size_t>(image.bricks.size()));
  // Each square has four edges, of which each is one of two squares: V - E + F = V - F.
  parallel_for_each(image.bricks.size(), kGrain, progress, [&](Index brick) {
    result[brick] = count_bits(corners_of(image, brick));
    for (int axis = 0; axis < 3; ++axis)
      result[brick] -= count_bits(squares_along(image, brick, axis));
  });
  return result;
}

SurfaceMesh boundary_of(const VoxelImage& image, const VoxelLattice& lattice, Progress& progress) {
  return Boundary(image, progress).mesh(lattice, progress);
}

}  // namespace shrinkwrap
