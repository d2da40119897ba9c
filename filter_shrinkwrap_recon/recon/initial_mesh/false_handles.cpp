#include "initial_mesh/false_handles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/parallel.h"
#include "geometry/triangle_geometry.h"
#include "geometry/widest_turn.h"
#include "initial_mesh/genus_limit.h"
#include "mesh/face_patches.h"
#include "mesh/one_ring.h"
#include "mesh/surface_loops.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kMostRounds = 4;  // loops that meet those of a round are cut in the next
constexpr Index kUpdateInterval = 1 << 12;
// Where a ball of this many edges more than that of a loop is a disc, no vertex so near to its
// centre has a loop either.
constexpr Index kClear = 2;
constexpr std::size_t kMostOfBall = 1 << 12;

// Samples that may bear out a loop: so many nearest to each of its vertices, so far from its plane
// at most (x the mean length of its edges), that look to where the loop does (cosine, at least).
constexpr int kNearest = 8;
constexpr double kBeside = 0.6, kLooking = 0.5;
// Of samples at the rim of a tunnel: ground around a shadow slants to its middle, as seen from
// the plane of the rim, the more the higher the light stands.
constexpr double kLookingAcross = 0.75;

// The plane of a loop of vertices.
struct LoopFrame {
  Vec3 middle = Vec3::Zero();
  Vec3 axis = Vec3::Zero();  // unit; arbitrary, or zero, if the loop encloses no area
  double mean_edge = 0.0;
  bool is_around_hole = false;  // the surface looks towards the middle, not away from it
};

LoopFrame frame_of(const SurfaceMesh& mesh, const Loop& loop) {
  const auto count = static_cast<double>(loop.size());
  LoopFrame frame;
  for (const Index v : loop) frame.middle += mesh.position[v] / count;
  double outward = 0.0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Vec3 arm = mesh.position[loop[k]] - frame.middle;
    const Vec3 next = mesh.position[loop[(k + 1) % loop.size()]] - frame.middle;
    frame.axis += arm.cross(next);
    frame.mean_edge += (next - arm).norm() / count;
    outward += arm.dot(gather_one_ring(mesh, loop[k]).normal);
  }
  frame.axis.normalize();  // zero stays zero
  frame.is_around_hole = outward < 0.0;
  return frame;
}

class FalseHandles {
 public:
  FalseHandles(SurfaceMesh& mesh, const PointCloud& cloud, const FalseHandleOptions& options,
               Progress& progress)
      : mesh_(mesh), cloud_(cloud), options_(options), cosine_(mesh.position.size()) {
    parallel_for_each(mesh.vertex_slots(), kGrain, progress,
                      [&](Index v) { cosine_[v] = cosine_at(v); });
  }

  // Handles first: what is left of the loops are no handles, but may be mouths.
  FalseHandleReport cut_all(Progress& progress) {
    FalseHandleReport report;
    std::vector<Loop> loops = find_loops(progress);
    for (int round = 0; round < kMostRounds && !loops.empty(); ++round) {
      std::vector<Loop> handles = loops;
      keep_inseparable(mesh_, handles, progress);
      if (handles.empty()) break;
      cut(handles, progress);
      report.handles += static_cast<Index>(handles.size());
      loops = find_loops(progress);
    }
    if (loops.empty()) return report;
    keep_mouths_of_cavities(mesh_, loops, samples_by_vertex(progress), options_.least_of_cavity,
                            progress);
    cut(loops, progress);
    report.mouths = static_cast<Index>(loops.size());
    return report;
  }

  Index cut_doubtful(const SurfaceMesh& other, Index most, Progress& progress) {
    const VoxelSearch vertices_of_other(other.position, progress);
    PathTree tree_of_other(other);
    const auto is_shown = [&](const Loop& loop) {
      const Index nearest = vertices_of_other.nearest(frame_of(mesh_, loop).middle).index;
      return !loop_in_ball(other, tree_of_other, nearest, options_.radius, progress).empty();
    };
    Index handles = 0;
    for (int round = 0; round < kMostRounds && handles <= most; ++round) {
      const std::vector<Loop> loops = find_doubtful_loops(is_shown, progress);
      if (loops.empty()) break;
      cut(loops, progress);
      handles += static_cast<Index>(loops.size());
    }
    return handles;
  }

  Index count_tunnels_of_shadows(Progress& progress) const {
    // Small loops beside a rim enclose nothing, and are not to be in its way: the longest first.
    std::vector<Loop> loops = false_rims();
    std::stable_sort(loops.begin(), loops.end(),
                     [](const Loop& a, const Loop& b) { return a.size() > b.size(); });
    DisjointLoops disjoint(mesh_, std::numeric_limits<Index>::max());
    for (const Loop& loop : loops) disjoint.add(loop);
    keep_inseparable(mesh_, disjoint.loops, progress);
    return static_cast<Index>(disjoint.loops.size());
  }

