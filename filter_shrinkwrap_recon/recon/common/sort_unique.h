// Sorted vectors as sets.
#pragma once

#include <algorithm>
#include <vector>

namespace shrinkwrap {

/// Sorts the values and drops repetitions. O(n log n).
template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Whether the values, ascending, hold this one. O(log n).
template <class T>
bool holds(const std::vector<T>& ascending, const T& value) {
  return std::binary_search(ascending.begin(), ascending.end(), value);
}

}  // namespace shrinkwrap
