// Makes ball_joint_34267.ply: a ball on a neck, and on the same body the socket for another one.
// The same bytes on every machine: nothing but the four operations and square roots is computed.
//
//   make_ball_joint OUTPUT.ply

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "shapes.h"

namespace {

using shrinkwrap::Index;
using shrinkwrap::Vec3;

constexpr Index kSamples = 34267;
constexpr std::uint64_t kSeed = 34267;
constexpr double kFillet = 0.1;

double smooth_union(double a, double b) {
  const double h = std::max(kFillet - std::abs(a - b), 0.0) / kFillet;
  return std::min(a, b) - 0.25 * kFillet * h * h;
}

double smooth_difference(double a, double b) {
  return -smooth_union(-a, b);
}

double across_z(const Vec3& p) {
  return std::sqrt(p.x() * p.x() + p.y() * p.y());
}

// Cylinder along z with rounded rims.
double cylinder(const Vec3& p, double radius, double low, double high, double rounding) {
  const double aside = across_z(p) - radius + rounding;
  const double along = std::max(low - p.z(), p.z() - high) + rounding;
  const double outside_aside = std::max(aside, 0.0), outside_along = std::max(along, 0.0);
  return std::sqrt(outside_aside * outside_aside + outside_along * outside_along) +
         std::min(std::max(aside, along), 0.0) - rounding;
}

// Negative inside. One body of genus 0, like the one in the paper.
double ball_joint(const Vec3& p) {
  const double ball = (p - Vec3(0.0, 0.0, 0.75)).norm() - 0.4;
  const double neck = cylinder(p, 0.2, -0.2, 0.7, 0.05);
  const double body = cylinder(p, 0.55, -0.95, 0.05, 0.06);
  const double socket = (p - Vec3(0.0, 0.0, -1.0)).norm() - 0.43;
  return smooth_difference(smooth_union(smooth_union(ball, neck), body), socket);
}

// Binary little-endian PLY of floats, whatever the byte order of the machine.
bool write_ply(const char* path, const std::vector<Vec3>& points) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(points.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) {
      const float coordinate = static_cast<float>(p[axis]);
      std::uint32_t bits;
      std::memcpy(&bits, &coordinate, sizeof bits);
      for (int shift = 0; shift < 32; shift += 8)
        bytes.push_back(static_cast<char>(bits >> shift & 0xff));
    }
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  return !file.fail();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_ball_joint OUTPUT.ply\n");
    return 2;
  }
  shrinkwrap::testing::Random random(kSeed);
  const auto samples =
      shrinkwrap::testing::sample_implicit_blue_noise(ball_joint, {1.25, {}}, kSamples, random);
  if (!write_ply(argv[1], samples.points)) {
    std::fprintf(stderr, "cannot write %s\n", argv[1]);
    return 1;
  }
  return 0;
}
