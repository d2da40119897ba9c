// Which side of a surface the world sees: votes from orthographic depth buffers all around.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

/// What the views that look steeply enough on a sample tell of it, in sums of |cosine|; of a set of
/// samples, sums of these.
struct VisibilityVote {
  double possible = 0.0;  ///< of all such views
  double seen = 0.0;      ///< of those that see the sample
  double outward = 0.0;   ///< how much more those on the side that the normal points to see it than
                          ///< the others; the less, the more alike both sides are seen
  double closed = 0.0;    ///< x possible: 1 where nobody sees the other side, as within a body, 0
                          ///< where a quarter of the views does, as on both sides of an open sheet;
  ///< by views from one side (VisibilityOptions::front) 1 of what faces them
  double foremost = 0.0;  ///< as `seen`, where the foremost sample is of the same component

  /// In [-1, 1]: how much more the side that the normals point to is seen than the other.
  double majority() const { return possible > 0.0 ? outward / possible : 0.0; }
  /// How far `outward` tells which side is outside. Not at all of open sheets, of which most
  /// samples are seen from both sides: what stands on a sheet hides its front from some views, and
  /// nothing hides its back. In [0, 1].
  double trust() const;

  /// On the opposite normal.
  VisibilityVote turned() const { return {possible, seen, -outward, closed, foremost}; }
  void add(const VisibilityVote& other) {
    possible += other.possible;
    seen += other.seen;
    foremost += other.foremost;
    outward += other.outward;
    closed += other.closed;
  }
};

struct VisibilityOptions {
  int directions = 96;        ///< all around, of which those on the side of `front` vote
  Vec3 front = Vec3::Zero();  ///< within 90 degrees of it; zero: all do
  double min_cosine = 0.5;
  double pixel = 0.0;            ///< edge of a pixel, unit frame
  double depth_tolerance = 0.0;  ///< a sample this much behind the foremost is still seen
};

/// Draws the samples `drawn` from all directions; returns the vote on each of them. Splats are 3 x
/// 3 pixels, so that a surface hides what is behind it; the tolerance grows with the slope. Buffers
/// hold at most a fixed multiple of the samples drawn (then the pixel is enlarged).
///
/// In slanting views the tolerance is several pixels, more than many a wall is thick. So a sample
/// is hidden by a foremost one of a sheet along its own, if that is farther off, measured along the
/// mean of the two normals, than the tolerance of a view from above. With a component for each
/// sample of the cloud, `foremost` leaves out what is seen only through others nevertheless;
/// without, it is `seen`. O(directions x drawn); the same for any number of threads.
std::vector<VisibilityVote> visibility_votes(
    const PointCloud& cloud, const std::vector<Index>& drawn, const VisibilityOptions& options,
    Progress& progress, const std::vector<Index>* component_of_sample = nullptr);

}  // namespace shrinkwrap
