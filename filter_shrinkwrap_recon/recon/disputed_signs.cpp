#include "disputed_signs.h"

#include <algorithm>
#include <cmath>

#include "disjoint_sets.h"
#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;

// Of each sample, whether its sign is disputed: the fewer samples of each component that are.
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
  find_sets(disputed_samples(forest));
  if (!sets_.empty()) add_edges_at_borders(progress);
}

void DisputedSigns::find_sets(const std::vector<char>& is_disputed) {
  const Index count = graph_.sample_count();
  DisjointSets connected(count);
  for (Index i = 0; i < count; ++i) {
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
      sets_.emplace_back();
    }
    set_of_sample_[i] = set_of_sample_[first];
    ++sets_[set_of_sample_[i]].samples;
  }
}

// Those within a component: what is beyond the border of a set is not disputed.
void DisputedSigns::add_edges_at_borders(Progress& progress) {
  struct BorderEdge {
    Index set;
    double weight;
    bool is_against;
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
            const double weight = edge_weight(graph_.agreement(i, j));
            const bool is_opposed = forest_.flipped[i] != forest_.flipped[j];
            found.push_back({set, std::abs(weight), (weight < 0.0) != is_opposed});
          });
      });
  for (const BorderEdge& edge : edges)
    (edge.is_against ? sets_[edge.set].edges : sets_[edge.set].edges_turned) += edge.weight;
}

std::vector<char> DisputedSigns::find_turned(const SampleVotes& votes, double least_majority,
                                             const DisputeOptions& options) const {
  SampleVotes trusted = votes;
  trusted.weigh_by_trust(forest_.component_of_sample, forest_.components);
  const double weight = votes.weight_of_one(options.vote_weight, set_of_sample_.size());
  // Of each component, with all its sets turned: positive if views are of the side of the normals.
  std::vector<double> facing(static_cast<std::size_t>(forest_.components), 0.0);
  const auto for_each_clear_vote = [&](const auto& body) {
    for (std::size_t k = 0; k < votes.drawn.size(); ++k) {
      const double majority = trusted.votes[k].majority();
      if (std::abs(majority) >= least_majority) body(votes.drawn[k], majority);
    }
  };
  for_each_clear_vote([&](Index i, double majority) {
    const bool is_flipped = (forest_.flipped[i] != 0) != (set_of_sample_[i] != kNone);
    facing[forest_.component_of_sample[i]] += is_flipped ? -majority : majority;
  });
  struct Views {
    double against = 0.0, against_turned = 0.0;
  };
  std::vector<Views> views(sets_.size());
  for_each_clear_vote([&](Index i, double majority) {
    const Index set = set_of_sample_[i];
    const double side = facing[forest_.component_of_sample[i]];
    if (set == kNone || side == 0.0) return;
    const bool is_opposed = (majority < 0.0) != (forest_.flipped[i] != 0);
    const bool is_seen_from_behind = is_opposed == (side > 0.0);
    (is_seen_from_behind ? views[set].against : views[set].against_turned) +=
        weight * std::abs(majority);
  });
  std::vector<char> turned;
  for (Index set = 0; set < count(); ++set) {
    const auto& [samples, edges, edges_turned] = sets_[set];
    const bool do_edges_object =
        edges_turned > options.most_objections * edges +
                           options.least_border * std::sqrt(static_cast<double>(samples));
    turned.push_back(!do_edges_object && edges_turned + views[set].against_turned <
                                             options.preference * (edges + views[set].against));
  }
  return turned;
}

}  // namespace shrinkwrap
