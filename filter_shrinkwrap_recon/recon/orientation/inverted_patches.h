// Patches that no view tells of, and which contradict what they lie in, are turned.
#pragma once

#include <vector>

#include "orientation/neighbour_graph.h"
#include "orientation/sign_agreement.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct InvertedPatchOptions {
  double most_noise = 0.25;       ///< in a thick layer of samples (NeighbourGraph::noise) winding
                                  ///< numbers are those of no surface; negative: no patch is turned
  double least_seen = 0.02;       ///< hidden if less of the possible votes was cast
  double most_off = 0.5;          ///< of the winding number at a sample, from 1/2
  Index least_samples = 32;       ///< of a patch: here and there a few samples are off
  double most_objections = 10.0;  ///< of the edges in and around a patch once it is turned, x those
                                  ///< before
  double most_left = 0.5;  ///< of what its winding numbers are off, once it is turned, x before
};

/// A chamber within a body, behind mouths with sharp edges, is a patch whose sign hangs on a few
/// edges of the neighbour graph that contradict each other, and no view tells of it. But on the
/// boundary of bodies the winding number is 1/2, the mean of 1 within and 0 outside. On a patch
/// that is inside out it is 3/2, for what it lies in counts as well, or -1/2 on one that lies in
/// nothing. So connected samples with such numbers, one of them hidden at least, are turned, unless
/// the edges object clearly, or the winding numbers do not become right. Returns how many samples
/// were turned.
/// Pre: oriented normals; `graph` refers to the cloud, and `votes` tell what was seen of it. A few
/// trees of O(N log N), and the samples hidden and turned x log N; the same for any number of
/// threads. Throws Cancelled.
Index turn_inverted_patches(PointCloud& cloud, const NeighbourGraph& graph,
                            const SampleVotes& votes, const InvertedPatchOptions& options,
                            Progress& progress);

}  // namespace shrinkwrap
