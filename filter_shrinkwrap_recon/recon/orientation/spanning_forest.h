// Signs made consistent along the edges that can be trusted most.
#pragma once

#include "orientation/sign_agreement.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct SignOptions {
  double patch_agreement = 0.995;  ///< edges that agree as much join samples into patches ...
  double least_majority = 0.15;    ///< ... unless both parts are seen as clearly, of the votes
                                   ///< there could have been, and it must be one from behind
  Index least_samples = 10;        ///< drawn of such a part
  double contact_agreement = 0.9;  ///< edges that agree less, for the noise, join no two sets ...
  Index contact_samples = 64;      ///< ... that both have as many samples
  double vote_weight = 0.1;        ///< see agreed_signs
};

/// The maximum spanning forest of the neighbour graph, as far as signs are concerned. Its
/// components need not be those of the graph: where two of them only touch, signs come of views.
struct SpanningForest {
  std::vector<Index> component_of_sample;  ///< numbered in order of lowest sample
  std::vector<char> flipped;  ///< whether to turn the normal; of span_normals: whether it opposes
                              ///< that of its component's first sample
  std::vector<char> flipped_as_agreed;  ///< as agreed upon, up to one sign per component; empty if
                                        ///< there is nothing to agree upon
  Index components = 0;
};

/// Kruskal over the edges of the neighbour graph, by descending
/// certainty (neighbour_graph.h). Sorted by buckets, of one bucket by index. O(N) but for the
/// union-find.
///
/// One wrong sign at a crease or in a narrow place would turn all that lies beyond it inside out.
/// So the edges that nobody doubts, neither by their normals nor by what is seen of either side,
/// join samples into patches; where there are more of them than of components, other signs are
/// proposed, by all edges between them and by all views (sign_agreement.h). In the forest, sure
/// edges to which views object come after all sure edges and before the others. Where no better
/// edges join two large sets than those across a thin wall or a slot, askew as most of these are,
/// the sets remain components of their own.
SpanningForest span_normals(const NeighbourGraph& graph, const SampleVotes& votes,
                            const SignOptions& options, Progress& progress);

}  // namespace shrinkwrap
