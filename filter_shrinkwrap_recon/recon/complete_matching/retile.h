// Section 2.5 by re-tiling the parametric surface with the samples (Turk 1992).
#pragma once

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

/// Inserts the foot of every sample into the surface, flips edges to Delaunay, removes every vertex
/// that is no sample, and lifts the feet to the samples. The mesh is a closed 2-manifold after
/// every operation. Membranes stay until the rest is done and are then closed or marked, as
/// `options.openings` says. See match_samples for the rest.
CompleteMatching retile(SurfaceMesh parametric, const PointCloud& cloud,
                        const CompleteMatchingOptions& options, Progress& progress);

}  // namespace shrinkwrap
