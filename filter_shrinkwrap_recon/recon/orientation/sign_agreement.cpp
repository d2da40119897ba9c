#include "orientation/sign_agreement.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "orientation/sign_matrix.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr double kTolerance = 1e-4;  // residual, relative to the right-hand side
constexpr int kMostIterations = 300;
constexpr double kLeastDiagonal = 1e-9;  // of a patch that neither edges nor views tell about

std::vector<SignEdge> edges_between(const NeighbourGraph& graph, const SignedPatches& patches,
                                    Progress& progress) {
  return parallel_collect<SignEdge>(
      graph.sample_count(), kGrain, progress,
      [&](Index begin, Index end, std::vector<SignEdge>& edges) {
        for (Index i = begin; i < end; ++i)
          graph.for_each_edge_of(i, [&](Index j) {
            const Index a = patches.patch_of_sample[i], b = patches.patch_of_sample[j];
            if (a == b) return;
            const auto weight = static_cast<float>(edge_weight(graph.agreement(i, j)));
            edges.push_back({a, b, patches.flipped[i] != patches.flipped[j] ? -weight : weight});
          });
      });
}

}  // namespace

std::vector<VisibilityVote> SampleVotes::by_component(const std::vector<Index>& component_of_sample,
                                                      Index components) const {
  std::vector<VisibilityVote> sums(static_cast<std::size_t>(components));
  for (std::size_t k = 0; k < drawn.size(); ++k) sums[component_of_sample[drawn[k]]].add(votes[k]);
  return sums;
}

void SampleVotes::weigh_by_trust(const std::vector<Index>& component_of_sample, Index components) {
  const std::vector<VisibilityVote> sums = by_component(component_of_sample, components);
  for (std::size_t k = 0; k < drawn.size(); ++k)
    votes[k].outward *= sums[component_of_sample[drawn[k]]].trust();
}

double SampleVotes::weight_of_one(double vote_weight, std::size_t samples) const {
  return vote_weight * static_cast<double>(samples) /
         static_cast<double>(std::max<std::size_t>(drawn.size(), 1));
}

std::vector<float> agreed_signs(const NeighbourGraph& graph, const SignedPatches& patches,
                                const SampleVotes& votes, double vote_weight, Progress& progress) {
  const Eigen::Index size = patches.count;
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(size, kLeastDiagonal),
                  wanted = Eigen::VectorXd::Zero(size);
  const double weight = votes.weight_of_one(vote_weight, patches.patch_of_sample.size());
  for (std::size_t k = 0; k < votes.drawn.size(); ++k) {
    const Index i = votes.drawn[k], patch = patches.patch_of_sample[i];
    const double majority = votes.votes[k].majority();
    diagonal[patch] += weight * std::abs(majority);
    wanted[patch] += weight * (patches.flipped[i] ? -majority : majority);
  }
  const SignMatrix matrix(edges_between(graph, patches, progress), std::move(diagonal));
  Eigen::ConjugateGradient<SignMatrix, Eigen::Lower | Eigen::Upper, SignPreconditioner> solver;
  solver.setTolerance(kTolerance);
  solver.setMaxIterations(kMostIterations);
  solver.preconditioner().watch(progress, kMostIterations);
  solver.compute(matrix);
  const Eigen::VectorXd sign = solver.solve(wanted);
  std::vector<float> result(static_cast<std::size_t>(size));
  for (Index patch = 0; patch < patches.count; ++patch)
    result[patch] = std::isfinite(sign[patch]) ? static_cast<float>(sign[patch]) : 0.0f;
  return result;
}

}  // namespace shrinkwrap
