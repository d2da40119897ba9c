// The quadric error metric (Garland and Heckbert 1997; eq. 9-12 of the paper).
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/types.h"

namespace shrinkwrap {

/// Sum of weighted squared distances to planes, v^T Q v, as the ten distinct entries of the
/// symmetric 4x4 matrix.
class Quadric {
 public:
  /// Adds `weight` times the fundamental quadric of the plane normal . x + offset = 0 (eq. 9-10).
  /// `normal`: unit.
  void add_plane(const Vec3& normal, double offset, double weight) {
    const double a = normal.x(), b = normal.y(), c = normal.z(), d = offset;
    const double terms[10] = {a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d};
    for (int i = 0; i < 10; ++i) entry_[i] += weight * terms[i];
  }
  /// Adds `weight` times the squared distance to a point.
  void add_point(const Vec3& p, double weight) {
    for (int diagonal : {0, 4, 7}) entry_[diagonal] += weight;
    entry_[3] -= weight * p.x();
    entry_[6] -= weight * p.y();
    entry_[8] -= weight * p.z();
    entry_[9] += weight * p.squaredNorm();
  }
  Quadric& operator+=(const Quadric& other) {
    for (int i = 0; i < 10; ++i) entry_[i] += other.entry_[i];
    return *this;
  }
  /// The cost of a position (eq. 12); never negative.
  double cost(const Vec3& p) const {
    const double x = p.x(), y = p.y(), z = p.z();
    const auto& q = entry_;
    return std::max(0.0, x * (q[0] * x + 2.0 * (q[1] * y + q[2] * z + q[3])) +
                             y * (q[4] * y + 2.0 * (q[5] * z + q[6])) +
                             z * (q[7] * z + 2.0 * q[8]) + q[9]);
  }
  /// The position of least cost for the contraction of an edge; the best of both ends and the
  /// middle where the quadric determines none, or one more than twice the edge away from its
  /// middle.
  Vec3 best_position(const Vec3& a, const Vec3& b) const {
    const auto& q = entry_;
    Eigen::Matrix3d matrix;
    matrix << q[0], q[1], q[2], q[1], q[4], q[5], q[2], q[5], q[7];
    const Vec3 middle = 0.5 * (a + b);
    const double trace = matrix.trace();
    Eigen::Matrix3d inverse;
    double determinant = 0.0;
    bool invertible = false;
    matrix.computeInverseAndDetWithCheck(inverse, determinant, invertible,
                                         1e-4 * trace * trace * trace);
    if (invertible) {
      const Vec3 best = inverse * Vec3(-q[3], -q[6], -q[8]);
      if ((best - middle).squaredNorm() <= 4.0 * (a - b).squaredNorm()) return best;
    }
    Vec3 best = middle;
    for (const Vec3& end : {a, b})
      if (cost(end) < cost(best)) best = end;
    return best;
  }

 private:
  std::array<double, 10> entry_{};  // aa ab ac ad bb bc bd cc cd dd
};

}  // namespace shrinkwrap
