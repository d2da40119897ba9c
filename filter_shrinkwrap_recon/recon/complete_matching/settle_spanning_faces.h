// Faces that span openings, flipped to Delaunay at last.
#pragma once

#include <cstdint>
#include <vector>

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

struct SettlingOptions {
  /// Bounds the time: tests of pairs of triangles; a face looked for in the tree counts as eight or
  /// more. 0: two million, and 20 for each face.
  std::int64_t max_tests = 0;
};

/// Flips edges between two spanning faces that stay to Delaunay (delaunay_flips.h), where the new
/// faces cut, touch or overlap no face that stays: while an opening was closed, flips would have
/// cut what went later, and faces that fan out from few samples remained. `fixed_faces` (ascending)
/// stay too, and no edge becomes longer than the longest. Returns the number of flips. Each
/// spanning face stays one; the vertices do not move. O(F log F) if anything spans. Deterministic.
/// Pre: no removed slots.
Index settle_spanning_faces(CompleteMatching& matching, const std::vector<Index>& fixed_faces,
                            const SettlingOptions& options, Progress& progress);

}  // namespace shrinkwrap
