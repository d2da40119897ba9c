// Where there is more noise than in the rest of the cloud.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct MoreNoiseOptions {
  /// There is more noise around a sample if it is so many times that of the cloud, or of its calm
  /// part if it has one, and more than `from` (x local spacing).
  double times = 2.0, from = 0.1;
  /// Where clean and noisy parts share a cloud, its noise is that of neither: where this part of it
  /// has less than so many times the noise that half of it has. More is then more than that. In
  /// clouds that are noisy all over, edges and detail or not, a fifth had 0.61 times as much and
  /// more.
  double calm_part = 0.2, calm_times = 0.5;
  /// Where there is noise, few samples lie on a plane with seven of their ten nearest (themselves
  /// among these), however it is laid: four fifths are so many times the noise off it. Of the
  /// narrowest ribs and finest lettering, which quadrics miss too, there are always such.
  double least_roughness = 0.3;
};

struct MoreNoise {
  Index samples = 0;    ///< around which there is more noise than around the others
  double part = 0.0;    ///< of all
  double median = 0.0;  ///< of theirs, x local spacing
  double others = 0.0;  ///< the noise of the others: that of the cloud, unless this has calm parts
};

/// Fills in `cloud.more_noise`, for clouds that are noisy in part, as where a scanner looked along
/// the surface. The noise around a sample is told as by `estimate_noise` (`noise`: its median), by
/// the 24 nearest of every fourth sample. It is kept near places, up to some 10 spacings away,
/// where it is surely noise, and no fine detail, all around. Pre: `orient_normals` was called on
/// the cloud. O(N), about 1 to 4 us a sample with two threads; the same for any number of threads.
/// Throws Cancelled.
MoreNoise measure_more_noise(PointCloud& cloud, double noise, const MoreNoiseOptions& options,
                             Progress& progress);

}  // namespace shrinkwrap
