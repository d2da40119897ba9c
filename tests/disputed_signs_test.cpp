#include "orientation/disputed_signs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "orientation/orientation.h"
#include "oriented_cloud.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// A grid, all but flat, of normals that look up. The forest and the signs agreed upon say so, until
// a test turns some.
class DisputedSignsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<Vec3> points;
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kWidth; ++y) points.emplace_back(x, y, 1e-4 * x * x);
    cloud_ = prepare_samples(points, SampleOptions(), silent_);
    for (Vec3f& normal : cloud_.normal) normal = Vec3f::UnitZ();
    graph_ = std::make_unique<NeighbourGraph>(cloud_, 6, silent_);
    forest_.component_of_sample.assign(points.size(), 0);
    forest_.components = 1;
    forest_.flipped.assign(points.size(), 0);
    forest_.flipped_as_agreed = forest_.flipped;
  }

  // The samples of a square of the grid.
  std::vector<Index> square(int x, int y, int width) const {
    std::vector<Index> samples;
    for (Index i = 0; i < cloud_.size(); ++i) {
      const Index point = cloud_.input_index[i];
      const int dx = point / kWidth - x, dy = point % kWidth - y;
      if (std::min(dx, dy) >= 0 && std::max(dx, dy) < width) samples.push_back(i);
    }
    return samples;
  }
  static void turn(std::vector<char>& flipped, const std::vector<Index>& samples) {
    for (const Index i : samples) flipped[i] = !flipped[i];
  }
  // All samples are seen from above but for some, which are seen from below.
  SampleVotes views(const std::vector<Index>& from_below, double closed = 1.0) const {
    SampleVotes votes;
    for (Index i = 0; i < cloud_.size(); ++i) {
      votes.drawn.push_back(i);
      votes.votes.push_back({1.0, 1.0, 0.5, closed});
    }
    for (const Index i : from_below) votes.votes[i].outward = -0.5;
    return votes;
  }
  static SampleVotes some_of(const SampleVotes& views_of_all, const std::vector<Index>& samples) {
    SampleVotes votes;
    for (const Index i : samples) {
      votes.drawn.push_back(i);
      votes.votes.push_back(views_of_all.votes[i]);
    }
    return votes;
  }
  // By views alone, whatever the edges say.
  static DisputeOptions views_alone() {
    DisputeOptions options;
    options.vote_weight = 1e6;
    options.least_border = 1e9;
    return options;
  }
  // All of which weigh 1, as the grid is flat.
  int count_edges_between_signs(const std::vector<char>& flipped) const {
    int edges = 0;
    for (Index i = 0; i < cloud_.size(); ++i)
      graph_->for_each_edge_of(i, [&](Index j) { edges += flipped[i] != flipped[j]; });
    return edges;
  }
  DisputedSigns disputed() { return DisputedSigns(*graph_, forest_, silent_); }
  std::vector<char> find_turned(const SampleVotes& votes,
                                const DisputeOptions& options = DisputeOptions()) {
    return disputed().find_turned(votes, 0.15, options);
  }

  static constexpr int kWidth = 30;
  Progress silent_;
  PointCloud cloud_;
  std::unique_ptr<NeighbourGraph> graph_;
  SpanningForest forest_;
};

TEST_F(DisputedSignsTest, SetsAreTheConnectedSamplesThatDiffer) {
  EXPECT_EQ(disputed().count(), 0);
  const std::vector<Index> near = square(3, 3, 5), far = square(20, 20, 4);
  turn(forest_.flipped_as_agreed, near);
  turn(forest_.flipped_as_agreed, far);
  for (const bool are_opposite : {false, true}) {
    SCOPED_TRACE(are_opposite);
    if (are_opposite)
      for (char& flipped : forest_.flipped_as_agreed) flipped = !flipped;
    const DisputedSigns sets = disputed();
    ASSERT_EQ(sets.count(), 2);
    EXPECT_NE(sets.set_of(near[0]), sets.set_of(far[0]));
    Index in_sets = 0;
    for (Index i = 0; i < cloud_.size(); ++i) in_sets += sets.set_of(i) != kNone;
    EXPECT_EQ(in_sets, 25 + 16);
    for (const Index i : near) EXPECT_EQ(sets.set_of(i), sets.set_of(near[0]));
    for (const Index i : far) EXPECT_EQ(sets.set_of(i), sets.set_of(far[0]));
  }
}

