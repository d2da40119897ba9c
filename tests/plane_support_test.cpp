#include "samples/plane_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace shrinkwrap::testing {
namespace {

using Vectors = PlaneSupport::Vectors;

Vectors columns(const std::vector<Vec3f>& vectors) {
  Vectors result(3, static_cast<Eigen::Index>(vectors.size()));
  for (std::size_t k = 0; k < vectors.size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) = vectors[k];
  return result;
}

// About a point on the face z = 0 that ends 0.2 before it, at the face x = 0.2, which goes down.
std::vector<Vec3f> neighbours_at_edge() {
  std::vector<Vec3f> offset = {Vec3f::Zero()};
  for (const float y : {-0.6f, -0.3f, 0.05f, 0.35f, 0.65f}) {
    offset.emplace_back(-0.25f, y, 0.0f);
    offset.emplace_back(-0.5f, y, 0.0f);
    offset.emplace_back(0.2f, y + 0.1f, -0.2f);
    offset.emplace_back(0.2f, y - 0.1f, -0.5f);
  }
  return offset;
}

TEST(PlaneSupport, IsGreatestForAFace) {
  std::vector<Vec3f> offset = neighbours_at_edge();
  offset.emplace_back(-0.4f, 0.0f, 0.07f);
  const PlaneSupport planes(columns(offset), 0.05);
  const Vec3f normal = planes.normal_of_most_support();
  EXPECT_NEAR(normal.norm(), 1.0f, 1e-6f);
  EXPECT_GT(std::abs(normal.z()), 0.999f);
  EXPECT_EQ(planes.members_of(normal), 11) << "but for what is more than a thickness above";
  EXPECT_GT(planes.support_of(normal)[21], 0.0f);
  EXPECT_FLOAT_EQ(planes.support_of(normal)[0], 1.0f);
}

// The planes of three points each that are tried leave some of a face that is not quite flat out.
TEST(PlaneSupport, IsThatOfAllMembers) {
  std::vector<Vec3f> offset = {Vec3f::Zero()};
  float height = 0.01f;
  for (const float x : {-0.5f, -0.2f, 0.2f, 0.5f})
    for (const float y : {-0.55f, -0.15f, 0.25f, 0.6f}) offset.emplace_back(x, y, height = -height);
  const PlaneSupport planes(columns(offset), 0.05);
  EXPECT_GT(std::abs(planes.normal_of_most_support().z()), 0.9999f);
}

TEST(PlaneSupport, IsOfThoseThatLookToItsSide) {
  std::vector<Vec3f> offset = neighbours_at_edge(), looks(offset.size(), Vec3f::UnitZ());
  for (std::size_t k = 0; k < offset.size(); ++k)
    if (offset[k].x() == -0.5f) looks[k] = -Vec3f::UnitZ();
  looks[0] = -Vec3f::UnitZ();
  const PlaneSupport planes(columns(offset), columns(looks), 0.05);
  const Vec3f normal = planes.normal_of_most_support();
  EXPECT_GT(normal.z(), 0.999f) << "the side of most of them";
  EXPECT_EQ(planes.members_of(normal), 6) << "five of the ten, and the point";
  EXPECT_EQ(planes.members_of(-normal), 6) << "the other five";
}

TEST(PlaneSupport, NormalsAgreeWithThePlaneOrNot) {
  const std::vector<Vec3f> offset = neighbours_at_edge();
  const auto agreement = [&](const Vec3f& looks) {
    const std::vector<Vec3f> normals(offset.size(), looks);
    return PlaneSupport(columns(offset), columns(normals), 0.05).agreement_with(Vec3f::UnitZ());
  };
  EXPECT_NEAR(agreement(Vec3f(0.0f, 0.6f, 0.8f)), 0.8f, 1e-6f);
  EXPECT_NEAR(agreement(Vec3f(0.0f, 1.0f, 0.01f).normalized()), 0.01f, 1e-4f);
  EXPECT_EQ(agreement(-Vec3f::UnitZ()), 0.0f) << "none but the point supports it";
}

TEST(PlaneSupport, IsNoneOfALine) {
  std::vector<Vec3f> offset;
  for (int k = 0; k < 9; ++k) offset.emplace_back(0.1f * static_cast<float>(k), 0.0f, 0.0f);
  EXPECT_TRUE(PlaneSupport(columns(offset), 0.05).normal_of_most_support().isZero());
  EXPECT_TRUE(PlaneSupport(columns({Vec3f::Zero()}), 0.05).normal_of_most_support().isZero());
}

}  // namespace
}  // namespace shrinkwrap::testing
