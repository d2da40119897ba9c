#include "orientation/disputed_signs.h"

#include <algorithm>
#include <cmath>

#include "common/disjoint_sets.h"
#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr Index kPollInterval = 1 << 16;  // samples

// Whether the sign of each sample is disputed. Of each component that is the smaller part: those
// that differ, or those that do not.
std::vector<char> disputed_samples(const SpanningForest& forest) {
  const std::size_t count = forest.flipped.size();
  std::vector<char> is_disputed(count);
  std::vector<Index> balance(static_cast<std::size_t>(forest.components), 0);
  for (std::size_t i = 0; i < count; ++i) {
    is_disputed[i] = forest.flipped[i] != forest.flipped_as_agreed[i];
    balance[forest.component_of_sample[i]] += is_disputed[i] ? 1 : -1;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (balance[forest.component_of_sample[i]] > 0) is_disputed[i] = !is_disputed[i];
  return is_disputed;
}

}  // namespace

DisputedSigns::DisputedSigns(const NeighbourGraph& graph, const SpanningForest& forest,
                             Progress& progress)
    : graph_(graph), forest_(forest) {
  find_sets(disputed_samples(forest), progress);
  if (!sets_.empty()) add_edges_at_borders(progress);
}

void DisputedSigns::find_sets(const std::vector<char>& is_disputed, Progress& progress) {
  const Index count = graph_.sample_count();
  DisjointSets connected(count);
  for (Index i = 0; i < count; ++i) {
    if (i % kPollInterval == 0) progress.update(0.0);
    if (!is_disputed[i]) continue;
    graph_.for_each_neighbour_of(i, [&](Index j) {
      if (is_disputed[j] && forest_.component_of_sample[i] == forest_.component_of_sample[j])
        connected.unite(i, j);
    });
  }
  set_of_sample_.assign(static_cast<std::size_t>(count), kNone);
  for (Index i = 0; i < count; ++i) {
    if (!is_disputed[i]) continue;
    const Index first = connected.find(i);  // the lowest sample of its set
    if (first == i) {
      set_of_sample_[i] = this->count();
      sets_.push_back({0, forest_.component_of_sample[i]});
    }
    set_of_sample_[i] = set_of_sample_[first];
    ++sets_[set_of_sample_[i]].samples;
  }
}

// Those within a component: what is beyond the border of a set is not disputed.
void DisputedSigns::add_edges_at_borders(Progress& progress) {
  struct BorderEdge {
    Index set;
    float weight;  // negative if it contradicts the forest
  };
  const auto edges = parallel_collect<BorderEdge>(
      graph_.sample_count(), kGrain, progress,
      [&](Index begin, Index end, std::vector<BorderEdge>& found) {
        for (Index i = begin; i < end; ++i)
          graph_.for_each_edge_of(i, [&](Index j) {
            const Index set = std::max(set_of_sample_[i], set_of_sample_[j]);
            if (set_of_sample_[i] == set_of_sample_[j] ||
                forest_.component_of_sample[i] != forest_.component_of_sample[j])
              return;
            const auto weight = static_cast<float>(edge_weight(graph_.agreement(i, j)));
            found.push_back({set, forest_.flipped[i] != forest_.flipped[j] ? -weight : weight});
          });
      });
  for (const auto& [set, weight] : edges)
    (weight < 0.0f ? sets_[set].edges : sets_[set].edges_turned) += std::abs(weight);
}

std::vector<char> DisputedSigns::find_turned(const SampleVotes& votes, double least_majority,
                                             const DisputeOptions& options) const {
  // Of clear views, those of the side of the normals, as the forest turns them, and the others.
  struct Views {
    double front = 0.0, back = 0.0;
  };
  std::vector<Views> of_undisputed(static_cast<std::size_t>(forest_.components)),
      of_set(sets_.size());
  const std::vector<VisibilityVote> sums =
      votes.by_component(forest_.component_of_sample, forest_.components);
  const double weight = votes.weight_of_one(options.vote_weight, set_of_sample_.size());
  for (std::size_t k = 0; k < votes.drawn.size(); ++k) {
    const Index i = votes.drawn[k], component = forest_.component_of_sample[i];
    const double majority = votes.votes[k].majority() * sums[component].trust();
    if (!(std::abs(majority) >= least_majority)) continue;
    Views& views = set_of(i) == kNone ? of_undisputed[component] : of_set[set_of(i)];
    const bool is_front = (majority > 0.0) != (forest_.flipped[i] != 0);
    (is_front ? views.front : views.back) += weight * std::abs(majority);
  }
  std::vector<char> turned;
  for (Index set = 0; set < count(); ++set) {
    const auto& [samples, component, edges, edges_turned] = sets_[set];
    const Views &rest = of_undisputed[component], &own = of_set[set];
    const double views = std::min(rest.front + own.front, rest.back + own.back);
    const double views_turned = std::min(rest.front + own.back, rest.back + own.front);
    const double against = edges + std::max(views - views_turned, 0.0);
    const double against_turned = edges_turned + std::max(views_turned - views, 0.0);
    const bool do_edges_object =
        edges_turned > options.most_objections * edges +
                           options.least_border * std::sqrt(static_cast<double>(samples));
    turned.push_back(!do_edges_object && against_turned < options.preference * against);
  }
  return turned;
}

}  // namespace shrinkwrap
