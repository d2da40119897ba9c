// Axis-aligned bounding box of points.
#pragma once

#include <limits>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Box& operator+=(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
    return *this;
  }
};

/// Smallest box that holds all points; low > high if there are none. O(N), parallel.
inline Box bounding_box(const std::vector<Vec3>& points) {
  Progress silent;
  return parallel_sum<Box>(static_cast<Index>(points.size()), 1 << 14, silent, Box(),
                           [&](Index begin, Index end) {
                             Box box;
                             for (Index i = begin; i < end; ++i) {
                               box.low = box.low.cwiseMin(points[i]);
                               box.high = box.high.cwiseMax(points[i]);
                             }
                             return box;
                           });
}

}  // namespace shrinkwrap
