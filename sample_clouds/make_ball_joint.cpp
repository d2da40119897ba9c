// Makes ball_joint_34267.ply: a ball on a neck, and on the same body the socket for another one.
// The same bytes on every machine: nothing but the four operations and square roots is computed.
//
//   make_ball_joint OUTPUT.ply

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "ball_joint.h"
#include "shapes.h"

namespace {

using shrinkwrap::Index;
using shrinkwrap::Vec3;

constexpr Index kSamples = 34267;
constexpr std::uint64_t kSeed = 34267;

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
  using namespace shrinkwrap;
  testing::Random random(kSeed);
  const auto samples = testing::sample_implicit_blue_noise(
      sample_clouds::ball_joint, {sample_clouds::kBallJointRadius, {}}, kSamples, random);
  if (!write_ply(argv[1], samples.points)) {
    std::fprintf(stderr, "cannot write %s\n", argv[1]);
    return 1;
  }
  return 0;
}
