// Normals where parallel sheets are so close that neighbourhoods are of several.
#pragma once

#include "samples/neighbourhoods.h"

namespace shrinkwrap {

/// Lengths x the mean spacing in the neighbourhood, as if it were of one sheet.
struct ParallelSheetsOptions {
  double least_deviation = 0.35;  ///< from their plane, of neighbours that may be of several sheets
  double thickness = 0.15;        ///< of a sheet
  double least_gap = 0.9;         ///< between sheets
  double most_variance = 0.1;     ///< of heights within two sheets, x that of all ...
  double most_of_plane = 0.3;  ///< ... and x that about the plane of all; within three, 0.3 x both
  double least_cosine = 0.73;  ///< between the normal and the way from one sheet to the next: what
                               ///< lies beyond an edge is no sheet above
};

/// A plane that is fitted to points of both sides of a wall lies askew if the wall is about as
/// thick as the neighbourhood is wide. So where neighbours deviate from their plane, the plane is
/// sought on which most of them lie, the nearer ones above all: of those through the point and any
/// two of the eight nearest that with the most support, fitted again to what supports it. Its
/// normal replaces that of the point if the heights over it fall into two or three sheets, with
/// gaps between, which neither noise nor a bend brings about. Deviations stay those from one
/// plane. Returns how many normals were replaced. O(N); the same for any number of threads.
Index fit_parallel_sheets(const std::vector<Vec3>& points, Neighbourhoods& neighbourhoods,
                          const ParallelSheetsOptions& options, Progress& progress);

}  // namespace shrinkwrap
