#include "orientation/sign_agreement.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>

#include "orientation/sign_matrix.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// A grid, all but flat, whose normals have random signs: every sample a patch of its own.
class SignAgreement : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<Vec3> points;
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kWidth; ++y) points.emplace_back(x, y, 1e-4 * x * x);
    cloud_ = prepare_samples(points, SampleOptions(), silent_);
    Random random(1);
    for (Vec3f& normal : cloud_.normal)
      normal = Vec3f::UnitZ() * (random.uniform() < 0.5 ? -1.0f : 1.0f);
    patches_.count = cloud_.size();
    patches_.patch_of_sample.resize(cloud_.position.size());
    std::iota(patches_.patch_of_sample.begin(), patches_.patch_of_sample.end(), 0);
    patches_.flipped.assign(cloud_.position.size(), 0);
  }

  NeighbourGraph graph() { return NeighbourGraph(cloud_, 6, silent_); }
  // Says that a sample is seen from above.
  void see(Index sample, double majority) {
    const double up = cloud_.normal[sample].z() > 0.0f ? majority : -majority;
    votes_.drawn.push_back(sample);
    votes_.votes.push_back({1.0, 1.0, up, 1.0});
  }
  std::vector<float> signs() { return agreed_signs(graph(), patches_, votes_, 0.1, silent_); }
  Index count_downward(const std::vector<float>& signs) const {
    Index downward = 0;
    for (Index i = 0; i < cloud_.size(); ++i)
      downward += signs[patches_.patch_of_sample[i]] * (patches_.flipped[i] ? -1.0f : 1.0f) *
                      cloud_.normal[i].z() <=
                  0.0f;
    return downward;
  }
  // Flipped so that all look up.
  std::vector<char> upward() const {
    std::vector<char> flipped;
    for (const Vec3f& normal : cloud_.normal) flipped.push_back(normal.z() < 0.0f);
    return flipped;
  }

  static constexpr int kWidth = 30;
  Progress silent_;
  PointCloud cloud_;
  SignedPatches patches_;
  SampleVotes votes_;
};

TEST_F(SignAgreement, OneViewTellsTheSignsOfAll) {
  see(7, 1.0);
  EXPECT_EQ(count_downward(signs()), 0);
}

TEST_F(SignAgreement, NeighboursOutvoteViewsThatAreWrong) {
  for (Index sample = 0; sample < cloud_.size(); ++sample)
    see(sample, sample % 5 == 0 ? -0.9 : 0.9);
  EXPECT_EQ(count_downward(signs()), 0);
}

// Of two components one is closed, the other is an open sheet.
TEST_F(SignAgreement, VotesAreTrustedAsFarAsTheirComponentIsClosed) {
  SampleVotes votes;
  votes.drawn = {0, 1, 2, 3};
  votes.votes = {
      {2.0, 1.0, 0.5, 2.0}, {2.0, 1.0, -0.5, 1.8}, {2.0, 1.9, 0.5, 0.0}, {2.0, 1.9, 0.6, 0.1}};
  const std::vector<Index> component = {0, 0, 1, 1};
  EXPECT_NEAR(votes.by_component(component, 2)[1].majority(), 1.1 / 4.0, 1e-12);
  votes.weigh_by_trust(component, 2);
  const double expected[] = {0.25, -0.25, 0.0, 0.0};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(votes.votes[k].majority(), expected[k]);
}

TEST_F(SignAgreement, IsNoneWhereNoViewTells) {
  for (const float sign : signs()) EXPECT_EQ(sign, 0.0f);
}

TEST_F(SignAgreement, SamplesMayOpposeTheirPatch) {
  for (Index i = 0; i < cloud_.size(); ++i) patches_.patch_of_sample[i] = i / 100;
  patches_.count = (cloud_.size() - 1) / 100 + 1;
  patches_.flipped = upward();
  for (Index i = 0; i < 100; ++i) patches_.flipped[i] = !patches_.flipped[i];  // one upside down
  see(400, 1.0);
  const std::vector<float> result = signs();
  EXPECT_EQ(count_downward(result), 0);
  EXPECT_LT(result[0], 0.0f);
  EXPECT_GT(result[1], 0.0f);
}

TEST_F(SignAgreement, SamplesDrawnSpeakForAll) {
  see(1, 0.5);
  see(2, 0.5);
  EXPECT_EQ(votes_.weight_of_one(3.0, 100), 150.0);
  EXPECT_EQ(SampleVotes().weight_of_one(3.0, 100), 300.0);
}

TEST_F(SignAgreement, EdgesInDoubtCountForLittle) {
  EXPECT_EQ(edge_weight(1.0), 1.0);
  EXPECT_EQ(edge_weight(-0.5), -0.0625);
}

TEST(SignMatrix, MultipliesAsItsEdgesSay) {
  Eigen::Matrix3d dense = Eigen::Vector3d(0.5, 1.0, 2.0).asDiagonal();
  const std::vector<SignEdge> edges = {{0, 1, 0.75f}, {2, 1, -0.25f}, {1, 0, 0.5f}};
  for (const auto& [a, b, weight] : edges) {
    dense(a, a) += std::abs(weight);
    dense(b, b) += std::abs(weight);
    dense(a, b) -= weight;
    dense(b, a) -= weight;
  }
  const SignMatrix matrix(edges, Eigen::Vector3d(0.5, 1.0, 2.0));
  const Eigen::VectorXd x = Eigen::Vector3d(1.0, -2.0, 3.0);
  const Eigen::VectorXd product = matrix * x;
  EXPECT_TRUE(product.isApprox(dense * x));
  Eigen::ConjugateGradient<SignMatrix, Eigen::Lower | Eigen::Upper, SignPreconditioner> solver;
  solver.compute(matrix);
  EXPECT_TRUE(solver.solve(dense * x).isApprox(x, 1e-9));
}

}  // namespace
}  // namespace shrinkwrap::testing
