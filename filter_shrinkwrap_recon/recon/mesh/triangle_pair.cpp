#include "mesh/triangle_pair.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "geometry/exact_predicates.h"

namespace shrinkwrap {
namespace {

// Corners of a triangle, free to be put in another order.
using Corners = std::array<const Vec3*, 3>;
using Signs = std::array<int, 3>;
constexpr int kNextCorner[3] = {1, 2, 0};
// By the set of corners of a face that are shared, as bits: how many, and the first in cyclic
// order.
constexpr int kSharedCount[8] = {0, 1, 1, 2, 1, 2, 2, 3};
constexpr int kFirstShared[8] = {0, 0, 1, 0, 2, 2, 1, 0};

// Filter: the heights of all corners from `first` on, above the plane through `origin` with this
// normal vector, surely have one sign.
bool surely_beside_plane(const Vec3& origin, const Vec3& normal, const Corners& t, int first,
                         double error_bound) {
  double lowest = normal.dot(*t[2] - origin), highest = lowest;
  for (int i = first; i < 2; ++i) {
    const double height = normal.dot(*t[i] - origin);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  return lowest > error_bound || highest < -error_bound;
}

Vec3 normal_vector(const Corners& t) {
  return (*t[1] - *t[0]).cross(*t[2] - *t[0]);
}

// Filter for triangles of which the corners before `first` are shared: they meet nowhere else if
// one lies beside the plane of the other but for what they share.
bool surely_apart(const Corners& f, const Corners& g, int first, double error_bound) {
  return surely_beside_plane(*f[0], normal_vector(f), g, first, error_bound) ||
         surely_beside_plane(*g[0], normal_vector(g), f, first, error_bound);
}

// As before for triangles that share f[0] = g[0]; most pairs that are tested are of this kind. One
// branch, for which of the two planes separates them is anyone's guess.
bool surely_apart_but_for_corner(const Corners& f, const Corners& g, double error_bound) {
  const Vec3& apex = *f[0];
  const Vec3 f1 = *f[1] - apex, f2 = *f[2] - apex, g1 = *g[1] - apex, g2 = *g[2] - apex;
  const Vec3 f_normal = f1.cross(f2), g_normal = g1.cross(g2);
  const double hg1 = f_normal.dot(g1), hg2 = f_normal.dot(g2);
  const double hf1 = g_normal.dot(f1), hf2 = g_normal.dot(f2);
  const double highest_low = std::max(std::min(hg1, hg2), std::min(hf1, hf2));
  const double lowest_high = std::min(std::max(hg1, hg2), std::max(hf1, hf2));
  return std::max(highest_low, -lowest_high) > error_bound;
}

// The sides of the plane of t on which the corners of `other` lie.
Signs sides(const Corners& t, const Corners& other) {
  Signs sign;
  for (int i = 0; i < 3; ++i) sign[i] = orientation_sign(*t[0], *t[1], *t[2], *other[i]);
  return sign;
}

bool strictly_one_sided(const Signs& sign) {
  return sign[0] != 0 && sign[0] == sign[1] && sign[1] == sign[2];
}

// An axis along which neither of two coplanar triangles is degenerate; kNone if one of them is.
int common_projection_axis(const Corners& f, const Corners& g) {
  const int axis = projection_axis(*f[0], *f[1], *f[2]);
  const bool exists = axis != kNone && orientation_sign_2d(*g[0], *g[1], *g[2], axis) != 0;
  return exists ? axis : kNone;
}

void make_counter_clockwise(Corners& t, int axis) {
  if (orientation_sign_2d(*t[0], *t[1], *t[2], axis) < 0) std::swap(t[1], t[2]);
}

// Separating axes in the plane: two convex polygons are disjoint if and only if an edge of one has
// the other strictly outside.
bool an_edge_separates(const Corners& t, const Corners& other, int axis) {
  for (int i = 0; i < 3; ++i) {
    const Vec3 &from = *t[i], &to = *t[(i + 1) % 3];
    if (orientation_sign_2d(from, to, *other[0], axis) < 0 &&
        orientation_sign_2d(from, to, *other[1], axis) < 0 &&
        orientation_sign_2d(from, to, *other[2], axis) < 0)
      return true;
  }
  return false;
}

// Pre: a plane holds both.
bool coplanar_triangles_meet(Corners f, Corners g) {
  const int axis = common_projection_axis(f, g);
  if (axis == kNone) return false;
  make_counter_clockwise(f, axis);
  make_counter_clockwise(g, axis);
  return !an_edge_separates(f, g, axis) && !an_edge_separates(g, f, axis);
}

// Puts the corner first that the other triangle's plane cuts off from the two others, keeping the
// cyclic order. Returns true if it lies on the negative side of that plane.
// Pre: `sign` neither all zero nor strictly one-sided.
bool isolate_corner(Corners& t, const Signs& sign) {
  int positive = 0, negative = 0, any_positive = 0, any_negative = 0, any_zero = 0;
  for (int i = 0; i < 3; ++i) {
    if (sign[i] > 0) {
      ++positive;
      any_positive = i;
    } else if (sign[i] < 0) {
      ++negative;
      any_negative = i;
    } else {
      any_zero = i;
    }
  }
  int first = any_zero;  // touches the plane with this corner only
  bool below = positive == 2;
  if (positive == 1) {
    first = any_positive;
    below = false;
  } else if (negative == 1) {
    first = any_negative;
    below = true;
  }
  t = {t[first], t[(first + 1) % 3], t[(first + 2) % 3]};
  return below;
}

bool separate_triangles_meet(Corners f, Corners g) {
  const Signs g_sides = sides(f, g);
  if (strictly_one_sided(g_sides)) return false;
  const Signs f_sides = sides(g, f);
  if (strictly_one_sided(f_sides)) return false;
  const bool g_in_plane = g_sides == Signs{0, 0, 0}, f_in_plane = f_sides == Signs{0, 0, 0};
  if (g_in_plane && f_in_plane) return coplanar_triangles_meet(f, g);
  if (g_in_plane || f_in_plane) return false;  // one is degenerate
  // Both cut the common line of the two planes in an interval; the edges from the isolated corners
  // make its ends, and two signs tell whether the intervals overlap.
  const bool f_below = isolate_corner(f, f_sides), g_below = isolate_corner(g, g_sides);
  if (f_below) std::swap(g[1], g[2]);
  if (g_below) std::swap(f[1], f[2]);
  return orientation_sign(*f[1], *g[0], *f[0], *g[1]) <= 0 &&
         orientation_sign(*f[0], *g[0], *f[2], *g[2]) <= 0;
}

// A ray from `apex` through a point of the segment from -> to, against the sector that p and q span
// at the apex. Pre: `from` on the positive side of the plane (apex, p, q) or on it, `to` on the
// negative or on it, not both on it.
bool pierces_sector(const Vec3& apex, const Vec3& p, const Vec3& q, const Vec3& from,
                    const Vec3& to) {
  return orientation_sign(apex, p, from, to) <= 0 && orientation_sign(apex, q, from, to) >= 0;
}

// f[0] is g[0]. Beyond it the triangles meet only if rays from there run in both.
bool corner_sharing_triangles_meet(Corners f, Corners g) {
  const Vec3& apex = *f[0];
  const int g1 = orientation_sign(apex, *f[1], *f[2], *g[1]);
  const int g2 = orientation_sign(apex, *f[1], *f[2], *g[2]);
  if (g1 * g2 > 0) return false;
  const int f1 = orientation_sign(apex, *g[1], *g[2], *f[1]);
  const int f2 = orientation_sign(apex, *g[1], *g[2], *f[2]);
  if (f1 * f2 > 0) return false;
  const bool g_in_plane = g1 == 0 && g2 == 0, f_in_plane = f1 == 0 && f2 == 0;
  if (g_in_plane && f_in_plane) {
    const int axis = common_projection_axis(f, g);
    if (axis == kNone) return false;
    make_counter_clockwise(f, axis);
    make_counter_clockwise(g, axis);
    const auto in_sector = [&](const Corners& t, const Vec3& p) {
      return orientation_sign_2d(apex, *t[1], p, axis) >= 0 &&
             orientation_sign_2d(apex, p, *t[2], axis) >= 0;
    };
    return in_sector(f, *g[1]) || in_sector(f, *g[2]) || in_sector(g, *f[1]) || in_sector(g, *f[2]);
  }
  if (g_in_plane || f_in_plane) return false;  // one is degenerate
  return f1 >= f2 ? pierces_sector(apex, *g[1], *g[2], *f[1], *f[2])
                  : pierces_sector(apex, *g[1], *g[2], *f[2], *f[1]);
}

// Pre: f[0], f[1] are g[0], g[1] in one order or the other. Only folded onto each other do they
// meet beyond that edge.
bool edge_sharing_triangles_meet(const Corners& f, const Corners& g) {
  if (orientation_sign(*f[0], *f[1], *f[2], *g[2]) != 0) return false;
  const int axis = common_projection_axis(f, g);
  return axis != kNone && orientation_sign_2d(*f[0], *f[1], *f[2], axis) ==
                              orientation_sign_2d(*f[0], *f[1], *g[2], axis);
}

}  // namespace

TrianglePairs::TrianglePairs(const std::vector<Vec3>& positions) : positions_(&positions) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& p : positions)
    if (p.allFinite()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  error_bound_ = orientation_error_bound(high - low);
}

bool TrianglePairs::meet(const Triangle& f, const Triangle& g) const {
  // For each corner of f one more than the corner of g that it is, 0 if it is none.
  std::array<int, 3> match;
  for (int i = 0; i < 3; ++i)
    match[i] = (f[i] == g[0] ? 1 : 0) + (f[i] == g[1] ? 2 : 0) + (f[i] == g[2] ? 3 : 0);
  const int pattern = (match[0] != 0 ? 1 : 0) + (match[1] != 0 ? 2 : 0) + (match[2] != 0 ? 4 : 0);

  const auto corners_from = [this](const Triangle& t, int first) -> Corners {
    const Vec3* position = positions_->data();
    const int second = kNextCorner[first];
    return {position + t[first], position + t[second], position + t[kNextCorner[second]]};
  };
  const int first = kFirstShared[pattern];
  const Corners s = corners_from(f, first);
  switch (kSharedCount[pattern]) {
    case 0: {
      const Corners t = corners_from(g, 0);
      return !surely_apart(s, t, 0, error_bound_) && separate_triangles_meet(s, t);
    }
    case 1: {
      const Corners t = corners_from(g, match[first] - 1);
      return !surely_apart_but_for_corner(s, t, error_bound_) &&
             corner_sharing_triangles_meet(s, t);
    }
    case 2: {
      const int g_free = 5 - match[0] - match[1] - match[2];
      const Corners t = corners_from(g, kNextCorner[g_free]);
      return !surely_beside_plane(*s[0], normal_vector(s), t, 2, error_bound_) &&
             edge_sharing_triangles_meet(s, t);
    }
    default:
      return common_projection_axis(s, corners_from(g, 0)) != kNone;
  }
}

}  // namespace shrinkwrap
