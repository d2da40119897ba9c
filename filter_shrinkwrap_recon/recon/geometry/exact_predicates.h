// Signs that are never wrong: orientation tests on double coordinates, filtered, exact when in
// doubt (CGAL).
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "common/types.h"

namespace shrinkwrap {

/// The tests of this header without their filters and shortcuts (CGAL has a filter before exact
/// arithmetic). Pre: finite coordinates.
namespace exact {
int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
int orientation_sign_2d(const Vec3& a, const Vec3& b, const Vec3& c, int dropped_axis);
}  // namespace exact

/// `orientation_sign` for where the determinant is too close to 0 to tell, as it often is of points
/// in a plane: if the plane is square to an axis, much faster than arithmetic that is exact. Right
/// for any four points. Pre: finite coordinates.
int orientation_sign_in_doubt(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Bound of the rounding error of ((b - a) x (c - a)) . (d - a) if all differences are within
/// `extent`; infinite where something might under- or overflow.
inline double orientation_error_bound(const Vec3& extent) {
  // 46 half-ulps of the product of the extents (Melquiond and Pion 2007), and a little more.
  const double bound = 5.2e-15 * extent.x() * extent.y() * extent.z();
  const bool in_range = bound > 1e-250 && extent.x() + extent.y() + extent.z() < 1e50;
  return in_range ? bound : std::numeric_limits<double>::infinity();
}

/// +1 if d lies on the side of the plane abc from which a, b, c appear counter-clockwise, -1 on the
/// other, 0 on it. Pre: finite coordinates. Some 10 ns where the sign is not close to 0.
inline int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const double determinant = ab.cross(ac).dot(ad);
  const Vec3 extent = ab.cwiseAbs().cwiseMax(ac.cwiseAbs()).cwiseMax(ad.cwiseAbs());
  const double bound = orientation_error_bound(extent);
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return orientation_sign_in_doubt(a, b, c, d);
}

/// +1 if a, b, c, projected along an axis (0 to 2) onto the other two (in cyclic order: yz, zx,
/// xy), turn counter-clockwise, -1 if clockwise, 0 if they are collinear. Pre: finite coordinates.
inline int orientation_sign_2d(const Vec3& a, const Vec3& b, const Vec3& c, int dropped_axis) {
  const int u = dropped_axis == 2 ? 0 : dropped_axis + 1, v = u == 2 ? 0 : u + 1;
  const double left = (b[u] - a[u]) * (c[v] - a[v]), right = (b[v] - a[v]) * (c[u] - a[u]);
  const double determinant = left - right;
  // Shewchuk 1997, bound A of orient2d: (3 + 16 u) u.
  const double bound = 3.4e-16 * (std::abs(left) + std::abs(right));
  if (bound > 1e-290 && bound < 1e290) {
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  if ((b[u] == a[u] && c[u] == a[u]) || (b[v] == a[v] && c[v] == a[v])) return 0;
  return exact::orientation_sign_2d(a, b, c, dropped_axis);
}

/// The axis along which a triangle may be projected without becoming degenerate, or kNone if its
/// corners are collinear. The most favourable axis where the arithmetic can tell.
int projection_axis(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace shrinkwrap
