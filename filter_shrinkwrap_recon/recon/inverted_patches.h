// Patches that no view tells of, and which contradict what they lie in, are turned.
#pragma once

#include <vector>

#include "neighbour_graph.h"
#include "point_cloud.h"
#include "sign_agreement.h"

namespace shrinkwrap {

struct InvertedPatchOptions {
  double least_seen = 0.02;       ///< hidden if less of the possible votes was cast
  double most_off = 0.5;          ///< of the winding number at a sample, from 1/2
  Index least_samples = 32;       ///< of a patch: noise has a few such samples here and there
  double most_objections = 10.0;  ///< of the edges of a patch and around it once it is turned, x
                                  ///< those before
  double most_left = 0.5;  ///< of what its winding numbers are off, once it is turned, x before
};

/// A chamber within a body, behind mouths with sharp edges, is a patch whose sign hangs on a few
/// edges of the neighbour graph that contradict each other, and no view tells of it. But on the
/// boundary of bodies the winding number is 1/2, the mean of 1 within and 0 outside. On a patch
/// that is inside out it is 3/2, for what it lies in counts as well, or -1/2 on one that lies in
/// nothing. So connected hidden samples with such numbers are turned, and samples at the edge of
/// the patch as most of their edges say; unless the edges object clearly, or the winding numbers do
/// not become right. Returns how many samples were turned.
/// Pre: oriented normals, of which `graph` and `votes` are. O(N) and the hidden samples x log N;
/// the same for any number of threads. Throws Cancelled.
Index turn_inverted_patches(PointCloud& cloud, const NeighbourGraph& graph,
                            const SampleVotes& votes, const InvertedPatchOptions& options,
                            Progress& progress);

}  // namespace shrinkwrap
