#include "mesh/self_intersection.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <limits>

#include "common/parallel.h"
#include "common/sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr Index kClusterGrain = 8;               // a block takes about a millisecond
constexpr std::size_t kMostOfSurface = 64 * 20;  // of a cluster: 20 a face
constexpr std::size_t kPollInterval = 1 << 12;   // in pairs of boxes: a heap may have millions

using Pair = std::pair<Index, Index>;

// Per face, set by any thread and never taken back: a pair that is left out only if both of its
// faces are set is of no account, whoever comes first.
class FaceFlags {
 public:
  explicit FaceFlags(std::size_t faces) : is_set_(faces) {}
  void set(Index f) { is_set_[f].store(true, std::memory_order_relaxed); }
  bool has(Index f) const { return is_set_[f].load(std::memory_order_relaxed); }
  std::vector<Index> faces() const {
    std::vector<Index> faces;
    for (std::size_t f = 0; f < is_set_.size(); ++f)
      if (is_set_[f].load(std::memory_order_relaxed)) faces.push_back(static_cast<Index>(f));
    return faces;
  }

 private:
  std::vector<std::atomic<bool>> is_set_;
};

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
  return keep_meetings(tree, test, triangles, std::numeric_limits<std::size_t>::max(), progress)
      .pairs;
}

KeptMeetings keep_meetings(const BoxTree& tree, const TrianglePairs& test,
                           const std::vector<Triangle>& triangles, std::size_t most_per_cluster,
                           Progress& progress) {
  FaceFlags meets(triangles.size());
  std::atomic<bool> has_all{true};
  KeptMeetings kept;
  kept.pairs = parallel_collect<Pair>(
      tree.cluster_count(), kClusterGrain, progress, [&](Index begin, Index end, auto& found) {
        for (Index cluster = begin; cluster < end; ++cluster) {
          const std::size_t before = found.size();
          std::size_t looks = 0;
          tree.for_each_overlapping_pair(cluster, [&](Index f, Index g) {
            if (++looks % kPollInterval == 0) progress.update(0.0);
            const bool may_keep = found.size() - before < most_per_cluster;
            if (!may_keep && meets.has(f) && meets.has(g)) return;
            if (!test.meet(triangles[f], triangles[g])) return;
            meets.set(f);
            meets.set(g);
            if (may_keep) found.push_back(std::minmax(f, g));
          });
          // Whether there are more may depend on which flags other threads have set by now.
          if (found.size() - before >= most_per_cluster) has_all.store(false);
        }
      });
  std::sort(kept.pairs.begin(), kept.pairs.end());
  kept.faces = meets.faces();
  kept.has_all_pairs = has_all.load();
  return kept;
}

KeptMeetings keep_meetings(const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& triangles, Progress& progress) {
  const BoxTree tree(positions, triangles, progress);
  return keep_meetings(tree, TrianglePairs(positions), triangles, kMostOfSurface, progress);
}

std::vector<Index> newly_meeting_faces(const KeptMeetings& before, const KeptMeetings& now) {
  std::vector<Index> faces;
  if (!before.has_all_pairs || !now.has_all_pairs) {
    std::set_difference(now.faces.begin(), now.faces.end(), before.faces.begin(),
                        before.faces.end(), std::back_inserter(faces));
    return faces;
  }
  std::vector<std::pair<Index, Index>> pairs;
  std::set_difference(now.pairs.begin(), now.pairs.end(), before.pairs.begin(), before.pairs.end(),
                      std::back_inserter(pairs));
  for (const auto& [f, g] : pairs) faces.insert(faces.end(), {f, g});
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
  FaceFlags meets(triangles.size());
  parallel_for_each(tree.cluster_count(), kClusterGrain, progress, [&](Index cluster) {
    std::size_t looks = 0;
    tree.for_each_overlapping_pair(cluster, [&](Index f, Index g) {
      if (++looks % kPollInterval == 0) progress.update(0.0);
      if (meets.has(f) && meets.has(g)) return;
      if (!test.meet(triangles[f], triangles[g])) return;
      meets.set(f);
      meets.set(g);
    });
  });
  return meets.faces();
}

}  // namespace shrinkwrap
