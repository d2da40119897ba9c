// Where the signs of the spanning forest and those agreed upon differ, set by set.
#pragma once

#include <vector>

#include "orientation/neighbour_graph.h"
#include "orientation/sign_agreement.h"
#include "orientation/spanning_forest.h"

namespace shrinkwrap {

/// Nearly all edges at the border of a set object to turning it, if those that do weigh more than
/// `most_objections` times the others plus `least_border` times the root of its samples. The border
/// of a square of a grid weighs about sixteen times that root: so views can outweigh the edges of a
/// set that only touches the rest.
struct DisputeOptions {
  double vote_weight = 3.0;  ///< of the views on a sample, against edges (edge_weight)
  double preference = 3.0;   ///< a set is turned only if what goes against it then is less than
                             ///< so many times what did before: the signs agreed upon weigh all
                             ///< edges at once
  double most_objections = 10.0;
  double least_border = 1.0;
};

/// The signs of one choice and those of another are the same within a component, or all opposite,
/// but for sets of connected samples, which together are at most half of the component. Each set is
/// settled by itself, so that one that the forest has wrong can be turned without another one that
/// views have wrong.
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
  /// it are the edges at its border that contradict it. Views that see the set and the undisputed
  /// samples of its component see most of them from one side; against it are those from the other
  /// side, as far as they are more than with the other sign. They count where the majority on a
  /// sample, times the trust in the views of its component, is at least `least_majority`. Views may
  /// be wrong: more of them see the base of a statue from below, where the scanner was not, than
  /// from above, where the statue hides it. O(N).
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
