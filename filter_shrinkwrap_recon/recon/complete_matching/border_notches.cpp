#include "complete_matching/border_notches.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/sort_unique.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr double kLeastTurn = 0.1436 * kPi;  // of a notch, 26 degrees: below, borders are straight
constexpr Index kLeastSamples = 4;           // of a border
constexpr double kLeastCosine = 0.7;         // between the triangle and the faces around the sample
constexpr double kLongestEdge = 4.0;         // x local spacing
constexpr Index kProgressStride = 1 << 10;

class NotchFiller {
 public:
  NotchFiller(SurfaceMesh& mesh, const PointCloud& cloud, std::vector<char>& is_dropped)
      : mesh_(mesh),
        cloud_(cloud),
        is_dropped_(is_dropped),
        border_(cloud.local_spacing.size(), kNone) {}

  // Samples at dropped faces, ascending. Tells the borders apart.
  std::vector<Index> samples_at_borders() {
    std::vector<Index> samples;
    for (Index f = 0; f < mesh_.face_slots(); ++f) {
      if (!is_dropped_[f]) continue;
      for (const Index v : mesh_.triangle(f))
        if (is_sample(v)) samples.push_back(v);
    }
    sort_unique(samples);
    for (const Index v : samples)
      if (border_[v] == kNone && find_dropped_fan(v)) follow_border(v);
    return samples;
  }

  // Fills the notch at sample v if there is one; then before() and after() are its neighbours.
  bool try_fill(Index v) {
    if (!find_dropped_fan(v)) return false;
    if (border_[v] == kNone) follow_border(v);
    if (!is_notch(v) || !make_triangle()) return false;
    is_dropped_[SurfaceMesh::face(mesh_.find_halfedge(v, before_))] = 0;
    --length_[border_[v]];
    return true;
  }
  Index before() const { return before_; }
  Index after() const { return after_; }

 private:
  bool is_sample(Index v) const { return v < static_cast<Index>(border_.size()); }
  bool is_dropped(Index h) const { return is_dropped_[SurfaceMesh::face(h)] != 0; }

  // The edges from v between dropped faces, if these are in one row that ends at samples.
  bool find_dropped_fan(Index v) {
    Index first = kNone;
    int rows = 0;
    mesh_.for_each_outgoing(v, [&](Index h) {
      if (!is_dropped(h) || is_dropped(mesh_.twin(h))) return;
      first = h;
      ++rows;
    });
    if (rows != 1) return false;
    edge_.clear();
    Index h = mesh_.rotate(first);
    for (; is_dropped(h); h = mesh_.rotate(h)) edge_.push_back(h);
    before_ = mesh_.target(first);
    after_ = mesh_.target(h);
    return before_ != after_ && is_sample(before_) && is_sample(after_);
  }

  // Marks the samples of the border that leaves v by the last fan found, counts them, and sums up
  // by how much the border turns in: a whole turn around a hole in a plane, none or less elsewhere.
  void follow_border(Index v) {
    const Index border = static_cast<Index>(length_.size());
    const Index first = mesh_.find_halfedge(v, before_);
    Index length = 0;
    double turn = 0.0;
    Index h = first;
    do {
      const Index from = mesh_.origin(h), at = mesh_.target(h);
      // On to the next edge of the outline: through the dropped faces around its far end.
      h = SurfaceMesh::next(h);
      while (is_dropped(mesh_.twin(h))) h = SurfaceMesh::next(mesh_.twin(h));
      if (is_sample(at)) border_[at] = border;
      ++length;
      const Vec3 to_before = mesh_.position[mesh_.target(h)] - mesh_.position[at],
                 to_after = mesh_.position[from] - mesh_.position[at];
      turn +=
          std::atan2(to_before.cross(to_after).dot(normal_around(at)), -to_before.dot(to_after));
    } while (h != first);
    length_.push_back(length);
    turn_.push_back(std::clamp(turn, 0.0, 2.0 * kPi));
  }

  // Of the faces that stay.
  Vec3 normal_around(Index v) const {
    Vec3 around = Vec3::Zero();
    mesh_.for_each_outgoing(v, [&](Index h) {
      if (!is_dropped(h)) around += mesh_.area_vector(SurfaceMesh::face(h));
    });
    return unit_or_zero(around);
  }

  bool is_notch(Index v) const {
    const Index border = border_[v], length = length_[border];
    if (length < kLeastSamples) return false;
    const Vec3& p = mesh_.position[v];
    const Vec3 to_before = mesh_.position[before_] - p, to_after = mesh_.position[after_] - p;
    const double longest = kLongestEdge * static_cast<double>(cloud_.local_spacing[v]);
    const double squared_lengths = to_before.squaredNorm() * to_after.squaredNorm();
    const double widest_cosine = -std::cos(kLeastTurn + turn_[border] / length);
    if (std::max({to_before.squaredNorm(), to_after.squaredNorm(),
                  (to_after - to_before).squaredNorm()}) > longest * longest ||
        !(to_before.dot(to_after) > widest_cosine * std::sqrt(squared_lengths)))
      return false;
    // A notch of more than half a turn has the other side.
    return unit_or_zero(to_before.cross(to_after)).dot(normal_around(v)) > kLeastCosine;
  }

  // Each flip takes an edge from the sample, the last one joins its two neighbours. If one is not
  // possible, those before it are undone.
  bool make_triangle() {
    std::size_t flipped = 0;
    while (flipped < edge_.size() && mesh_.is_flip_legal(edge_[flipped]))
      mesh_.flip(edge_[flipped++]);
    if (flipped == edge_.size()) return true;
    while (flipped > 0) mesh_.flip_back(edge_[--flipped]);
    return false;
  }

  SurfaceMesh& mesh_;
  const PointCloud& cloud_;
  std::vector<char>& is_dropped_;  // per face
  std::vector<Index> border_;      // per sample: the one it is on; of those with one fan
  std::vector<Index> length_;      // of each border: vertices
  std::vector<double> turn_;       // of each border: how much it turns in, at first
  std::vector<Index> edge_;        // half-edges from the sample between dropped faces, in order
  Index before_ = kNone, after_ = kNone;
};

}  // namespace

Index fill_border_notches(SurfaceMesh& mesh, const PointCloud& cloud, std::vector<char>& is_dropped,
                          Progress& progress) {
  NotchFiller filler(mesh, cloud, is_dropped);
  std::vector<Index> pending = filler.samples_at_borders(), next;
  Index filled = 0;
  // Every triangle made takes a sample off the border: this comes to an end.
  for (; !pending.empty(); pending.swap(next)) {
    sort_unique(pending);
    next.clear();
    for (std::size_t i = 0; i < pending.size(); ++i) {
      if (i % kProgressStride == 0) progress.update(0.0);
      if (!filler.try_fill(pending[i])) continue;
      ++filled;
      next.push_back(filler.before());
      next.push_back(filler.after());
    }
  }
  return filled;
}

}  // namespace shrinkwrap
