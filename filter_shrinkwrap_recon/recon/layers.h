// Coordinates that were rounded to steps wider than the samples are apart: depth cameras, grey
// levels, maps in whole metres.
#pragma once

#include "point_cloud.h"
#include "progress.h"

namespace shrinkwrap {

struct LayerOptions {
  Index probes = 4096;      ///< samples that are looked at, evenly spread
  double least_part = 0.5;  ///< of these lie in layers, or there are none
  double least_step = 1.5;  ///< x local spacing: closer ones do no harm ...
  double most_step = 12.0;  ///< ... and farther ones are sheets of their own
  Index least_count = 8;    ///< of layers: fewer may well be the faces of an object
  double thinness = 0.2;    ///< narrower patches, x their length, are lines, such as contours
};

struct Layers {
  int axis = kNone;          ///< of the coordinate that tells the layers; kNone: there are none
  Index count = 0;           ///< of its values
  double step = 0.0;         ///< x local spacing, between layers, the median over the probes
  double upper_fifth = 0.0;  ///< a fifth of the probes have more
};

/// Looks for samples that lie in patches of one and the same coordinate (to the bit), the next
/// value a step away. Where an object with faces across an axis is sampled all around, its other
/// faces hold values in between, and no step is that wide. Slices are lines, not patches. Pre: the
/// cloud was prepared. Where there are patches O(N log N), otherwise a few thousand probes: no cost
/// to speak of. The same for any number of threads.
Layers find_layers(const PointCloud& cloud, const LayerOptions& options, Progress& progress);

}  // namespace shrinkwrap
