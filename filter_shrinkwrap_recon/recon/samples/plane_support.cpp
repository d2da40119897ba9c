#include "samples/plane_support.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace shrinkwrap {
namespace {

constexpr int kNearest = 8;             // neighbours through which planes are tried
constexpr float kLeastSine = 0.3f;      // of the angle in which two of them are seen
constexpr int kRefinements = 2;         // of the plane with the most support
constexpr float kDistanceDecay = 1.5f;  // of the weights: exp(-1.5 r^2), r in [0, 1]
constexpr float kOfMember = 0.3f;       // support, x nearness, at a height of one thickness

}  // namespace

PlaneSupport::PlaneSupport(Vectors offset, double thickness)
    : PlaneSupport(std::move(offset), Vectors(3, 0), thickness) {}

PlaneSupport::PlaneSupport(Vectors offset, Vectors normal, double thickness)
    : offset_(std::move(offset)),
      normal_(std::move(normal)),
      nearness_((-kDistanceDecay * offset_.square().colwise().sum()).exp()),
      per_thickness_(static_cast<float>(1.0 / thickness)) {}

PlaneSupport::Row PlaneSupport::looking_to(const Vec3f& side) const {
  Row looks = (cosines_with(side) > 0.0f).cast<float>();
  looks[0] = 1.0f;
  return looks;
}

PlaneSupport::Row PlaneSupport::support_of(const Vec3f& normal) const {
  const Row falling = (1.0f - (0.5f * per_thickness_ * heights_over(normal)).square()).max(0.0f);
  Row support = nearness_ * falling.square().square();
  if (normal_.cols() > 0) support *= looking_to(normal);
  return support;
}

int PlaneSupport::members_of(const Vec3f& normal) const {
  return static_cast<int>((support_of(normal) > kOfMember * nearness_).count());
}

float PlaneSupport::agreement_with(const Vec3f& normal) const {
  Row support = support_of(normal);
  support[0] = 0.0f;
  const float sum = support.sum();
  return sum > 0.0f ? (support * cosines_with(normal)).sum() / sum : 0.0f;
}

Vec3f PlaneSupport::normal_of_best_pair() const {
  const Eigen::Index nearest = std::min<Eigen::Index>(kNearest, offset_.cols() - 1);
  Vec3f best = Vec3f::Zero();
  float most = 0.0f;
  const auto consider = [&](const Vec3f& normal) {
    const float support = support_of(normal).sum();
    if (!(support > most)) return;
    most = support;
    best = normal;
  };
  for (Eigen::Index a = 1; a <= nearest; ++a)
    for (Eigen::Index b = a + 1; b <= nearest; ++b) {
      const Vec3f p = offset_.col(a), q = offset_.col(b), cross = p.cross(q);
      const float length = cross.norm();
      if (!(length > kLeastSine * p.norm() * q.norm())) continue;
      consider(cross / length);
      if (normal_.cols() > 0) consider(-cross / length);
    }
  return best;
}

Vec3f PlaneSupport::refined(const Vec3f& normal) const {
  const Row weight = support_of(normal);
  const float sum = weight.sum();  // the point itself has weight 1
  const Vectors weighted = offset_.rowwise() * weight;
  const Vec3f mean = weighted.rowwise().sum() / sum;
  const Eigen::Matrix3f squares =
      weighted.matrix() * offset_.matrix().transpose() - sum * mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal;
  principal.computeDirect(squares.cast<double>());
  const Vec3f fitted = principal.eigenvectors().col(0).cast<float>();
  return fitted.dot(normal) < 0.0f ? Vec3f(-fitted) : fitted;
}

Vec3f PlaneSupport::normal_of_most_support() const {
  Vec3f normal = normal_of_best_pair();
  if (normal.isZero()) return normal;
  for (int k = 0; k < kRefinements; ++k) normal = refined(normal);
  return normal;
}

}  // namespace shrinkwrap
