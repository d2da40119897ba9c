#include "orientation/component_shape.h"

#include <Eigen/Eigenvalues>

namespace shrinkwrap {
namespace {

// Deviation along the mean normal, x that across: of a cap of the sphere, 57 degrees from its
// middle to its rim. Such a cap has votes of less than 0.01.
constexpr double kFlat = 0.3;
// x the lesser deviation across, of what is long: less than half of a pipe has, 0.44.
constexpr double kFlatAcross = 0.4;

}  // namespace

bool ComponentShape::is_flat() const {
  const Vec3 mean = position_sum / samples, normal = normal_sum.normalized();
  const Eigen::Matrix3d variance = product_sum / samples - mean * mean.transpose();
  const double along = normal.dot(variance * normal);
  const Eigen::Matrix3d onto_plane = Eigen::Matrix3d::Identity() - normal * normal.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> across(
      onto_plane * variance * onto_plane, Eigen::EigenvaluesOnly);  // ascending, the first one 0
  return along < kFlat * kFlat * 0.5 * (variance.trace() - along) &&
         along < kFlatAcross * kFlatAcross * across.eigenvalues()[1];
}

std::vector<ComponentShape> component_shapes(const PointCloud& cloud,
                                             const SpanningForest& forest) {
  std::vector<ComponentShape> shapes(static_cast<std::size_t>(forest.components));
  for (Index i = 0; i < cloud.size(); ++i) {
    ComponentShape& shape = shapes[forest.component_of_sample[i]];
    const Vec3& p = cloud.position[i];
    ++shape.samples;
    shape.normal_sum += cloud.normal[i].cast<double>();
    shape.position_sum += p;
    shape.product_sum += p * p.transpose();
  }
  return shapes;
}

}  // namespace shrinkwrap
