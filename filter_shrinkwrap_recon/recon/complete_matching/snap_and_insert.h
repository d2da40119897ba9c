// Section 2.5 as in the paper - snap, eliminate, insert, swap - by manifold-preserving operations
// only.
#pragma once

#include "complete_matching/complete_matching.h"

namespace shrinkwrap {

/// Makes the complete matching without re-tiling:
/// 1. every vertex is assigned to the nearest sample whose normal agrees with its own (xi = 1,
///    eta = 0); of several at one sample the nearest wins and moves onto it;
/// 2. the others are removed by link-checked half-edge collapses, in place of merging vertices,
///    which would not keep the mesh a manifold;
/// 3. every isolated sample is inserted into its nearest face, the nearest sample of a face in each
///    round, and edges around it are flipped by the max-min criterion, but only where that turns no
///    face away.
/// The mesh is a closed 2-manifold after every operation, of the topology of the surface but for
/// components that hold no sample; it may intersect itself where retile's does not. Openings are
/// always closed. Normals count only if `orient_normals` was called on the cloud.
/// Vertex i is sample i; vertices that the topology cannot do without follow. See match_samples for
/// the rest. O(N log N) for samples spread over the faces; parallel but for the flips, the same for
/// any number of threads.
CompleteMatching snap_and_insert(SurfaceMesh parametric, const PointCloud& cloud,
                                 const CompleteMatchingOptions& options, Progress& progress);

}  // namespace shrinkwrap
