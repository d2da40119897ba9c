// Disjoint sets, for one thread: shared_sets.h has those that several threads unite.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "common/types.h"

namespace shrinkwrap {

/// Union-find that halves paths. The representative of a set is its lowest element, so that sets
/// and representatives do not depend on the order of the unions. 4 bytes an element.
class DisjointSets {
 public:
  explicit DisjointSets(Index count) { reset(count); }

  /// Makes `count` sets of one element each.
  void reset(Index count) {
    parent_.resize(static_cast<std::size_t>(count));
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  /// The representative.
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// Returns false if the two were together already.
  bool unite(Index a, Index b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    parent_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace shrinkwrap