TEST_F(DisputedSignsTest, SetsOfTwoComponentsAreTwo) {
  const std::vector<Index> left = square(10, 10, 4), right = square(14, 10, 4);
  turn(forest_.flipped_as_agreed, left);
  turn(forest_.flipped_as_agreed, right);
  EXPECT_EQ(disputed().count(), 1);
  forest_.components = 2;
  for (Index i = 0; i < cloud_.size(); ++i)
    forest_.component_of_sample[i] = cloud_.input_index[i] / kWidth >= 14;
  EXPECT_EQ(disputed().count(), 2);
  // One of them is opposite as a whole: that is the smaller one, so that more samples are alike.
  for (Index i = 0; i < cloud_.size(); ++i)
    if (forest_.component_of_sample[i] == 0)
      forest_.flipped_as_agreed[i] = !forest_.flipped_as_agreed[i];
  EXPECT_EQ(disputed().count(), 2);
  EXPECT_NE(disputed().set_of(left[0]), kNone);
}

// All edges within its component are for what the forest says of a set, those to another one,
// which looks down, are against it.
TEST_F(DisputedSignsTest, EdgesToAnotherComponentDoNotCount) {
  forest_.components = 2;
  for (Index i = 0; i < cloud_.size(); ++i) {
    const Index x = cloud_.input_index[i] / kWidth;
    forest_.component_of_sample[i] = x >= 14;
    forest_.flipped[i] = x < 14;
    forest_.flipped_as_agreed[i] = x <= 14;
  }
  EXPECT_EQ(find_turned(SampleVotes()), std::vector<char>({0}));
  DisputeOptions bold;
  bold.least_border = 1e9;
  EXPECT_EQ(find_turned(SampleVotes(), bold), std::vector<char>({0}));
}

TEST_F(DisputedSignsTest, EdgesTurnWhatContradictsThem) {
  turn(forest_.flipped, square(10, 10, 8));
  EXPECT_EQ(find_turned(SampleVotes()), std::vector<char>({1}));
}

// One is wrong in the forest, the other one is right.
TEST_F(DisputedSignsTest, SetsAreSettledOneByOne) {
  for (const bool is_first_wrong : {true, false}) {
    SCOPED_TRACE(is_first_wrong);
    SetUp();
    const std::vector<Index> one = square(3, 3, 8), other = square(18, 18, 8);
    turn(forest_.flipped, is_first_wrong ? one : other);
    turn(forest_.flipped_as_agreed, is_first_wrong ? other : one);
    const DisputedSigns sets = disputed();
    const std::vector<char> turned = sets.find_turned(views({}), 0.15, DisputeOptions());
    ASSERT_EQ(turned.size(), 2u);
    EXPECT_EQ(turned[sets.set_of(one[0])], is_first_wrong);
    EXPECT_EQ(turned[sets.set_of(other[0])], !is_first_wrong);
  }
}

// Of two sets alike, one is seen from below and the other one from above. Of two components one is
// seen from below on the whole.
TEST_F(DisputedSignsTest, ViewsOfOneSetDoNotTellOfAnother) {
  const std::vector<Index> one = square(3, 3, 8), other = square(18, 18, 8);
  turn(forest_.flipped_as_agreed, one);
  turn(forest_.flipped_as_agreed, other);
  for (const bool are_two : {false, true}) {
    SCOPED_TRACE(are_two);
    SampleVotes votes = views(one);
    if (are_two) {
      forest_.components = 2;
      for (Index i = 0; i < cloud_.size(); ++i) {
        const bool is_second = cloud_.input_index[i] / kWidth >= 15;
        forest_.component_of_sample[i] = is_second;
        if (is_second) votes.votes[i].outward = -votes.votes[i].outward;
      }
    }
    const DisputedSigns sets = disputed();
    const std::vector<char> turned = sets.find_turned(votes, 0.15, views_alone());
    ASSERT_EQ(turned.size(), 2u);
    EXPECT_TRUE(turned[sets.set_of(one[0])]);
    EXPECT_FALSE(turned[sets.set_of(other[0])]);
  }
}

// Nor does a large set that is seen from below tell of a small one, where little else is seen.
TEST_F(DisputedSignsTest, ALargeSetDoesNotCountAsTheRestOfAnother) {
  const std::vector<Index> large = square(2, 2, 12), small = square(20, 20, 4);
  turn(forest_.flipped_as_agreed, large);
  turn(forest_.flipped_as_agreed, small);
  std::vector<Index> seen = square(0, 0, 2);
  for (const auto& more : {square(26, 0, 4), large, small})
    seen.insert(seen.end(), more.begin(), more.end());
  const SampleVotes votes = some_of(views(large), seen);
  const DisputedSigns sets = disputed();
  const std::vector<char> turned = sets.find_turned(votes, 0.15, views_alone());
  EXPECT_TRUE(turned[sets.set_of(large[0])]);
  EXPECT_FALSE(turned[sets.set_of(small[0])]);
}

