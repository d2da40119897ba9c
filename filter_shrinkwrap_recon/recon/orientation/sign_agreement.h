// Signs of normals that all neighbours and all views together agree upon best.
#pragma once

#include <cmath>
#include <vector>

#include "orientation/neighbour_graph.h"
#include "orientation/visibility.h"

namespace shrinkwrap {

/// What the views say of some samples.
struct SampleVotes {
  std::vector<Index> drawn;
  std::vector<VisibilityVote> votes;  ///< on each of `drawn`

  std::vector<VisibilityVote> by_component(const std::vector<Index>& component_of_sample,
                                           Index components) const;
  /// The votes count as far as those on their components are to be trusted.
  void weigh_by_trust(const std::vector<Index>& component_of_sample, Index components);
  /// Of the vote on one of those drawn, which speak for so many samples.
  double weight_of_one(double vote_weight, std::size_t samples) const;
};

/// Parts of a cloud, each with one sign to be chosen.
struct SignedPatches {
  std::vector<Index> patch_of_sample;
  std::vector<char> flipped;  ///< per sample: whether its normal opposes that of its patch
  Index count = 0;
};

/// How much an edge between neighbours counts (NeighbourGraph::agreement): |a|^4, with the sign of
/// a. Those in doubt count for little.
inline double edge_weight(double agreement) {
  return agreement * agreement * agreement * std::abs(agreement);
}

/// For each patch the sign x in [-1, 1] that minimises, over all edges between neighbours and all
/// samples,
///   sum |a_ij|^4 (x_i - sign(a_ij) x_j)^2 + vote_weight sum |v_i| (x_i - sign(v_i))^2
/// (a relaxation of the problem of Schertler et al. 2017): a_ij how surely two neighbours look to
/// the same side (neighbour_graph.h), v_i the majority of the views on a sample (of those that were
/// drawn, which also speak for the others). One wrong edge turns nothing inside out here, as it
/// does in a spanning tree. 0: no view tells. A sparse system of one unknown per patch, solved by
/// conjugate gradients; the same for any number of threads.
std::vector<float> agreed_signs(const NeighbourGraph& graph, const SignedPatches& patches,
                                const SampleVotes& votes, double vote_weight, Progress& progress);

}  // namespace shrinkwrap
