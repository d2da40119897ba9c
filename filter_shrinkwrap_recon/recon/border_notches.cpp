#include "border_notches.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr double kWidestCosine = -0.9;  // of a notch: beyond, the border counts as straight
constexpr double kLeastCosine = 0.7;    // between the triangle and the faces around the sample
constexpr double kLongestEdge = 4.0;    // x local spacing
constexpr Index kProgressStride = 1 << 10;

class NotchFiller {
 public:
  NotchFiller(SurfaceMesh& mesh, const PointCloud& cloud, Index first_extra)
      : mesh_(mesh), cloud_(cloud), first_extra_(first_extra) {}

  // Fills the notch at sample v if there is one; then before() and after() are its neighbours.
  bool try_fill(Index v) {
    if (!find_membrane_fan(v) || !is_notch(v)) return false;
    // Each flip takes a membrane edge from v, the last one joins the two neighbours.
    for (const Index h : edge_) {
      if (!mesh_.is_flip_legal(h)) return false;
      mesh_.flip(h);
    }
    return true;
  }
  Index before() const { return before_; }
  Index after() const { return after_; }

 private:
  bool is_extra(Index v) const { return v >= first_extra_; }

  // The edges from v to membrane vertices, if they are in a row, and the samples on either side.
  bool find_membrane_fan(Index v) {
    Index first = kNone;
    int rows = 0;
    mesh_.for_each_outgoing(v, [&](Index h) {
      if (is_extra(mesh_.target(h)) || !is_extra(mesh_.opposite(h))) return;
      first = h;
      ++rows;
    });
    if (rows != 1) return false;
    edge_.clear();
    Index h = mesh_.rotate(first);
    for (; is_extra(mesh_.target(h)); h = mesh_.rotate(h)) edge_.push_back(h);
    before_ = mesh_.target(first);
    after_ = mesh_.target(h);
    return before_ != after_;
  }

  bool is_notch(Index v) const {
    const Vec3& p = mesh_.position[v];
    const Vec3 to_before = mesh_.position[before_] - p, to_after = mesh_.position[after_] - p;
    const double longest = kLongestEdge * static_cast<double>(cloud_.local_spacing[v]);
    const double squared_lengths = to_before.squaredNorm() * to_after.squaredNorm();
    if (std::max({to_before.squaredNorm(), to_after.squaredNorm(),
                  (to_after - to_before).squaredNorm()}) > longest * longest ||
        !(to_before.dot(to_after) > kWidestCosine * std::sqrt(squared_lengths)))
      return false;
    // The faces of samples that are there: a notch of more than half a turn has the other side.
    Vec3 around = Vec3::Zero();
    mesh_.for_each_outgoing(v, [&](Index h) {
      if (!is_extra(mesh_.target(h)) && !is_extra(mesh_.opposite(h)))
        around += mesh_.area_vector(SurfaceMesh::face(h));
    });
    return unit_or_zero(to_before.cross(to_after)).dot(unit_or_zero(around)) > kLeastCosine;
  }

  SurfaceMesh& mesh_;
  const PointCloud& cloud_;
  Index first_extra_;
  std::vector<Index> edge_;  // half-edges from the sample to membrane vertices, in order
  Index before_ = kNone, after_ = kNone;
};

void sort_and_make_unique(std::vector<Index>& indices) {
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

}  // namespace

Index fill_border_notches(SurfaceMesh& mesh, const PointCloud& cloud, Index first_extra,
                          Progress& progress) {
  std::vector<Index> pending, next;
  for (Index v = first_extra; v < mesh.vertex_slots(); ++v)
    mesh.for_each_outgoing(v, [&](Index h) {
      if (mesh.target(h) < first_extra) pending.push_back(mesh.target(h));
    });
  NotchFiller filler(mesh, cloud, first_extra);
  Index filled = 0;
  // Every triangle made takes a sample off the border: this comes to an end.
  for (; !pending.empty(); pending.swap(next)) {
    sort_and_make_unique(pending);
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
