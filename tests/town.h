// A town from above, as a scan from the air has it.
#pragma once

#include <vector>

#include "common/types.h"

namespace shrinkwrap::testing {

struct Town {
  std::vector<Vec3> points, outward;
};

struct TownOptions {
  bool has_walls = false;  ///< all of them; else those that are seen
  bool has_trees = false;
  /// From straight above there are roofs without walls, and holes in the ground below them. Seen
  /// obliquely, houses have one wall, and a shadow beyond the opposite one.
  bool is_oblique = false;
  int blocks = 5;       ///< along x, and along y
  double height = 6.0;  ///< of the houses
};

/// A flat house, 10 wide, in the middle of each block of flat ground, which is 20 wide;
/// samples one apart. What stands on the ground hides its front from most views, and nothing hides
/// its back.
Town make_town(const TownOptions& options, unsigned seed);

}  // namespace shrinkwrap::testing
