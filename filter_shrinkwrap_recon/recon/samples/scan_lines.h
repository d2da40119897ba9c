// Samples that lie closer together along lines than the lines are to each other: slices, sections
// and swaths of a scanner.
#pragma once

#include "common/progress.h"
#include "common/types.h"
#include "geometry/voxel_search.h"

namespace shrinkwrap {

struct ScanLineOptions {
  double thinness = 0.2;  ///< a neighbourhood is a line if it is thinner than this, x its length
  double on_lines = 0.3;  ///< of the neighbourhoods: if no more of them are lines, all is well
  /// The number of neighbours grows with the distance as a power of it: along a line the first, on
  /// a surface the second. Neighbourhoods reach across lines if the median power is this at least.
  double least_growth = 1.65;
  int most_neighbours = 128;  ///< 0: never more than asked for
};

/// How many neighbours a sample needs for them to lie on several lines: `neighbours` if it does not
/// take more, or if more do not help (as on a wire, or between wires), otherwise the least power of
/// two times as many with which most do. Fewer than 4,000 probes, evenly spread in the order of the
/// points: no cost to speak of. Pre: `search` was made of the points, `neighbours` > 0.
int neighbours_across_lines(const std::vector<Vec3>& points, const VoxelSearch& search,
                            int neighbours, const ScanLineOptions& options, Progress& progress);

}  // namespace shrinkwrap
