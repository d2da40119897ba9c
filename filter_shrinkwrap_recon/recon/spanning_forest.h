// Signs made consistent along the edges that can be trusted most.
#pragma once

#include "point_cloud.h"
#include "visibility.h"

namespace shrinkwrap {

/// What the views say of some samples.
struct SampleVotes {
  std::vector<Index> drawn;
  std::vector<VisibilityVote> votes;  ///< on each of `drawn`
};

struct SignOptions {
  double least_majority = 0.15;  ///< of the votes there could have been: a clear view of a part
  double greatest_weight = 0.9;  ///< edges along smooth surface need no views
  Index least_samples = 10;      ///< drawn of a part
};

/// The maximum spanning forest of the neighbour graph, as far as signs are concerned.
struct SpanningForest {
  std::vector<Index> component_of_sample;  ///< numbered in order of lowest sample
  std::vector<char> flipped;  ///< whether the normal opposes that of its component's first sample
  std::vector<char> flipped_by_views;  ///< the same where views are followed; empty if none object
  Index components = 0;
};

/// Kruskal over the edges between each sample and its first `neighbours` neighbours, by descending
/// weight |n.n'| (1 - max(|d.n|, |d.n'|)), d the direction of the edge (Hoppe et al. 1992, with the
/// in-plane factor that keeps the tree from crossing thin walls). Weights are sorted by buckets, of
/// one bucket by index. O(N) but for the union-find.
///
/// One wrong sign at a crease or in a narrow place would turn all that lies beyond it inside out.
/// So where an edge joins two parts, each seen clearly more from one side, and its sign says
/// otherwise, the views object to it.
SpanningForest span_normals(const PointCloud& cloud, int neighbours, const SampleVotes& votes,
                            const SignOptions& options, Progress& progress);

}  // namespace shrinkwrap
