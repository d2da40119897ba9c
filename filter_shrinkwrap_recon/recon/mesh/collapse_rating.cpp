#include "mesh/collapse_rating.h"

#include <algorithm>
#include <cmath>

#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr double kNormalWeight = 3.0;
constexpr double kTurnedWeight = 100.0;
constexpr Index kMaxFaces = 1024;      // to rate for one vertex, unless ...
constexpr Index kLeastCandidates = 8;  // ... there would be fewer candidates than this

}  // namespace

void CollapseRating::gather(const SurfaceMesh& mesh, Index v) {
  halfedge_.clear();
  neighbour_.clear();
  mesh.for_each_outgoing(v, [&](Index h) {
    halfedge_.push_back(h);
    neighbour_.push_back(mesh.target(h));
  });
}

void CollapseRating::rate(const SurfaceMesh& mesh, Index v) {
  const Index valence = static_cast<Index>(halfedge_.size());
  const Vec3& center = mesh.position[v];
  point_.clear();
  for (const Index u : neighbour_) point_.push_back(mesh.position[u]);
  Vec3 normal = Vec3::Zero();
  for (Index i = 0; i < valence; ++i)
    normal += (point_[i] - center).cross(point_[i + 1 < valence ? i + 1 : 0] - center);
  normal = unit_or_zero(normal);
  candidate_.clear();
  const Index candidates = std::max(kMaxFaces / valence, kLeastCandidates);
  const Index stride = (valence + candidates - 1) / candidates;
  for (Index i = 0; i < valence; i += stride)
    candidate_.push_back({cost_of(i, normal), halfedge_[i]});
}

CollapseRating::Candidate& CollapseRating::cheapest() {
  return *std::min_element(candidate_.begin(), candidate_.end(),
                           [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
}

// Of the fan of faces from the ring vertex `apex` that would take the place of those around v.
double CollapseRating::cost_of(Index apex, const Vec3& normal) const {
  const Index valence = static_cast<Index>(point_.size());
  const Vec3& u = point_[apex];
  double least_cosine = 1.0, largest_cotangent = -1e300;
  Index i = apex + 1 < valence ? apex + 1 : 0;
  Vec3 to_p = point_[i] - u;
  for (Index step = 2; step < valence; ++step) {
    i = i + 1 < valence ? i + 1 : 0;
    const Vec3 to_q = point_[i] - u, pq = to_q - to_p;
    const Vec3 area = to_p.cross(to_q);
    const double squared = area.squaredNorm();
    if (!(squared > 0.0)) return kTurnedCost + kTurnedWeight;
    const double inverse = 1.0 / std::sqrt(squared);
    least_cosine = std::min(least_cosine, area.dot(normal) * inverse);
    // The largest of the three cosines belongs to the smallest angle.
    const double largest_dot = std::max(std::max(to_p.dot(to_q), to_q.dot(pq)), -to_p.dot(pq));
    largest_cotangent = std::max(largest_cotangent, largest_dot * inverse);
    to_p = to_q;
  }
  const double least_angle =
      arc_cosine(largest_cotangent / std::sqrt(1.0 + largest_cotangent * largest_cotangent));
  const double cost = kNormalWeight * (1.0 - least_cosine) - least_angle;
  if (least_cosine >= kLeastCosine) return cost;
  return cost + kTurnedCost + kTurnedWeight * (kLeastCosine - least_cosine);
}

}  // namespace shrinkwrap