 private:
  void cut(const std::vector<Loop>& loops, Progress& progress) {
    if (loops.empty()) return;
    const Index first_new = mesh_.vertex_slots();
    cut_along(mesh_, loops, progress);
    cosine_.resize(mesh_.position.size());
    for (const Loop& loop : loops)
      for (const Index v : loop) cosine_[v] = cosine_at(v);
    for (Index v = first_new; v < mesh_.vertex_slots(); ++v) cosine_[v] = cosine_at(v);
  }

  // Around faces that no sample bears out, where these begin to look inwards.
  std::vector<Loop> false_rims() const {
    std::vector<char> is_unseen(static_cast<std::size_t>(mesh_.face_slots()));
    for (Index f = 0; f < mesh_.face_slots(); ++f) {
      const Triangle t = mesh_.triangle(f);
      const auto is_off = [&](Index v) { return cosine_[v] < options_.least_cosine; };
      is_unseen[f] = std::count_if(t.begin(), t.end(), is_off) >= 2;
    }
    std::vector<Loop> found;
    for (const std::vector<Index>& rim : border_loops_of(mesh_, is_unseen)) {
      Loop loop;
      for (const Index h : rim) loop.push_back(mesh_.origin(h));
      const LoopFrame frame = frame_of(mesh_, loop);
      double inward = 0.0;
      for (const Index h : rim)
        inward += unit_or_zero(mesh_.area_vector(SurfaceMesh::face(h)))
                      .dot((frame.middle - mesh_.position[mesh_.origin(h)]).normalized());
      if (inward > 0.0 && gap_across(loop, frame) > options_.widest_gap)
        found.push_back(std::move(loop));
    }
    return found;
  }

  // Around the middle of a rim, between the nearest samples that look to it.
  double gap_across(const Loop& loop, const LoopFrame& frame) const {
    if (frame.axis.isZero()) return 2.0 * kPi;
    const Vec3 side = frame.axis.unitOrthogonal(), across = frame.axis.cross(side);
    std::vector<double> directions;
    for (const Index v : loop) {
      const Index nearest = cloud_.search.nearest(mesh_.position[v]).index;
      const Vec3 offset = cloud_.position[nearest] - frame.middle;
      const Vec3 arm = offset - offset.dot(frame.axis) * frame.axis;
      if (-arm.dot(cloud_.normal[nearest].cast<double>()) > kLookingAcross * arm.norm())
        directions.push_back(std::atan2(arm.dot(across), arm.dot(side)));
    }
    return widest_turn(std::move(directions));
  }

  // To how many samples each vertex is the nearest.
  std::vector<Index> samples_by_vertex(Progress& progress) const {
    const VoxelSearch vertices(mesh_.position, progress);
    std::vector<Index> nearest(cloud_.position.size());
    parallel_for_each(cloud_.size(), kGrain, progress,
                      [&](Index i) { nearest[i] = vertices.nearest(cloud_.position[i]).index; });
    std::vector<Index> samples(mesh_.position.size(), 0);
    for (const Index v : nearest) ++samples[v];
    return samples;
  }

  float cosine_at(Index v) const {
    const Index nearest = cloud_.search.nearest(mesh_.position[v]).index;
    return cloud_.normal[nearest].dot(gather_one_ring(mesh_, v).normal.cast<float>());
  }

  std::vector<Loop> find_loops(Progress& progress) const {
    PathTree tree(mesh_);
    std::vector<char> is_clear(cosine_.size(), 0);
    std::vector<Loop> found;
    for (Index v = 0; v < mesh_.vertex_slots(); ++v) {
      if (v % kUpdateInterval == 0) progress.update(1.0);
      // The vertex of a false loop where it agrees least.
      if (cosine_[v] >= options_.least_cosine || is_clear[v]) continue;
      if (clear_around(v, tree, is_clear, progress)) continue;
      Loop loop = loop_in_ball(mesh_, tree, v, options_.radius, progress);
      if (!loop.empty() && is_false(loop)) found.push_back(std::move(loop));
    }
    sort_by_length(found);
    DisjointLoops disjoint(mesh_, std::numeric_limits<Index>::max());
    for (const Loop& loop : found) disjoint.add(loop);
    return std::move(disjoint.loops);
  }

