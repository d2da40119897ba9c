// The neighbour graph of a cloud, along which the sides of its normals are compared.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "samples/point_cloud.h"

namespace shrinkwrap {

/// How far the samples scatter about the surface where that is evenest, x local spacing: along the
/// normals, whatever their signs. The same for any number of threads.
float scatter_of_samples(const PointCloud& cloud, Progress& progress);

/// Joins every sample with its nearest neighbours, and tells how surely two of them look to the
/// same side.
class NeighbourGraph {
 public:
  /// With the first `neighbours` neighbours of each sample, or as many as the cloud has; where the
  /// samples lie on lines (ConditioningReport::on_lines) with as many, spread from
  /// the nearest to the farthest, of which some lie on the lines beside. The cloud is referred to;
  /// its normals may be of any sign. O(N).
  NeighbourGraph(const PointCloud& cloud, int neighbours, Progress& progress);

  Index sample_count() const { return cloud_.size(); }
  int neighbours() const { return static_cast<int>(places_.size()); }
  /// See scatter_of_samples.
  float noise() const { return noise_; }

  /// Calls `body(b)` for neighbours of `a`, so that over all `a` each edge comes once.
  template <class Body>
  void for_each_edge_of(Index a, const Body& body) const {
    const Index* list = cloud_.neighbours_of(a);
    for (const int place : places_) {
      const Index b = list[place];
      if (a < b || !has_edge_to(b, a)) body(b);
    }
  }

  /// Calls `body(b)` for each neighbour that `a` is joined with as one of its own nearest.
  template <class Body>
  void for_each_neighbour_of(Index a, const Body& body) const {
    const Index* list = cloud_.neighbours_of(a);
    for (const int place : places_) body(list[place]);
  }

  /// Whether most samples that lie above each other are the ends of steps, as where terrain and
  /// roofs are seen from above and walls are not: no sheet goes on above or below the other one.
  bool has_steps() const { return has_steps_; }

  /// In [-1, 1]: the cosine between the normal of one and that of the other reflected in the plane
  /// halfway between the two samples (Xie et al. 2003). Along any arc of a circle it is 1, be it
  /// the rounded edge of a thin blade; of two sheets face to face it is -1. The cosine of the
  /// normals themselves takes both for the contrary. Noise puts neighbours above each other, too:
  /// heights are less by the noise, and the larger a part of the edge noise may be, the less sure
  /// it is. Where there are steps, the ends of one look to the same side.
  float agreement(Index a, Index b) const {
    const Edge edge = edge_between(a, b);
    if (!(edge.length > 0.0f)) return edge.cosine;
    const bool is_step = has_steps_ && edge.is_steep() && are_ends_of_step(a, b);
    const float heights = is_step ? 0.0f : edge.heights;
    return (edge.cosine - heights) * (1.0f - edge.hidden);
  }

 private:
  struct Edge {
    float length = 0.0f;
    float cosine = 1.0f;   // of the normals
    float heights = 0.0f;  // twice the product of the heights over both planes, x squared length
    float hidden = 0.0f;   // part of it that noise may be

    // More upright than level, between planes that are nearly parallel.
    bool is_steep() const {
      return std::abs(heights) > 1.0f && heights * cosine > kParallel * std::abs(heights);
    }
  };

  bool has_edge_to(Index from, Index to) const {
    const Index* list = cloud_.neighbours_of(from);
    return std::any_of(places_.begin(), places_.end(),
                       [&](int place) { return list[place] == to; });
  }

  Edge edge_between(Index a, Index b) const {
    const Vec3f d = (cloud_.position[a] - cloud_.position[b]).cast<float>();
    const Vec3f &n = cloud_.normal[a], &m = cloud_.normal[b];
    Edge edge;
    edge.length = d.norm();
    edge.cosine = n.dot(m);
    if (!(edge.length > 0.0f)) return edge;
    const float noise =
        0.5f * noise_ * (cloud_.local_spacing[a] + cloud_.local_spacing[b]) / edge.length;
    const float along_n = d.dot(n) / edge.length, along_m = d.dot(m) / edge.length;
    const auto freed = [noise](float height) {
      return std::copysign(std::max(std::abs(height) - noise, 0.0f), height);
    };
    edge.heights = 2.0f * freed(along_n) * freed(along_m);
    edge.hidden = std::min(noise, std::max(std::abs(along_n), std::abs(along_m)));
    return edge;
  }
  bool are_ends_of_step(Index a, Index b) const;
  Vec3f way_to_sheet(Index of, Index from) const;
  bool finds_steps(Progress& progress) const;

  static constexpr float kParallel = 0.8f;  // cosine of normals

  const PointCloud& cloud_;
  std::vector<int> places_;  // in the lists of neighbours, of those it joins a sample with
  float noise_ = 0.0f;       // x local spacing
  bool has_steps_ = false;
};

}  // namespace shrinkwrap
