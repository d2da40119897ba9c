// Which side of a surface the world sees: votes from orthographic depth buffers all around.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

/// Sums of |cosine| over the views that look steeply enough on a sample; of a set of samples, sums
/// of these.
struct VisibilityVote {
  double possible = 0.0;  ///< of all views
  double seen = 0.0;      ///< of those that see the sample
  double outward = 0.0;   ///< of those that see it, positive where they look against its normal

  /// In [-1, 1]: how much more the side that the normals point to is seen than the other.
  double majority() const { return possible > 0.0 ? outward / possible : 0.0; }

  /// On the opposite normal.
  VisibilityVote turned() const { return {possible, seen, -outward}; }
  void add(const VisibilityVote& other) {
    possible += other.possible;
    seen += other.seen;
    outward += other.outward;
  }
};

struct VisibilityOptions {
  int directions = 96;
  double min_cosine = 0.5;
  double pixel = 0.0;            ///< edge of a pixel, unit frame
  double depth_tolerance = 0.0;  ///< a sample this much behind the foremost is still seen
};

/// Draws the samples `drawn` from all directions; returns the vote on each of them. Splats are 3 x
/// 3 pixels, so that a surface hides what is behind it; the tolerance grows with the slope. Buffers
/// hold at most a fixed multiple of the samples drawn (then the pixel is enlarged).
/// O(directions x drawn); the same for any number of threads.
std::vector<VisibilityVote> visibility_votes(const PointCloud& cloud,
                                             const std::vector<Index>& drawn,
                                             const VisibilityOptions& options, Progress& progress);

}  // namespace shrinkwrap
