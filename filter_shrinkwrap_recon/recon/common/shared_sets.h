// Disjoint sets that several threads unite at once.
#pragma once

#include <atomic>
#include <utility>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {

/// Lowers a shared value to `candidate` if that is less. What is left after all calls is the least
/// of all candidates, whoever comes first.
inline void lower_to(std::atomic<Index>& value, Index candidate) {
  Index seen = value.load(std::memory_order_relaxed);
  while (candidate < seen &&
         !value.compare_exchange_weak(seen, candidate, std::memory_order_relaxed)) {
  }
}

/// Union-find whose links always lead to lower elements: the representative of a set is its lowest
/// element, so that sets and representatives do not depend on the order of the unions. `unite` and
/// `find` may be called from any thread. 4 bytes an element.
class SharedSets {
 public:
  SharedSets(Index count, Progress& progress) : link_(static_cast<std::size_t>(count)) {
    parallel_for_each(count, 1 << 14, progress,
                      [&](Index i) { link_[i].store(i, std::memory_order_relaxed); });
  }

  /// The representative. Halves the path: a link may be replaced by a lower one at any time.
  Index find(Index i) {
    for (;;) {
      Index up = link_[i].load(std::memory_order_relaxed);
      if (up == i) return i;
      const Index further = link_[up].load(std::memory_order_relaxed);
      if (further == up) return up;
      link_[i].compare_exchange_weak(up, further, std::memory_order_relaxed);
      i = further;
    }
  }

  void unite(Index a, Index b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      Index root = a;
      if (link_[a].compare_exchange_strong(root, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::vector<std::atomic<Index>> link_;
};

}  // namespace shrinkwrap
