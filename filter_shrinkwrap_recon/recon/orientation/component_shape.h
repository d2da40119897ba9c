// Which components of a cloud are open sheets, and which of these are flat.
#pragma once

#include <vector>

#include "orientation/spanning_forest.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

constexpr double kLeastSheetNormal =
    0.25;  ///< length of the mean normal of an open sheet, at least

/// Sums over the samples of a component of the neighbour graph, in the unit frame.
struct ComponentShape {
  Index samples = 0;
  Vec3 normal_sum = Vec3::Zero();
  Vec3 position_sum = Vec3::Zero();
  Eigen::Matrix3d product_sum = Eigen::Matrix3d::Zero();  ///< of positions with themselves

  /// What closes on itself has normals all around.
  bool is_sheet() const { return normal_sum.norm() >= kLeastSheetNormal * samples; }
  /// So flat along its mean normal that its shape makes no difference to how much is seen of
  /// either side: flatter than a cap of the sphere that reaches 57 degrees from its middle, and
  /// than half of a pipe. Pre: it is a sheet.
  bool is_flat() const;
};

/// Of each component. Pre: normals have the signs that the forest gives them. O(N).
std::vector<ComponentShape> component_shapes(const PointCloud& cloud, const SpanningForest& forest);

}  // namespace shrinkwrap