// Where the undisputed rest is seen from nowhere, it can as well be turned instead.
TEST_F(DisputedSignsTest, ViewsOfASetAloneDoNotTurnIt) {
  const std::vector<Index> set = square(8, 8, 12);
  turn(forest_.flipped_as_agreed, set);
  turn(forest_.flipped, square(8, 8, 2));  // some edges are against it
  turn(forest_.flipped_as_agreed, square(8, 8, 2));
  const SampleVotes votes = views(set);
  const DisputedSigns sets = disputed();
  const Index main_set = sets.set_of(square(15, 15, 1)[0]);
  EXPECT_TRUE(sets.find_turned(votes, 0.15, views_alone())[main_set]);
  EXPECT_FALSE(sets.find_turned(some_of(votes, set), 0.15, views_alone())[main_set]);
}

// All edges are against what the forest says of a set, and views are for it. The heavier side wins,
// be all samples drawn or, of the rest, a quarter.
TEST_F(DisputedSignsTest, ViewsMayOutweighEdges) {
  const std::vector<Index> set = square(8, 8, 12);
  turn(forest_.flipped, set);
  const int edges = count_edges_between_signs(forest_.flipped);
  const SampleVotes all = views(set);
  for (const bool are_all_drawn : {true, false}) {
    SCOPED_TRACE(are_all_drawn);
    std::vector<Index> drawn = set;
    for (Index i = 0; i < cloud_.size(); ++i)
      if ((are_all_drawn || i % 4 == 0) && std::find(set.begin(), set.end(), i) == set.end())
        drawn.push_back(i);
    const SampleVotes votes = some_of(all, drawn);
    const double majorities = 0.5 * static_cast<double>(set.size());
    const double balance = edges / (majorities * cloud_.size() / static_cast<double>(drawn.size()));
    DisputeOptions options;
    options.preference = 1.0;
    options.vote_weight = 0.98 * balance;
    EXPECT_EQ(find_turned(votes, options), std::vector<char>({1}));
    options.vote_weight = 1.02 * balance;
    EXPECT_EQ(find_turned(votes, options), std::vector<char>({0}));
  }
}

// It does not matter how the normals looked before the forest turned them, neither to edges nor,
// where these do not object, to views.
TEST_F(DisputedSignsTest, NormalsMayHaveAnySigns) {
  const std::vector<Index> one = square(3, 3, 8), other = square(18, 18, 8);
  for (const bool by_views : {false, true}) {
    SCOPED_TRACE(by_views);
    SetUp();
    turn(by_views ? forest_.flipped_as_agreed : forest_.flipped, one);
    turn(forest_.flipped_as_agreed, other);
    SampleVotes votes = views(by_views ? one : std::vector<Index>());
    const DisputeOptions options = by_views ? views_alone() : DisputeOptions();
    Random random(1);
    for (Index i = 0; i < cloud_.size(); ++i)
      if (random.uniform() < 0.5) {
        cloud_.normal[i] = -cloud_.normal[i];
        turn(forest_.flipped, {i});
        turn(forest_.flipped_as_agreed, {i});
        votes.votes[i] = votes.votes[i].turned();
      }
    const DisputedSigns sets = disputed();
    ASSERT_EQ(sets.count(), 2);
    const std::vector<char> turned = sets.find_turned(votes, 0.15, options);
    EXPECT_TRUE(turned[sets.set_of(one[0])]);
    EXPECT_FALSE(turned[sets.set_of(other[0])]);
  }
}

// However many there are, and from wherever the rest is seen.
TEST_F(DisputedSignsTest, ViewsTurnNothingAgainstNearlyAllEdges) {
  const std::vector<Index> below = square(8, 8, 12);
  turn(forest_.flipped_as_agreed, below);
  DisputeOptions sure_views;
  sure_views.vote_weight = 1e6;
  DisputeOptions bold = sure_views, contacts = sure_views;
  bold.most_objections = 1e9;
  contacts.least_border = 1e9;
  SampleVotes votes = views(below);
  for (const bool is_mirrored : {false, true}) {
    SCOPED_TRACE(is_mirrored);
    if (is_mirrored)
      for (VisibilityVote& vote : votes.votes) vote = vote.turned();
    EXPECT_EQ(find_turned(votes, sure_views), std::vector<char>({0}));
    EXPECT_EQ(find_turned(votes, contacts), std::vector<char>({1}));
    turn(forest_.flipped, square(8, 8, 1));  // so that some edges are against it already
    EXPECT_EQ(find_turned(votes, bold), std::vector<char>({1}));
    turn(forest_.flipped, square(8, 8, 1));
  }
}

