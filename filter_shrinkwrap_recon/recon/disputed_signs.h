// Where the signs of the spanning forest and those agreed upon differ, set by set.
#pragma once

#include <vector>

#include "neighbour_graph.h"
#include "sign_agreement.h"
#include "spanning_forest.h"

namespace shrinkwrap {

/// Nearly all edges at the border of a set object to turning it, if those that do weigh more than
/// `most_objections` times the others and, beyond that, than `least_border` times the root of its
/// samples. The border of a square of a grid weighs about sixteen times that root: a set that only
/// touches the rest is left to the views.
struct DisputeOptions {
  double vote_weight = 3.0;  ///< of the views on a sample, against edges (edge_weight)
  double preference = 3.0;   ///< a set is turned if less goes against it then than so many times
                             ///< what did: the signs agreed upon weigh all edges at once
  double most_objections = 10.0;
  double least_border = 1.0;
};

/// The signs of one choice and those of another are the same within a component, or all opposite,
/// but for sets of connected samples: the fewer samples of each component. Each set is settled by
/// itself, so that one that the forest has wrong can be turned without another one that views have
/// wrong.
class DisputedSigns {
 public:
  /// Pre: the forest is of the graph, and has signs that were agreed upon. Both are referred to.
  /// O(N) but for the union-find. Throws Cancelled.
  DisputedSigns(const NeighbourGraph& graph, const SpanningForest& forest, Progress& progress);

  Index count() const { return static_cast<Index>(sets_.size()); }
  /// The set of a sample, kNone if its sign is not disputed.
  Index set_of(Index sample) const { return set_of_sample_[sample]; }

  /// For each set, whether to turn it against what the forest says: if less goes against it then
  /// than `preference` times what does now, and not nearly all edges at its border object. Against
  /// it are the edges at its border that contradict it, and the views that see a sample of it by a
  /// majority of at least `least_majority` from behind: from another side than that from which most
  /// views see the set and the undisputed samples of its component. Views may be wrong. Of an open
  /// sheet below other things, as the base that a statue stands on, they see more from below than
  /// from above. O(N).
  std::vector<char> find_turned(const SampleVotes& votes, double least_majority,
                                const DisputeOptions& options) const;

 private:
  struct Set {
    Index samples = 0, component = 0;
    double edges = 0.0;         // at its border that contradict the forest
    double edges_turned = 0.0;  // those that would once it is turned: the others
  };

  void find_sets(const std::vector<char>& is_disputed, Progress& progress);
  void add_edges_at_borders(Progress& progress);

  const NeighbourGraph& graph_;
  const SpanningForest& forest_;
  std::vector<Index> set_of_sample_;
  std::vector<Set> sets_;
};

}  // namespace shrinkwrap
