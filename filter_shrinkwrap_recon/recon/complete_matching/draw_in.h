// Vertices that close an opening and are no samples, drawn in to where they are needed.
#pragma once

#include <cstdint>

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

struct DrawingInOptions {
  int rounds = 6;     ///< of one move for each vertex
  double step = 0.5;  ///< part of the way to the mean of the neighbours; if that cuts ...
  int halvings = 3;   ///< ... it is halved, so often at most
  /// Bounds the time: tests of pairs of triangles; a face looked for in the tree counts as eight or
  /// more. 0: two million, and 20 for each face.
  std::int64_t max_tests = 0;
};

/// Moves vertices from `samples` on, of which every face spans an opening and one stays, towards
/// the mean of their neighbours, as far as none of their faces then cuts, touches or overlaps
/// another one: they are left from a membrane that may have bulged far behind a sheet. Positions
/// are such as the host can hold (`frame`, `scalar`). Returns how many were moved. The connectivity
/// does not change. O(F log F) if there are such vertices. Deterministic. Pre: vertex i below
/// `samples` is sample i; no removed slots.
Index draw_in_extra_vertices(CompleteMatching& matching, Index samples, const Frame& frame,
                             HostScalar scalar, const DrawingInOptions& options,
                             Progress& progress);

}  // namespace shrinkwrap
