// Samples that are there several times, but for a little: scans merged twice, frames of a scanner
// that stands still, exports of one cloud with different rounding.
#pragma once

#include <vector>

#include "common/progress.h"
#include "common/types.h"
#include "geometry/voxel_search.h"

namespace shrinkwrap {

struct NearCopyOptions {
  bool enabled = true;
  /// Samples are copies of each other if the next one is so many times as far away as the farthest
  /// of them ...
  double least_gap = 5.0;
  /// ... and so far that of samples spread at random no more than this part has such a gap.
  double by_chance = 1e-3;
  /// Part of the samples that have copies: where there are fewer, they are near each other by
  /// chance, and none is a copy.
  double least_share = 0.1;
};

/// A sample that lies where another one does, but for a little.
struct NearCopy {
  Index copy, original;
};

/// Which samples are copies, and of which, by their originals, ascending: of each group that lies
/// together far from all others (see the options), at most 16 samples, the original is the one in
/// its middle. None is both. Of fewer than 100 samples none is a copy. One neighbourhood in many
/// tells whether there are enough; if so, O(N log N), parallel. Pre: `search` was made of the
/// points.
std::vector<NearCopy> find_near_copies(const std::vector<Vec3>& points, const VoxelSearch& search,
                                       const NearCopyOptions& options, Progress& progress);

}  // namespace shrinkwrap
