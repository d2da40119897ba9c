// How noisy the samples are, relative to their spacing.
#pragma once

#include "samples/layers.h"
#include "samples/more_noise.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct NoiseOptions {
  LayerOptions layers;
  Index probes = 1024;  ///< samples that are looked at, evenly spread; fewer in small clouds
  /// Above this the surface through the samples is rough (x local spacing). Clean clouds have 0.12
  /// and less, unless they have about as few samples as bones and walls are thick (0.21).
  double high = 0.2;
  /// Of clouds above that, in place of the ratio of initial_mesh.h: voxels somewhat larger refute
  /// handles between noisy layers, which smaller ones show too. Half as large again refutes handles
  /// of three spacings.
  double second_voxel_ratio = 1.25;
  /// To smooth the parametric surface of a noisy cloud (median from 0.04 on), normals and voxels
  /// are made wider, by one unit for every `smooth_unit` of the upper fifth beyond `smooth_from`,
  /// at most `most_units`.
  double smooth_from = 0.3;
  double smooth_unit = 0.35;
  double most_units = 1.5;
};

struct NoiseEstimate {
  double median = 0.0;  ///< x local spacing, over the samples
  /// A fifth of the samples have more: where scans overlap, for example, or parts are so thin that
  /// quadrics miss them, which counts here.
  double upper_fifth = 0.0;
  Layers layers;   ///< whose steps count as noise
  MoreNoise more;  ///< where there is more, once that was measured

  /// Of the samples around which there is not more: the median, unless the cloud has calm parts.
  double of_others() const { return more.samples > 0 ? more.others : median; }
};

/// The deviation of the samples from the surface that they lie on, in local spacings: what the
/// neighbours of a sample that face the same way deviate from the quadratic height field that fits
/// them best (Cazals and Pouget 2005, degree 2), freed of the bias of the fit, and of what the
/// quadric misses of a curved surface, which unlike noise grows with the neighbourhood: two sizes
/// are fitted. Neighbourhoods are widened until they are wider than thick. About right to 0.5, and
/// too low beyond (0.8 for 1, also because the spacing is then overestimated). 0 if there is too
/// little to tell. Samples in layers, whose neighbours may well have no deviation at all, have at
/// least that of rounding across the axis, the step over the square root of 12, but not more than a
/// spacing for that. Pre: `orient_normals` was called on the cloud. The same for any number of
/// threads.
NoiseEstimate estimate_noise(const PointCloud& cloud, const NoiseOptions& options,
                             Progress& progress);

}  // namespace shrinkwrap
