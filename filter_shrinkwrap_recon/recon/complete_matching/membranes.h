// Membranes: where the parametric surface spans an opening of the scan, far from every sample.
#pragma once

#include <vector>

#include "complete_matching/complete_matching.h"
#include "parametric_surface/sample_feet.h"

namespace shrinkwrap {

struct Membranes {
  std::vector<char> is_membrane;  ///< per vertex of the surface; empty if there are none
  Index count = 0;                ///< connected pieces
  Index backs = 0;                ///< vertices that were one if backs were openings, and are not
};

/// Marks vertices farther than `membrane_low` spacings from every sample (of their own side, if
/// `backs_are_openings`) that are connected, through such vertices, to one farther than
/// `membrane_high` (the larger of the median and the local spacing, for `membrane_low` that at the
/// nearest sample, for `membrane_high` that beside it). The feet of samples spare most vertices the
/// search. O(V) expected, parallel.
///
/// If openings are to be left open, also those that show along the surface (surface_openings.h):
/// where samples of another side are near, or the rims near each other. Not around the feet of
/// samples, and none that would cut off a part with few of them. O(V log V).
Membranes find_membranes(const SurfaceMesh& surface, const SampleFeet& feet,
                         const PointCloud& cloud, const CompleteMatchingOptions& options,
                         Progress& progress);

}  // namespace shrinkwrap
