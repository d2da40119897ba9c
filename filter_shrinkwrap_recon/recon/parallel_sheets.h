// Normals where two parallel sheets are so close that neighbourhoods are of both.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

struct ParallelSheetsOptions {
  double least_deviation = 0.2;  ///< x local spacing: neighbours nearer to their plane are of one
                                 ///< sheet
  double most_variance = 0.05;   ///< about two planes, x that about one
  int least_samples = 4;         ///< of either sheet
  double least_width = 0.1;  ///< of the sheets, x length, squared: the samples of lines lie on many
                             ///< planes
};

/// A plane through samples of both sides of a wall lies askew if the wall is as thick as the
/// neighbourhood is wide. So where the neighbours deviate from their plane, two parallel planes are
/// fitted to them: from each principal axis, those above and those below their mean height get the
/// plane normal along which both scatter least about their own means, until none changes sides. If
/// two planes fit far better than one, their normal replaces that of the sample. Noise and bends do
/// not come near that. Returns how many were replaced. Signs stay arbitrary. O(N); the same for any
/// number of threads.
Index fit_parallel_sheets(PointCloud& cloud, const ParallelSheetsOptions& options,
                          Progress& progress);

}  // namespace shrinkwrap
