// Normals where two parallel sheets are so close that neighbourhoods are of both.
#pragma once

#include "neighbourhoods.h"

namespace shrinkwrap {

struct ParallelSheetsOptions {
  double least_deviation = 0.1;  ///< x radius of the neighbourhood: whose points are nearer to
                                 ///< their plane than that are of one sheet
  double most_variance = 0.05;   ///< about two planes, x that about one
  int least_points = 4;          ///< of either sheet
  double least_width = 0.1;      ///< of either: the middle principal variance of its points, x the
                                 ///< greatest; those of a line lie on many planes
};

/// A plane that is fitted to points of both sides of a wall lies askew if the wall is about as
/// thick as the neighbourhood is wide. So where neighbours deviate from their plane, two parallel
/// planes are fitted to them, from nine first normals: those above and those below their mean
/// along the normal are the two sides, the next normal is that along which both scatter least about
/// their own means, and so on until none changes sides. If two planes fit far better than one,
/// their normal replaces that of the point, which neither noise nor a bend brings about. Deviations
/// stay those from one plane. Returns how many normals were replaced. O(N); the same for any number
/// of threads.
Index fit_parallel_sheets(const std::vector<Vec3>& points, Neighbourhoods& neighbourhoods,
                          const ParallelSheetsOptions& options, Progress& progress);

}  // namespace shrinkwrap
