// The place from which one scanner or camera saw all samples, told by how dense they are.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct StationOptions {
  /// Less than so large a part of the spread of spacings is left once they are put down to the way
  /// to the station. Of views of depth cameras and scanners 0.01 to 0.28 is. 0: no place is taken
  /// for a station.
  double most_spread_left = 0.5;
  /// Beyond doubt a place is a station if less than this is left. Of an open dome that is ten times
  /// as dense on one side, a quarter and more is left from some places.
  double spread_left_for_sure = 0.1;
  /// Less than so much, x what is left if they are put down to the way to the place opposite: a
  /// sheet is as dense as seen from behind, too, if all of it is as far away, or all around. Then
  /// only a place beyond doubt, with the sheet below it (+z is up), is a station.
  double most_over_opposite = 0.5;
  double most_hidden = 0.35;  ///< of the area, beyond doubt; of a closed surface about half is
  double most_hidden_in_doubt = 0.1;  ///< if more of the spread is left: the same dome hides more,
                                      ///< the view with 0.28 left hides 0.04
  /// Length of the mean of the normals over the area, turned to the station, at least: that of what
  /// closes around the station, as a room does, is none, and makes a body.
  double least_sheet_normal = 0.3;
};

/// What part of the spread of spacings is left: the variance of their logarithms, each less that of
/// distance / sqrt(cosine), over that of their logarithms; of samples seen at equal angles it is 0,
/// and 1 or more if the way to the station tells nothing. Variances are those of the middle two
/// thirds, which the rims of openings do not spoil. Not finite if a sixth of the samples is seen
/// from the edge, or if all spacings are the same. O(N), parallel.
double spread_left_from(const PointCloud& cloud, const Vec3& station, Progress& progress);

/// The part of the area that lies behind other samples: within an angle of three of the median
/// between neighbours, and with these as far off its plane. At the rims of what stands before
/// something else samples count that are seen beside it. O(N log N).
double part_hidden_from(const PointCloud& cloud, const Vec3& station, Progress& progress);

/// Whether all samples were seen from a place, and are of a sheet. Pre: the cloud was prepared (the
/// signs of its normals do not matter). `station`: unit frame. O(N), of those that may be views
/// O(N log N).
bool is_view_from(const PointCloud& cloud, const Vec3& station, const StationOptions& options,
                  Progress& progress);

}  // namespace shrinkwrap
