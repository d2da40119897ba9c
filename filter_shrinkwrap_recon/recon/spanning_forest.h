// Signs made consistent along the edges that can be trusted most.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

/// The maximum spanning forest of the neighbour graph, as far as signs are concerned.
struct SpanningForest {
  std::vector<Index> component_of_sample;  ///< numbered in order of lowest sample
  std::vector<char> flipped;  ///< whether the normal opposes that of its component's first sample
  Index components = 0;
};

/// Kruskal over the edges between each sample and its first `neighbours` neighbours, by descending
/// weight |n.n'| (1 - max(|d.n|, |d.n'|)), d the direction of the edge (Hoppe et al. 1992, with the
/// in-plane factor that keeps the tree from crossing thin walls). Weights are sorted by buckets, of
/// one bucket by index. O(N) but for the union-find.
SpanningForest span_normals(const PointCloud& cloud, int neighbours, Progress& progress);

}  // namespace shrinkwrap
