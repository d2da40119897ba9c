#include "samples/near_copies.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kProbes = 2000;  // at least; one neighbourhood of so many is looked at
constexpr Index kGrain = 1 << 9;
constexpr Index kLeastSamples = 100;
constexpr int kMostCopies = 15;  // of one sample

// The samples that lie together with one: its `count` nearest, itself not counted.
struct Group {
  double spread = 1.0;  // distance of the farthest of them, x that of the next sample
  int count = 0;
  Index sample = kNone;
};

class NearCopySearch {
 public:
  NearCopySearch(const std::vector<Vec3>& points, const VoxelSearch& search,
                 const NearCopyOptions& options)
      : points_(points), search_(search) {
    // Of samples spread at random, the squared distance of the n-th, x that of the next, is below q
    // for q^n of them.
    for (int n = 1; n <= kMostCopies; ++n)
      most_spread_[n] = std::min(1.0 / options.least_gap, std::pow(options.by_chance, 0.5 / n));
  }

  Group group_of(Index sample, std::vector<VoxelSearch::Hit>& hits) const {
    search_.k_nearest(points_[sample], kMostCopies + 2, hits);
    Group group;
    group.sample = sample;
    for (std::size_t n = 1; n + 1 < hits.size(); ++n) {
      const double spread = std::sqrt(hits[n].squared_distance / hits[n + 1].squared_distance);
      if (!(spread <= most_spread_[n])) continue;
      group.spread = spread;
      group.count = static_cast<int>(n);
    }
    return group;
  }

  std::vector<Group> groups(Index stride, Progress& progress) const {
    const Index probes = (static_cast<Index>(points_.size()) + stride - 1) / stride;
    return parallel_collect<Group>(probes, kGrain, progress,
                                   [&](Index begin, Index end, std::vector<Group>& out) {
                                     std::vector<VoxelSearch::Hit> hits;
                                     for (Index i = begin; i < end; ++i) {
                                       const Group group = group_of(i * stride, hits);
                                       if (group.count > 0) out.push_back(group);
                                     }
                                   });
  }

 private:
  const std::vector<Vec3>& points_;
  const VoxelSearch& search_;
  std::array<double, kMostCopies + 1> most_spread_{};  // by count
};

}  // namespace

std::vector<NearCopy> find_near_copies(const std::vector<Vec3>& points, const VoxelSearch& search,
                                       const NearCopyOptions& options, Progress& progress) {
  const Index samples = static_cast<Index>(points.size());
  if (!options.enabled || samples < kLeastSamples) return {};
  const NearCopySearch near(points, search, options);
  const Index stride = std::max<Index>(samples / kProbes, 1);
  const auto is_few = [&](std::size_t count, Index of) {
    return static_cast<double>(count) < options.least_share * of;
  };
  std::vector<Group> groups = near.groups(stride, progress);
  if (is_few(groups.size(), samples / stride)) return {};
  if (stride > 1) groups = near.groups(1, progress);

  // From the middle of a group the next sample seems farthest.
  std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
    return a.spread < b.spread || (a.spread == b.spread && a.sample < b.sample);
  });
  std::vector<char> is_grouped(static_cast<std::size_t>(samples), 0);
  std::vector<NearCopy> copies;
  std::vector<VoxelSearch::Hit> hits;
  for (const Group& group : groups) {
    if (is_grouped[group.sample]) continue;
    is_grouped[group.sample] = 1;
    search.k_nearest(points[group.sample], group.count + 1, hits);
    for (const VoxelSearch::Hit& hit : hits) {
      if (is_grouped[hit.index]) continue;
      is_grouped[hit.index] = 1;
      copies.push_back({hit.index, group.sample});
    }
  }
  std::sort(copies.begin(), copies.end(), [](const NearCopy& a, const NearCopy& b) {
    return a.original < b.original || (a.original == b.original && a.copy < b.copy);
  });
  return copies;
}

}  // namespace shrinkwrap
