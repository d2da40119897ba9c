#include "mesh/vertex_blocks.h"

#include "geometry/morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;
constexpr Index kProbeStride =
    64;  // every so many vertices one is asked where the cells should end

}  // namespace

VertexBlocks::VertexBlocks(const std::vector<Vec3>& positions, Progress& progress) {
  const Index count = static_cast<Index>(positions.size());
  cell_.assign(positions.size(), 0);
  const Box box = bounding_box(positions);
  const double scale = morton_cells_per_length(box);
  const auto key_of = [&](Index v) {
    const Vec3 cell = (positions[v] - box.low) * scale;
    return morton_key(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                      static_cast<std::uint32_t>(cell.z()));
  };

  // Cells end at evenly spaced keys of a sample of the vertices.
  std::vector<std::uint64_t> probe;
  for (Index v = 0; v < count; v += kProbeStride) probe.push_back(key_of(v));
  std::sort(probe.begin(), probe.end());
  std::vector<std::uint64_t> first_key;  // of each cell but the first
  constexpr std::size_t kProbesPerCell = kCellVertices / kProbeStride;
  for (std::size_t i = kProbesPerCell; i < probe.size(); i += kProbesPerCell)
    if (first_key.empty() || probe[i] > first_key.back()) first_key.push_back(probe[i]);
  cells_ = static_cast<Index>(first_key.size()) + 1;

  parallel_blocks(count, kGrain, progress, [&](Index, Index begin, Index end) {
    Index cell = 0;
    for (Index v = begin; v < end; ++v) {
      const std::uint64_t key = key_of(v);
      const bool same_as_last = (cell == 0 || key >= first_key[cell - 1]) &&
                                (cell + 1 == cells_ || key < first_key[cell]);
      if (!same_as_last)
        cell = static_cast<Index>(std::upper_bound(first_key.begin(), first_key.end(), key) -
                                  first_key.begin());
      cell_[v] = cell;
    }
  });

  begin_.assign(static_cast<std::size_t>(cells_) + 1, 0);
  for (Index v = 0; v < count; ++v) ++begin_[cell_[v] + 1];
  for (Index cell = 0; cell < cells_; ++cell) begin_[cell + 1] += begin_[cell];
  std::vector<Index> cursor(begin_.begin(), begin_.end() - 1);
  ordered_.resize(positions.size());
  for (Index v = 0; v < count; ++v) ordered_[cursor[cell_[v]]++] = v;
}

}  // namespace shrinkwrap