  // Of several around one handle those that may stay stand for it.
  template <class IsShown>
  std::vector<Loop> find_doubtful_loops(const IsShown& is_shown, Progress& progress) const {
    PathTree tree(mesh_);
    std::vector<char> is_clear(cosine_.size(), 0);
    std::vector<Loop> may_stay, doubtful;
    for (Index v = 0; v < mesh_.vertex_slots(); ++v) {
      if (v % kUpdateInterval == 0) progress.update(1.0);
      if (is_clear[v] || clear_around(v, tree, is_clear, progress)) continue;
      Loop loop = loop_in_ball(mesh_, tree, v, options_.radius, progress);
      if (loop.empty()) continue;
      const bool stays = is_borne_out(loop) || is_shown(loop);
      (stays ? may_stay : doubtful).push_back(std::move(loop));
    }
    DisjointLoops disjoint(mesh_, std::numeric_limits<Index>::max());
    std::vector<char> is_doubtful(cosine_.size(), 0);  // by the first vertex of a loop
    for (std::vector<Loop>* loops : {&may_stay, &doubtful}) {
      sort_by_length(*loops);
      const std::size_t before = disjoint.loops.size();
      for (const Loop& loop : *loops) disjoint.add(loop);
      for (std::size_t k = before; k < disjoint.loops.size(); ++k)
        is_doubtful[disjoint.loops[k].front()] = loops == &doubtful;
    }
    keep_inseparable(mesh_, disjoint.loops, progress);
    std::vector<Loop> found;
    for (Loop& loop : disjoint.loops)
      if (is_doubtful[loop.front()]) found.push_back(std::move(loop));
    return found;
  }

  bool clear_around(Index centre, PathTree& tree, std::vector<char>& is_clear,
                    Progress& progress) const {
    if (!tree.grow(mesh_, {centre}, options_.radius + kClear, kMostOfBall, progress) ||
        !tree.is_disc(mesh_))
      return false;
    for (const Index v : tree.reached()) {
      if (tree.distance(v) > kClear) break;
      is_clear[v] = 1;
    }
    return true;
  }

  bool is_false(const Loop& loop) const {
    return mean_cosine(loop) < options_.least_cosine && widest_gap(loop) > options_.widest_gap;
  }

  bool is_borne_out(const Loop& loop) const {
    return frame_of(mesh_, loop).is_around_hole && mean_cosine(loop) >= options_.clear_cosine &&
           widest_gap(loop) <= options_.clear_gap;
  }

  // Around the middle of a loop, between samples that bear it out.
  double widest_gap(const Loop& loop) const {
    const LoopFrame frame = frame_of(mesh_, loop);
    if (frame.axis.isZero()) return 2.0 * kPi;
    const Vec3 side = frame.axis.unitOrthogonal(), across = frame.axis.cross(side);
    std::vector<double> directions;
    std::vector<VoxelSearch::Hit> nearest;
    for (const Index v : loop) {
      cloud_.search.k_nearest(mesh_.position[v], kNearest, nearest);
      for (const VoxelSearch::Hit& hit : nearest) {
        const Vec3 offset = cloud_.position[hit.index] - frame.middle;
        const double height = offset.dot(frame.axis);
        if (std::abs(height) > kBeside * frame.mean_edge) continue;
        const Vec3 arm = offset - height * frame.axis;
        const double outward = arm.dot(cloud_.normal[hit.index].cast<double>());
        if ((frame.is_around_hole ? -outward : outward) > kLooking * arm.norm())
          directions.push_back(std::atan2(arm.dot(across), arm.dot(side)));
      }
    }
    return widest_turn(std::move(directions));
  }

  double mean_cosine(const Loop& loop) const {
    double sum = 0.0;
    for (const Index v : loop) sum += cosine_[v];
    return sum / static_cast<double>(loop.size());
  }

  SurfaceMesh& mesh_;
  const PointCloud& cloud_;
  const FalseHandleOptions& options_;
  std::vector<float> cosine_;  // per vertex: of its normal and that of the nearest sample
};

}  // namespace

FalseHandleReport cut_false_handles(SurfaceMesh& mesh, const PointCloud& cloud,
                                    const FalseHandleOptions& options, Progress& progress) {
  const FalseHandleReport report = FalseHandles(mesh, cloud, options, progress).cut_all(progress);
  if (report.handles + report.mouths > 0) mesh.compact(progress);
  return report;
}

Index cut_doubtful_handles(SurfaceMesh& mesh, const SurfaceMesh& other, const PointCloud& cloud,
                           const FalseHandleOptions& options, Index most, Progress& progress) {
  const Index handles =
      FalseHandles(mesh, cloud, options, progress).cut_doubtful(other, most, progress);
  if (handles > 0) mesh.compact(progress);
  return handles;
}

Index count_tunnels_of_shadows(SurfaceMesh& mesh, const PointCloud& cloud,
                               const FalseHandleOptions& options, Progress& progress) {
  if (genus_of(mesh, progress) == 0) return 0;
  return FalseHandles(mesh, cloud, options, progress).count_tunnels_of_shadows(progress);
}

}  // namespace shrinkwrap
