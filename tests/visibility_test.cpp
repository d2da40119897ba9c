#include "orientation/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// Samples on a grid over a unit square at height z, looking up.
void add_square(PointCloud& cloud, double z, int width) {
  for (int i = 0; i < width; ++i)
    for (int j = 0; j < width; ++j) {
      cloud.position.emplace_back((i + 0.5) / width, (j + 0.5) / width, z);
      cloud.normal.push_back(Vec3f::UnitZ());
    }
}

std::vector<VisibilityVote> votes_on_all(const PointCloud& cloud, double spacing,
                                         const std::vector<Index>* component = nullptr,
                                         const Vec3& front = Vec3::Zero()) {
  VisibilityOptions options;
  options.front = front;
  options.pixel = 1.5 * spacing;
  options.depth_tolerance = 0.7 * spacing;
  std::vector<Index> drawn;
  for (Index i = 0; i < cloud.size(); ++i) drawn.push_back(i);
  Progress silent;
  return visibility_votes(cloud, drawn, options, silent, component);
}

constexpr int kWidth = 40;
constexpr Index kMiddle = kWidth * kWidth / 2 + kWidth / 2;

TEST(Visibility, BothSidesOfASheetAreSeen) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  VisibilityVote sum;
  for (const VisibilityVote& vote : votes_on_all(cloud, 1.0 / kWidth)) {
    EXPECT_GT(vote.seen, 0.97 * vote.possible);
    EXPECT_NEAR(vote.majority(), 0.0, 1e-3);
    EXPECT_EQ(vote.closed, 0.0);
    sum.add(vote);
  }
  EXPECT_EQ(sum.trust(), 0.0);
}

TEST(Visibility, FromOneSideThatSideIsSeen) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  for (const double side : {1.0, -1.0})
    for (const VisibilityVote& vote :
         votes_on_all(cloud, 1.0 / kWidth, nullptr, Vec3(0.0, 0.0, side))) {
      EXPECT_GT(vote.seen, 0.96 * vote.possible);
      EXPECT_EQ(vote.outward, side * vote.seen);
      EXPECT_EQ(vote.closed, vote.possible) << "nobody sees the other side";
    }
}

TEST(Visibility, OneSideOfEachOfTwoSheetsIsSeen) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  add_square(cloud, 0.1, kWidth);
  const std::vector<VisibilityVote> votes = votes_on_all(cloud, 1.0 / kWidth);
  for (const bool above : {false, true}) {
    const VisibilityVote& vote = votes[kMiddle + (above ? kWidth * kWidth : 0)];
    EXPECT_NEAR(vote.majority(), above ? 0.5 : -0.5, 0.02) << "half of the views, and all of these";
    EXPECT_NEAR(vote.closed, vote.possible, 1e-9);
    EXPECT_EQ(vote.turned().majority(), -vote.majority());
    EXPECT_EQ(vote.trust(), 1.0);
  }
}

// A spacing behind the foremost is within the tolerance of slanting views.
TEST(Visibility, NothingIsSeenThroughAParallelSheet) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  add_square(cloud, 1.0 / kWidth, kWidth);
  const VisibilityVote below = votes_on_all(cloud, 1.0 / kWidth)[kMiddle];
  EXPECT_NEAR(below.seen, 0.5 * below.possible, 0.02 * below.possible) << "from below";
  EXPECT_NEAR(below.majority(), -0.5, 0.02);
  // What stands square to a sheet does not hide what lies beside it.
  for (Index i = kWidth * kWidth; i < cloud.size(); ++i) cloud.normal[i] = Vec3f::UnitX();
  EXPECT_GT(votes_on_all(cloud, 1.0 / kWidth)[kMiddle].seen, 0.55 * below.possible);
}

