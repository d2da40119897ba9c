// Points so far away that nothing could be told of the others beside them.
#pragma once

#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

struct FarStrayOptions {
  /// Stray is what lies farther from the middle of the cloud than this many times its extent, that
  /// of all but a fifth of the points along each axis: beside it the others would have less than a
  /// ten-thousandth of the unit frame, and their spacing about what single precision resolves.
  double times_extent = 1e4;
  /// Distinct points: so many are no strays, nor are a hundredth of all, if that is 4 or more.
  Index most = 30;
};

struct FarStrays {
  std::vector<Index> all;       ///< indices of points, ascending
  std::vector<Index> distinct;  ///< of these the first at each place, ascending
};

/// Finds stray points such as the coordinates that stand for no measurement in some files. Points
/// that are not finite count for nothing. O(N), parallel. None of fewer than 64 distinct points.
FarStrays find_far_strays(const std::vector<Vec3>& points, const FarStrayOptions& options,
                          Progress& progress);

}  // namespace shrinkwrap
