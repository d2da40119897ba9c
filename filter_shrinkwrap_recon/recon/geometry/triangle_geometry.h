// Small geometry of triangles and hinges, for the inner loops of re-tiling and edge optimisation.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/types.h"

namespace shrinkwrap {

constexpr double kHalfPi = 0.5 * kPi;

/// The vector at unit length; zero stays zero.
inline Vec3 unit_or_zero(const Vec3& vector) {
  const double length = vector.norm();
  return length > 0.0 ? Vec3(vector / length) : Vec3(0.0, 0.0, 0.0);
}

inline double longest_edge(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

/// Height of a triangle over its longest edge, as a part of that; 0 for a degenerate one.
inline double relative_height(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest > 0.0 ? (b - a).cross(c - a).norm() / longest : 0.0;
}

/// 1 for a triangle with an edge of no length.
inline double cosine_of_smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  // It lies opposite to the shortest edge.
  std::array<double, 3> squared = {(b - a).squaredNorm(), (c - b).squaredNorm(),
                                   (a - c).squaredNorm()};
  std::sort(squared.begin(), squared.end());
  if (!(squared[0] > 0.0)) return 1.0;
  return (squared[1] + squared[2] - squared[0]) / (2.0 * std::sqrt(squared[1] * squared[2]));
}

/// Arc cosine of x, clamped to [0, 1], by a polynomial: error below 2e-8 (Abramowitz and Stegun
/// 4.4.46), several times faster than the library's.
inline double arc_cosine_of_positive(double x) {
  x = std::min(std::max(x, 0.0), 1.0);
  double p = -0.0012624911;
  p = p * x + 0.0066700901;
  p = p * x - 0.0170881256;
  p = p * x + 0.0308918810;
  p = p * x - 0.0501743046;
  p = p * x + 0.0889789874;
  p = p * x - 0.2145988016;
  p = p * x + 1.5707963050;
  return std::sqrt(1.0 - x) * p;
}
/// As above on [-1, 1].
inline double arc_cosine(double x) {
  const double angle = arc_cosine_of_positive(std::abs(x));
  return x < 0.0 ? 2.0 * kHalfPi - angle : angle;
}

/// The point of a triangle nearest to a query.
struct TriangleFoot {
  double weight_b = 0.0, weight_c = 0.0;  ///< the point is a + weight_b (b - a) + weight_c (c - a)
  double squared_distance = 0.0;
};

/// The foot of p on triangle abc, by the regions of its corners, edges and inside (Ericson 2005,
/// 5.1.5). A degenerate triangle gives a point of it.
inline TriangleFoot foot_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const auto result = [&](double weight_b, double weight_c) {
    return TriangleFoot{weight_b, weight_c, (ap - weight_b * ab - weight_c * ac).squaredNorm()};
  };
  const auto part = [](double of, double whole) { return whole > 0.0 ? of / whole : 0.0; };
  const double ab_ab = ab.squaredNorm(), ab_ac = ab.dot(ac), ac_ac = ac.squaredNorm();
  const double ab_ap = ab.dot(ap), ac_ap = ac.dot(ap);
  if (ab_ap <= 0.0 && ac_ap <= 0.0) return result(0.0, 0.0);
  const double ab_bp = ab_ap - ab_ab, ac_bp = ac_ap - ab_ac;
  if (ab_bp >= 0.0 && ac_bp <= ab_bp) return result(1.0, 0.0);
  const double ab_cp = ab_ap - ab_ac, ac_cp = ac_ap - ac_ac;
  if (ac_cp >= 0.0 && ab_cp <= ac_cp) return result(0.0, 1.0);
  const double in_c = ab_ap * ac_bp - ab_bp * ac_ap;
  if (in_c <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0) return result(part(ab_ap, ab_ab), 0.0);
  const double in_b = ab_cp * ac_ap - ab_ap * ac_cp;
  if (in_b <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0) return result(0.0, part(ac_ap, ac_ac));
  const double in_a = ab_bp * ac_cp - ab_cp * ac_bp;
  const double towards_c = ac_bp - ab_bp, towards_b = ab_cp - ac_cp;
  if (in_a <= 0.0 && towards_c >= 0.0 && towards_b >= 0.0) {
    const double weight_c = part(towards_c, towards_c + towards_b);
    return result(1.0 - weight_c, weight_c);
  }
  const double sum = in_a + in_b + in_c;
  if (!(sum > 0.0)) return result(0.0, 0.0);
  return result(in_b / sum, in_c / sum);
}

/// Whether exchanging the diagonal of a hinge keeps its faces from turning away: `old_` and
/// `new_` are the unit normals before and after, `guide` any vector along the surface normal.
template <class Vector>
bool keeps_side(const Vector& old_first, const Vector& old_second, const Vector& new_first,
                const Vector& new_second, const Vector& guide) {
  using Scalar = typename Vector::Scalar;
  const Scalar length = guide.norm();
  const Scalar before = std::min(old_first.dot(guide), old_second.dot(guide));
  const Scalar after = std::min(new_first.dot(guide), new_second.dot(guide));
  const Scalar rounding = 8 * std::numeric_limits<Scalar>::epsilon();
  return after >= std::min(before, length / 2) - rounding * length;
}

}  // namespace shrinkwrap