// The sheet in front is bent otherwise where a slanting view meets it.
TEST(Visibility, NothingIsSeenThroughACorrugatedWall) {
  constexpr double kSpacing = 1.0 / kWidth, kHeight = 1.4 * kSpacing;
  constexpr double kPerLength = 2.0 * kPi / (20.0 * kSpacing);  // of the phase
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  add_square(cloud, 3.0 * kSpacing, kWidth);
  for (Index i = 0; i < cloud.size(); ++i) {
    Vec3& p = cloud.position[i];
    const double phase = kPerLength * p.x();
    p.z() += kHeight * std::sin(phase);
    const Vec3 normal(-kHeight * kPerLength * std::cos(phase), 0.0, 1.0);
    cloud.normal[i] = normal.normalized().cast<float>();
  }
  const std::vector<VisibilityVote> votes = votes_on_all(cloud, kSpacing);
  VisibilityVote below;
  for (Index i = 0; i < kWidth * kWidth; ++i)
    if ((cloud.position[i] - Vec3(0.5, 0.5, 0.0)).head<2>().cwiseAbs().maxCoeff() < 0.25)
      below.add(votes[i]);
  EXPECT_GT(below.seen, 0.4 * below.possible);
  EXPECT_NEAR(below.outward, -below.seen, 1e-3 * below.possible) << "from below alone";
}

TEST(Visibility, ABentSheetDoesNotHideItself) {
  PointCloud cloud;
  for (const Vec3& p : sample_shape_blue_noise(ShapeKind::sphere, 320, 1)) {
    cloud.position.push_back(p);
    cloud.normal.push_back(p.cast<float>());
  }
  VisibilityVote sum;
  for (const VisibilityVote& vote : votes_on_all(cloud, 0.2)) sum.add(vote);
  EXPECT_GT(sum.seen, 0.49 * sum.possible) << "from its side of the world";
  EXPECT_GT(sum.majority(), 0.48);
}

// Nearer than the noise that each sheet may have, they are told apart by their components alone.
TEST(Visibility, TellsWhatIsSeenThroughAnotherComponent) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  add_square(cloud, 0.5 / kWidth, kWidth);
  std::vector<Index> component(cloud.position.size(), 7);
  const auto below = [&](const std::vector<Index>* of_sample) {
    return votes_on_all(cloud, 1.0 / kWidth, of_sample)[kMiddle];
  };
  const VisibilityVote without = below(nullptr), within = below(&component);
  EXPECT_GT(without.seen, 0.95 * without.possible);
  EXPECT_EQ(without.foremost, without.seen);
  EXPECT_EQ(within.foremost, within.seen);
  std::fill(component.begin(), component.begin() + kWidth * kWidth, 3);
  const VisibilityVote behind = below(&component);
  EXPECT_EQ(behind.seen, without.seen);
  EXPECT_NEAR(behind.foremost, 0.5 * behind.possible, 0.02 * behind.possible) << "from below";
}

// A roof hides the front of the ground below it from many views, and nothing hides the back.
TEST(Visibility, VotesCountLessWhereBothSidesAreSeen) {
  PointCloud cloud;
  add_square(cloud, 0.0, kWidth);
  const Index ground = cloud.size();
  for (const Vec3& p : std::vector<Vec3>(cloud.position)) {
    if ((p - Vec3(0.5, 0.5, 0.0)).cwiseAbs().maxCoeff() > 0.15) continue;
    cloud.position.push_back(p + Vec3(0.0, 0.0, 0.35));
    cloud.normal.push_back(Vec3f::UnitZ());
  }
  const std::vector<VisibilityVote> votes = votes_on_all(cloud, 1.0 / kWidth);
  const VisibilityVote& below = votes[kMiddle];
  const double hidden = (below.possible - below.seen) / below.possible;
  EXPECT_GT(hidden, 0.05);
  EXPECT_LT(below.majority(), 0.0);
  EXPECT_GT(below.majority(), -0.5 * hidden) << "less than the part that is hidden";
  EXPECT_EQ(below.closed, 0.0) << "it is seen from a quarter of the views";
  VisibilityVote sum;
  for (Index i = 0; i < ground; ++i) sum.add(votes[i]);
  EXPECT_EQ(sum.trust(), 0.0);
}

}  // namespace
}  // namespace shrinkwrap::testing
