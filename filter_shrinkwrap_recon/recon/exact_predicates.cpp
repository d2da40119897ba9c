#include "exact_predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace shrinkwrap {
namespace {

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
  return exact::orientation_sign(a, b, c, d);
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
