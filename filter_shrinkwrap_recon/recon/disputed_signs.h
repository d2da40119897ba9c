// Where the signs of the spanning forest and those agreed upon differ, set by set.
#pragma once

#include <vector>

#include "neighbour_graph.h"
#include "sign_agreement.h"
#include "spanning_forest.h"

namespace shrinkwrap {

struct DisputeOptions {
  double vote_weight = 3.0;       ///< of the views on a sample, against edges (edge_weight)
  double preference = 3.0;        ///< of the signs agreed upon, which weigh all edges at once: a
                                  ///< set is turned if less goes against it then than so many times
                                  ///< what did
  double most_objections = 10.0;  ///< of the edges at the border of a set once it is turned, x
                                  ///< those before, ...
  double least_border = 1.0;      ///< ... if they are this much more, x the root of its samples: of
                                  ///< mere contacts, views tell more
};

/// The signs of one choice and those of another are the same within a component, or all opposite,
/// but for some sets of connected samples. These are told apart, and each is settled by itself: a
/// patch whose tree hangs on a wrong edge need not be taken with one whose views are wrong.
class DisputedSigns {
 public:
  /// Pre: the forest is of the graph, and has signs that were agreed upon. Both are referred to.
  /// O(N) but for the union-find.
  DisputedSigns(const NeighbourGraph& graph, const SpanningForest& forest, Progress& progress);

  Index count() const { return static_cast<Index>(sets_.size()); }
  /// The set of a sample, kNone if its sign is not disputed.
  Index set_of(Index sample) const { return set_of_sample_[sample]; }

  /// For each set, whether it is to be turned, against what the forest says: if less then goes
  /// against it, of the edges at its border (edge_weight) and of the views that see a sample of it
  /// by a majority of at least `least_majority`, from the wrong side. But not if nearly all edges
  /// along much of its border object. An open sheet below other things, as the base that a statue
  /// stands on, is seen from below by more views than from above. O(N).
  std::vector<char> find_turned(const SampleVotes& votes, double least_majority,
                                const DisputeOptions& options) const;

 private:
  struct Set {
    Index samples = 0;
    double edges = 0.0;         // at its border that contradict the forest
    double edges_turned = 0.0;  // those that would once it is turned: the others
  };

  void find_sets(const std::vector<char>& is_disputed);
  void add_edges_at_borders(Progress& progress);

  const NeighbourGraph& graph_;
  const SpanningForest& forest_;
  std::vector<Index> set_of_sample_;
  std::vector<Set> sets_;
};

}  // namespace shrinkwrap
