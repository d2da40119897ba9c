#include "geometry/exact_predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace shrinkwrap {
namespace {

// A number of twice the digits: the sum of two, the lower at most half a last place of the higher.
// Algorithms and error bounds: Joldes, Muller and Popescu 2017, "Tight and rigorous error bounds
// for basic building blocks of double-word arithmetic".
struct DoubleDouble {
  double high, low;
};

// Exact.
DoubleDouble sum_of(double a, double b) {
  const double sum = a + b, b_in_sum = sum - a;
  return {sum, (a - (sum - b_in_sum)) + (b - b_in_sum)};
}

// Exact. Pre: |a| >= |b|, or a = 0.
DoubleDouble sum_of_ordered(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

// Relative error 3 u^2, where u = 2^-53.
DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble high = sum_of(a.high, b.high), low = sum_of(a.low, b.low);
  const DoubleDouble sum = sum_of_ordered(high.high, high.low + low.high);
  return sum_of_ordered(sum.high, low.low + sum.low);
}

DoubleDouble operator-(const DoubleDouble& a) {
  return {-a.high, -a.low};
}

// Relative error 7 u^2.
DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double product = a.high * b.high, rest = std::fma(a.high, b.high, -product);
  return sum_of_ordered(product, rest + (a.high * b.low + a.low * b.high));
}

// The sign of the determinant of `orientation_sign` by twice the digits, 0 if they do not tell.
int sign_of_twice_the_digits(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<DoubleDouble, 3> ab, ac, ad;
  Vec3 extent;
  for (int i = 0; i < 3; ++i) {
    ab[i] = sum_of(b[i], -a[i]);
    ac[i] = sum_of(c[i], -a[i]);
    ad[i] = sum_of(d[i], -a[i]);
    extent[i] = std::max({std::abs(ab[i].high), std::abs(ac[i].high), std::abs(ad[i].high)});
  }
  const auto minor = [&](int u, int v) { return ab[u] * ac[v] + -(ab[v] * ac[u]); };
  const DoubleDouble determinant = minor(1, 2) * ad[0] + minor(2, 0) * ad[1] + minor(0, 1) * ad[2];
  // Each of six products of three is off by (7 + 3 + 7 + 6) u^2 at most, together less than this
  // part of the bound for plain arithmetic, which is infinite where something might underflow.
  const double bound = 4e-16 * orientation_error_bound(extent);
  if (determinant.high > bound) return 1;
  return determinant.high < -bound ? -1 : 0;
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 to_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

namespace exact {

int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return static_cast<int>(CGAL::orientation(to_point(a), to_point(b), to_point(c), to_point(d)));
}

int orientation_sign_2d(const Vec3& a, const Vec3& b, const Vec3& c, int dropped_axis) {
  const int u = (dropped_axis + 1) % 3, v = (dropped_axis + 2) % 3;
  const auto project = [u, v](const Vec3& p) { return Kernel::Point_2(p[u], p[v]); };
  return static_cast<int>(CGAL::orientation(project(a), project(b), project(c)));
}

}  // namespace exact

int orientation_sign_in_doubt(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Of three points in a plane across an axis: the side on which the fourth lies, x the sense in
  // which they turn.
  const auto sign_of = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& fourth,
                          int axis) {
    const double plane = p[axis], height = fourth[axis];
    if (height == plane) return 0;
    const int turn = orientation_sign_2d(p, q, r, axis);
    return height > plane ? turn : -turn;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const bool ab = a[axis] == b[axis], ac = a[axis] == c[axis], cd = c[axis] == d[axis];
    if (ab && ac) return sign_of(a, b, c, d, axis);
    if (ab && a[axis] == d[axis]) return -sign_of(a, b, d, c, axis);
    if (ac && cd) return sign_of(a, c, d, b, axis);
    if (cd && b[axis] == c[axis]) return -sign_of(b, c, d, a, axis);
  }
  const int sign = sign_of_twice_the_digits(a, b, c, d);
  return sign != 0 ? sign : exact::orientation_sign(a, b, c, d);
}

int projection_axis(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a).cwiseAbs();
  int best = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (normal[axis] > normal[best]) best = axis;
  for (int i = 0; i < 3; ++i) {
    const int axis = (best + i) % 3;
    if (orientation_sign_2d(a, b, c, axis) != 0) return axis;
  }
  return kNone;
}

}  // namespace shrinkwrap
