#include "judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "attempt.h"
#include "shapes.h"

namespace shrinkwrap::robustness {
namespace {

struct Brick {
  Vec3 corner;
  Vec3 size = Vec3::Ones();
  bool is_inside_out = false;
};

// Bricks along the axes, scaled after they are moved.
ResultMesh mesh_of(const std::vector<Brick>& bricks, double scale, const Vec3& offset) {
  static constexpr Index kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  ResultMesh mesh;
  for (const Brick& brick : bricks) {
    const auto first = static_cast<Index>(mesh.position.size());
    for (int i = 0; i < 8; ++i) {
      const Vec3 place(i & 1, i >> 1 & 1, i >> 2 & 1);
      mesh.position.push_back(scale * (brick.corner + place.cwiseProduct(brick.size) + offset));
    }
    for (const auto& side : kSides)
      for (const int k : {1, 2}) {
        Triangle t = {first + side[0], first + side[k], first + side[k + 1]};
        if (brick.is_inside_out) std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
      }
  }
  return mesh;
}

TEST(Judge, FindsAComponentThatIsInsideOut) {
  for (const double scale : {1e-250, 1e-12, 1.0, 1e12, 1e250})
    for (const double offset : {0.0, 1.0, 1e9}) {
      SCOPED_TRACE(std::to_string(scale) + " " + std::to_string(offset));
      const Brick brick{Vec3::Zero()}, other{Vec3(3.0, 0.0, 0.0)};
      Brick turned = other;
      turned.is_inside_out = true;
      const Vec3 far = Vec3::Constant(offset);
      EXPECT_TRUE(bounds_a_volume(mesh_of({brick, other}, scale, far)));
      EXPECT_FALSE(bounds_a_volume(mesh_of({brick, turned}, scale, far)));
    }
}

// Of samples in one plane, rounded: nobody can tell the side.
TEST(Judge, KnowsACavityFarFromTheOrigin) {
  for (const double offset : {0.0, 1e6, 1e9}) {
    SCOPED_TRACE(offset);
    const Brick brick{Vec3::Zero()};
    Brick cavity{Vec3::Constant(0.25), Vec3::Constant(0.5)};
    const Vec3 far(offset, 0.0, -10.0 * offset);
    EXPECT_FALSE(bounds_a_volume(mesh_of({brick, cavity}, 1.0, far)));
    cavity.is_inside_out = true;
    EXPECT_TRUE(bounds_a_volume(mesh_of({brick, cavity}, 1.0, far)));
  }
}

TEST(Judge, AComponentAsThinAsRoundingHasNoSide) {
  for (const bool is_inside_out : {false, true}) {
    const Brick brick{Vec3::Zero()};
    Brick thin{Vec3(3.0, 0.0, 0.0), Vec3(1.0, 1.0, 1e-16)}, plate = thin;
    thin.is_inside_out = plate.is_inside_out = is_inside_out;
    plate.size.z() = 1e-12;
    EXPECT_TRUE(bounds_a_volume(mesh_of({brick, thin}, 1.0, Vec3::Zero())));
    EXPECT_EQ(bounds_a_volume(mesh_of({brick, plate}, 1.0, Vec3::Zero())), !is_inside_out);
  }
}

// On a slow machine time is no promise.
TEST(Attempt, IsTooSlowOnlyByTheLimitAskedFor) {
  const std::vector<Vec3> points = testing::sample_shape(testing::ShapeKind::sphere, 500, 1);
  const auto is_too_slow = [&](const Checks& checks) {
    const Attempt made = attempt(points, {}, {}, checks);
    return std::count(made.verdicts.begin(), made.verdicts.end(), Verdict::too_slow) > 0;
  };
  Checks checks;
  EXPECT_FALSE(is_too_slow(checks));
  checks.time_limit = 100.0;
  EXPECT_FALSE(is_too_slow(checks));
  checks.time_limit = 1e-6;
  EXPECT_TRUE(is_too_slow(checks));
}

}  // namespace
}  // namespace shrinkwrap::robustness
