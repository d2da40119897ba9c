#include "false_handles.h"

#include <algorithm>
#include <limits>

#include "one_ring.h"
#include "parallel.h"
#include "surface_loops.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kMostRounds = 4;  // loops that meet those of a round are cut in the next
constexpr Index kUpdateInterval = 1 << 12;
// Where a ball of this many edges more than that of a loop is a disc, no vertex so near to its
// centre has a loop either.
constexpr Index kClear = 2;
constexpr std::size_t kMostOfBall = 1 << 12;

class FalseHandles {
 public:
  FalseHandles(const SurfaceMesh& mesh, const PointCloud& cloud, const FalseHandleOptions& options,
               Progress& progress)
      : mesh_(mesh), options_(options), cosine_(mesh.position.size()), tree_(mesh) {
    parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
      const Index nearest = cloud.search.nearest(mesh.position[v]).index;
      const Vec3 normal = gather_one_ring(mesh, v).normal;
      cosine_[v] = cloud.normal[nearest].dot(normal.cast<float>());
    });
  }

  // Loops to be cut at once.
  std::vector<Loop> loops(Progress& progress) {
    std::vector<char> is_clear(cosine_.size(), 0);
    std::vector<Loop> found;
    for (Index v = 0; v < mesh_.vertex_slots(); ++v) {
      if (v % kUpdateInterval == 0) progress.update(1.0);
      // The vertex of a false loop where it agrees least.
      if (cosine_[v] >= options_.least_cosine || is_clear[v]) continue;
      if (clear_around(v, is_clear, progress)) continue;
      Loop loop = loop_in_ball(mesh_, tree_, v, options_.radius, progress);
      if (!loop.empty() && mean_cosine(loop) < options_.least_cosine)
        found.push_back(std::move(loop));
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Loop& a, const Loop& b) { return a.size() < b.size(); });
    DisjointLoops disjoint(mesh_, std::numeric_limits<Index>::max());
    for (const Loop& loop : found) disjoint.add(loop);
    keep_inseparable(mesh_, disjoint.loops, progress);
    return std::move(disjoint.loops);
  }

 private:
  bool clear_around(Index centre, std::vector<char>& is_clear, Progress& progress) {
    if (!tree_.grow(mesh_, {centre}, options_.radius + kClear, kMostOfBall, progress) ||
        !tree_.is_disc(mesh_))
      return false;
    for (const Index v : tree_.reached()) {
      if (tree_.distance(v) > kClear) break;
      is_clear[v] = 1;
    }
    return true;
  }

  double mean_cosine(const Loop& loop) const {
    double sum = 0.0;
    for (const Index v : loop) sum += cosine_[v];
    return sum / static_cast<double>(loop.size());
  }

  const SurfaceMesh& mesh_;
  const FalseHandleOptions& options_;
  std::vector<float> cosine_;  // per vertex: of its normal and that of the nearest sample
  PathTree tree_;
};

}  // namespace

Index cut_false_handles(SurfaceMesh& mesh, const PointCloud& cloud,
                        const FalseHandleOptions& options, Progress& progress) {
  Index cut = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const std::vector<Loop> loops = FalseHandles(mesh, cloud, options, progress).loops(progress);
    if (loops.empty()) break;
    cut_along(mesh, loops, progress);
    mesh.compact(progress);
    cut += static_cast<Index>(loops.size());
  }
  return cut;
}

}  // namespace shrinkwrap
