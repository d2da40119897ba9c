// Coordinates that were rounded to steps wider than the samples are apart: depth cameras, grey
// levels, maps in whole metres.
#pragma once

#include "common/progress.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct LayerOptions {
  Index probes = 4096;       ///< samples that are looked at, evenly spread
  double least_part = 0.25;  ///< of these lie within layers, not at their ends, or there are none
  double least_step = 1.5;   ///< x local spacing: closer ones do no harm ...
  double most_step = 12.0;   ///< ... and farther ones are sheets of their own
  /// Of layers of one size that two samples would share as often (Simpson's index): a few large
  /// ones may well be the faces of an object, with rows of samples between them.
  double least_effective_count = 6.0;
  /// Within a layer, around a sample (radians): along a line, such as a contour, open or closed,
  /// there is one of half a turn.
  double widest_gap = 5.0 / 6.0 * kPi;
};

struct Layers {
  int axis = kNone;          ///< of the coordinate that tells the layers; kNone: there are none
  Index count = 0;           ///< of the layers that hold a probe
  double step = 0.0;         ///< x local spacing, between layers, the median over the probes
  double upper_fifth = 0.0;  ///< a fifth of the probes have more
};

/// Looks for samples that lie in patches of one and the same coordinate (to the bit), the next
/// value a step away. Where an object with faces across an axis is sampled all around, its other
/// faces hold values in between, and no step is that wide; or it has few such faces. Slices are
/// lines, not patches, and scan lines (`on_lines`) are not looked at. Pre: the cloud was prepared.
/// Where there are patches O(N log N), otherwise a few thousand probes: no cost to speak of. The
/// same for any number of threads.
Layers find_layers(const PointCloud& cloud, const LayerOptions& options, Progress& progress);

}  // namespace shrinkwrap
