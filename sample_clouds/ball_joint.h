// The ball joint: what ball_joint_34267.ply is sampled from.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/types.h"

namespace shrinkwrap::sample_clouds {
namespace internal {

constexpr double kFillet = 0.1;

inline double smooth_union(double a, double b) {
  const double h = std::max(kFillet - std::abs(a - b), 0.0) / kFillet;
  return std::min(a, b) - 0.25 * kFillet * h * h;
}

inline double smooth_difference(double a, double b) {
  return -smooth_union(-a, b);
}

inline double across_z(const Vec3& p) {
  return std::sqrt(p.x() * p.x() + p.y() * p.y());
}

// Cylinder along z with rounded rims.
inline double cylinder(const Vec3& p, double radius, double low, double high, double rounding) {
  const double aside = across_z(p) - radius + rounding;
  const double along = std::max(low - p.z(), p.z() - high) + rounding;
  const double outside_aside = std::max(aside, 0.0), outside_along = std::max(along, 0.0);
  return std::sqrt(outside_aside * outside_aside + outside_along * outside_along) +
         std::min(std::max(aside, along), 0.0) - rounding;
}

}  // namespace internal

/// The surface lies within a ball of this radius about the origin.
constexpr double kBallJointRadius = 1.25;

/// A ball on a neck, and on the same body the socket for another one: one body of genus 0, like the
/// one in the paper. Negative inside; Lipschitz constant at most 1. Computes with nothing but the
/// four operations and square roots, which every machine rounds alike.
inline double ball_joint(const Vec3& p) {
  using namespace internal;
  const double ball = (p - Vec3(0.0, 0.0, 0.75)).norm() - 0.4;
  const double neck = cylinder(p, 0.2, -0.2, 0.7, 0.05);
  const double body = cylinder(p, 0.55, -0.95, 0.05, 0.06);
  const double socket = (p - Vec3(0.0, 0.0, -1.0)).norm() - 0.43;
  return smooth_difference(smooth_union(smooth_union(ball, neck), body), socket);
}

}  // namespace shrinkwrap::sample_clouds
