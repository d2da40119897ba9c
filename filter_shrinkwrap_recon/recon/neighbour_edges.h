// The neighbour graph of a cloud, along which the sides of its normals are compared.
#pragma once

#include <algorithm>
#include <cmath>

#include "point_cloud.h"

namespace shrinkwrap {

/// Tells how surely two neighbours look to the same side, in [-1, 1]: the cosine between the normal
/// of one and that of the other reflected in the plane halfway between the two samples (Xie et al.
/// 2003). Along any arc of a circle it is 1, be it the rounded edge of a thin blade; of two sheets
/// face to face it is -1. The cosine of the normals themselves takes both for the contrary. Noise
/// puts neighbours above each other, too: heights are less by what the evenest tenth of the samples
/// deviates from planes.
class SideAgreement {
 public:
  explicit SideAgreement(const PointCloud& cloud);

  float operator()(Index a, Index b) const {
    const Vec3f d = (cloud_.position[a] - cloud_.position[b]).cast<float>();
    const Vec3f &n = cloud_.normal[a], &m = cloud_.normal[b];
    const float squared = d.squaredNorm();
    const float least = 0.5f * noise_ * (cloud_.local_spacing[a] + cloud_.local_spacing[b]);
    const auto freed = [&](float height) {
      return std::copysign(std::max(std::abs(height) - least, 0.0f), height);
    };
    const float reflected =
        squared > 0.0f ? 2.0f * freed(d.dot(n)) * freed(d.dot(m)) / squared : 0.0f;
    return n.dot(m) - reflected;
  }

 private:
  const PointCloud& cloud_;
  float noise_ = 0.0f;  // x local spacing
};

/// Calls `body(b)` for neighbours of `a`, so that over all `a` each edge comes once. The graph
/// joins every sample with its first `neighbours` neighbours. Pre: fewer than
/// `cloud.neighbour_count`.
template <class Body>
void for_each_edge_of(const PointCloud& cloud, int neighbours, Index a, const Body& body) {
  const Index* list = cloud.neighbours_of(a);
  for (int place = 1; place <= neighbours; ++place) {
    const Index b = list[place];
    const Index* back = cloud.neighbours_of(b);
    const bool has_it_too = std::find(back + 1, back + 1 + neighbours, a) != back + 1 + neighbours;
    if (a < b || !has_it_too) body(b);
  }
}

}  // namespace shrinkwrap
