// The largest gap between directions in a plane.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/types.h"

namespace shrinkwrap {

/// The largest angle from one of the directions to the next around the circle, which holds none of
/// them; 2 pi if there is at most one. `angles` are radians, as std::atan2 gives them.
inline double widest_turn(std::vector<double> angles) {
  if (angles.empty()) return 2.0 * kPi;
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2.0 * kPi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k)
    widest = std::max(widest, angles[k] - angles[k - 1]);
  return widest;
}

}  // namespace shrinkwrap
