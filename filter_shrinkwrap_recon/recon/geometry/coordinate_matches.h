// Which samples are vertices, by their coordinates alone, bit for bit.
#pragma once

#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

/// Whether a point comes first by x, then y, then z. An order of finite points only.
inline bool coordinates_less(const Vec3& p, const Vec3& q) {
  for (int axis = 0; axis < 3; ++axis)
    if (p[axis] != q[axis]) return p[axis] < q[axis];
  return false;
}

struct CoordinateMatches {
  Index samples = 0;        ///< distinct and finite; -0 equals 0
  Index matched = 0;        ///< samples at which exactly one vertex lies
  Index missing = 0;        ///< at which none lies
  Index matched_twice = 0;  ///< at which more than one lies
  Index extra = 0;          ///< vertices at no sample
};

/// Matches samples and vertices. O(N) expected, parallel; 16 bytes a sample and vertex while it
/// runs.
CoordinateMatches match_coordinates(const std::vector<Vec3>& samples,
                                    const std::vector<Vec3>& vertices, Progress& progress);

}  // namespace shrinkwrap
