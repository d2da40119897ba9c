// Noisy samples moved onto the surface that they scatter about.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

struct DenoisingOptions {
  double first_radius = 3.2;  ///< x local spacing: of the smallest neighbourhood, about 32 samples
  double growth = 1.41421356;       ///< of the radius from one neighbourhood to the next
  int neighbourhoods = 6;    ///< sizes that are tried
  double confidence = 2.0;   ///< half-width of the intervals, x standard error
  bool local_sigma = false;
  double slope = 2.0;
  double residual = 2.0;
};

/// x
void denoise(PointCloud& cloud, double noise, const DenoisingOptions& options, Progress& progress);

}  // namespace shrinkwrap