// A border that weighs less than so many times the root of the samples does not object.
TEST_F(DisputedSignsTest, TheLeastBorderIsByTheRootOfTheSamples) {
  const std::vector<Index> below = square(8, 8, 12);
  turn(forest_.flipped_as_agreed, below);
  const int edges = count_edges_between_signs(forest_.flipped_as_agreed);
  DisputeOptions options;
  options.vote_weight = 1e6;
  options.least_border = 0.98 * edges / 12.0;
  EXPECT_EQ(find_turned(views(below), options), std::vector<char>({0}));
  options.least_border = 1.02 * edges / 12.0;
  EXPECT_EQ(find_turned(views(below), options), std::vector<char>({1}));
}

TEST_F(DisputedSignsTest, ViewsOfAnOpenSheetTellNothing) {
  const std::vector<Index> below = square(8, 8, 12);
  turn(forest_.flipped_as_agreed, below);
  EXPECT_EQ(find_turned(views(below, 1.0), views_alone()), std::vector<char>({1}));
  EXPECT_EQ(find_turned(views(below, 0.0), views_alone()), std::vector<char>({0}));
}

TEST_F(DisputedSignsTest, UnclearVotesDoNotCount) {
  const std::vector<Index> below = square(8, 8, 12);
  turn(forest_.flipped_as_agreed, below);
  const SampleVotes votes = views(below);
  EXPECT_EQ(disputed().find_turned(votes, 0.4, views_alone()), std::vector<char>({1}));
  EXPECT_EQ(disputed().find_turned(votes, 0.6, views_alone()), std::vector<char>({0}));
}

// The edges of one sample, half of which contradict either sign.
TEST_F(DisputedSignsTest, WhatWasAgreedUponIsPreferredInDoubt) {
  const Index sample = square(15, 15, 1)[0];
  std::vector<Index> ends;
  for (Index i = 0; i < cloud_.size(); ++i)
    graph_->for_each_edge_of(i, [&](Index j) {
      if (i == sample || j == sample) ends.push_back(i == sample ? j : i);
    });
  ASSERT_GE(ends.size(), 6u);
  ends.resize(ends.size() / 2);
  turn(forest_.flipped, ends);
  turn(forest_.flipped_as_agreed, ends);
  turn(forest_.flipped_as_agreed, {sample});
  DisputeOptions options;
  EXPECT_EQ(find_turned(SampleVotes(), options), std::vector<char>({1}));
  options.preference = 0.9;
  EXPECT_EQ(find_turned(SampleVotes(), options), std::vector<char>({0}));
}

// Of a mushroom on a base that was never seen from below: views see more of the base from there
// than from above, where the hat hides it.
TEST(DisputedSigns, ABaseFacesUpUnderWhatStandsOnIt) {
  constexpr double kBase = 40.0, kStem = 5.0, kHat = 36.0, kLow = 8.0, kHigh = 14.0;
  Random random(1);
  std::vector<Vec3> points, outward;
  const auto add = [&](double radius, double z, const Vec3& normal) {
    const double angle = random.uniform(0.0, 2.0 * kPi);
    const Vec3 way(std::cos(angle), std::sin(angle), 0.0);
    points.push_back(radius * way + Vec3(0.0, 0.0, z));
    outward.push_back(normal.isZero() ? way : normal);
  };
  const auto add_ring = [&](double inner, double outer, double z, double side) {
    for (double k = kPi * (outer * outer - inner * inner); k > 0.0; --k)
      add(std::sqrt(random.uniform(inner * inner, outer * outer)), z, side * Vec3::UnitZ());
  };
  const auto add_wall = [&](double radius, double low, double high) {
    for (double k = 2.0 * kPi * radius * (high - low); k > 0.0; --k)
      add(radius, random.uniform(low, high), Vec3::Zero());
  };
  add_ring(kStem, kBase, 0.0, 1.0);
  add_wall(kStem, 0.0, kLow);
  add_ring(kStem, kHat, kLow, -1.0);
  add_wall(kHat, kLow, kHigh);
  add_ring(0.0, kHat, kHigh, 1.0);
  const auto count_wrong = [&](const OrientationOptions& options) {
    PointCloud cloud = prepared_cloud(points);
    Progress silent;
    orient_normals(cloud, options, silent);
    Index wrong = 0;
    for (Index i = 0; i < cloud.size(); ++i)
      wrong += outward[cloud.input_index[i]].dot(cloud.normal[i].cast<double>()) < -0.3;
    return wrong;
  };
  OrientationOptions options;
  options.least_ground = 2.0;  // views from above the base alone come after that
  EXPECT_LT(count_wrong(options), 100);
  options.disputes.most_objections = 1e9;
  EXPECT_GT(count_wrong(options), 3000);
}

}  // namespace
}  // namespace shrinkwrap::testing
