#include "self_intersection.h"

#include <algorithm>
#include <atomic>

#include "parallel.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr Index kClusterGrain = 8;  // a block takes about a millisecond

}  // namespace

std::vector<std::pair<Index, Index>> self_intersections(const std::vector<Vec3>& positions,
                                                        const std::vector<Triangle>& triangles,
                                                        Progress& progress) {
  const BoxTree tree(positions, triangles, progress);
  return self_intersections(tree, TrianglePairs(positions), triangles, progress);
}

std::vector<std::pair<Index, Index>> self_intersections(const BoxTree& tree,
                                                        const TrianglePairs& test,
                                                        const std::vector<Triangle>& triangles,
                                                        Progress& progress) {
  using Pair = std::pair<Index, Index>;
  std::vector<Pair> pairs = parallel_collect<Pair>(
      tree.cluster_count(), kClusterGrain, progress, [&](Index begin, Index end, auto& found) {
        for (Index cluster = begin; cluster < end; ++cluster)
          tree.for_each_overlapping_pair(cluster, [&](Index f, Index g) {
            if (test.meet(triangles[f], triangles[g])) found.push_back(std::minmax(f, g));
          });
      });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<Index> intersecting_faces(const std::vector<std::pair<Index, Index>>& pairs) {
  std::vector<Index> faces;
  faces.reserve(2 * pairs.size());
  for (const auto& [f, g] : pairs) {
    faces.push_back(f);
    faces.push_back(g);
  }
  sort_unique(faces);
  return faces;
}

std::vector<Index> self_intersecting_faces(const std::vector<Vec3>& positions,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress) {
  const BoxTree tree(positions, triangles, progress);
  return self_intersecting_faces(tree, TrianglePairs(positions), triangles, progress);
}

std::vector<Index> self_intersecting_faces(const BoxTree& tree, const TrianglePairs& test,
                                           const std::vector<Triangle>& triangles,
                                           Progress& progress) {
  // Threads only ever set flags, and a pair is left out only if both are set: which faces are
  // found does not depend on who comes first.
  std::vector<std::atomic<bool>> found(triangles.size());
  parallel_for_each(tree.cluster_count(), kClusterGrain, progress, [&](Index cluster) {
    tree.for_each_overlapping_pair(cluster, [&](Index f, Index g) {
      if (found[f].load(std::memory_order_relaxed) && found[g].load(std::memory_order_relaxed))
        return;
      if (!test.meet(triangles[f], triangles[g])) return;
      found[f].store(true, std::memory_order_relaxed);
      found[g].store(true, std::memory_order_relaxed);
    });
  });
  std::vector<Index> faces;
  for (std::size_t f = 0; f < found.size(); ++f)
    if (found[f].load(std::memory_order_relaxed)) faces.push_back(static_cast<Index>(f));
  return faces;
}

}  // namespace shrinkwrap
