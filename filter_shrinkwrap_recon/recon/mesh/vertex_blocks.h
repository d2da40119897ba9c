// Blocks of nearby vertices, in which local operations run in parallel and yet give the same bytes
// for any number of threads.
#pragma once

#include <algorithm>
#include <vector>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// A partition of vertices into cells of about kCellVertices along a Morton curve, whatever the
/// order of the vertices. Two neighbouring cells make a block; in the second pass the pairs are
/// shifted by one cell, so that most borders of the first pass lie inside a block; the third pass
/// has one block of everything.
class VertexBlocks {
 public:
  static constexpr Index kCellVertices = 2048;
  static constexpr int kPasses = 3;

  /// O(V log(V / kCellVertices)), parallel.
  explicit VertexBlocks(const std::vector<Vec3>& positions, Progress& progress);

  Index block_count(int pass) const { return pass == 2 ? 1 : (cells_ + pass) / 2 + 1; }
  Index block_of(Index v, int pass) const { return pass == 2 ? 0 : (cell_[v] + pass) / 2; }
  /// Vertices of the blocks of the first pass, one block after the other.
  const Index* begin_of_block(Index block) const {
    return ordered_.data() + begin_[std::min(2 * block, cells_)];
  }

 private:
  Index cells_ = 1;
  std::vector<Index> cell_;     // per vertex
  std::vector<Index> ordered_;  // vertices by cell, ascending within
  std::vector<Index> begin_;    // per cell, and the end
};

/// The vertices that an operation may read around and change.
class BlockOwner {
 public:
  BlockOwner(const VertexBlocks& blocks, Index block, int pass)
      : blocks_(blocks), block_(block), pass_(pass) {}
  bool owns(Index v) const { return blocks_.block_of(v, pass_) == block_; }
  /// The last pass, serial, which leaves nothing to a later one.
  bool is_last() const { return pass_ == VertexBlocks::kPasses - 1; }

 private:
  const VertexBlocks& blocks_;
  Index block_;
  int pass_;
};

/// Runs local operations block by block. `seed(v, items)` appends the items of a vertex of the
/// first pass; `anchor(item)` is a vertex of an item; `work(owner, items)` deals with items and
/// leaves in `items` those that it may not touch in this pass, because they reach beyond what
/// `owner` owns. The result does not depend on the number of threads, as long as the work of one
/// block changes only faces all of whose corners it owns.
template <class Seed, class Anchor, class Work>
void run_in_blocks(const VertexBlocks& blocks, Progress& progress, const Seed& seed,
                   const Anchor& anchor, const Work& work) {
  std::vector<Index> items, begin;  // of the blocks of the later passes
  for (int pass = 0; pass < VertexBlocks::kPasses; ++pass) {
    const Index count = blocks.block_count(pass);
    std::vector<std::vector<Index>> deferred(static_cast<std::size_t>(count));
    parallel_blocks(count, 1, progress, [&](Index block, Index, Index) {
      std::vector<Index>& own = deferred[static_cast<std::size_t>(block)];
      if (pass == 0) {
        const Index* const end = blocks.begin_of_block(block + 1);
        for (const Index* v = blocks.begin_of_block(block); v != end; ++v) seed(*v, own);
      } else {
        own.assign(items.begin() + begin[block], items.begin() + begin[block + 1]);
      }
      if (own.empty()) return;
      work(BlockOwner(blocks, block, pass), own);
      sort_unique(own);
      own.shrink_to_fit();
    });
    if (pass + 1 == VertexBlocks::kPasses) return;
    // Counting sort of what is left by the blocks of the next pass.
    begin.assign(static_cast<std::size_t>(blocks.block_count(pass + 1)) + 1, 0);
    std::size_t left = 0;
    for (const auto& part : deferred) {
      left += part.size();
      for (const Index item : part) ++begin[blocks.block_of(anchor(item), pass + 1) + 1];
    }
    for (std::size_t block = 1; block < begin.size(); ++block) begin[block] += begin[block - 1];
    std::vector<Index> cursor(begin.begin(), begin.end() - 1);
    items.resize(left);
    for (const auto& part : deferred)
      for (const Index item : part) items[cursor[blocks.block_of(anchor(item), pass + 1)]++] = item;
  }
}

}  // namespace shrinkwrap
