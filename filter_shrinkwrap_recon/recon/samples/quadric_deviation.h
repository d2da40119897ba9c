// How far the samples around one lie from the quadric that fits them best, and what that tells of
// noise.
#pragma once

#include <vector>

#include "samples/point_cloud.h"

namespace shrinkwrap {

/// Mean squared residuals of the samples around one, in squared local spacings, free of the bias of
/// the fit: of the nearest part of its neighbours, and of all of them. Those are counted that face
/// the same way.
struct QuadricDeviation {
  static constexpr double kUnknown = -1.0;
  /// Fewer neighbours tell nothing; fewer than 14 have no `narrow`.
  static constexpr int kLeastNeighbours = 9;
  /// Of ever more neighbours, as the noise asks for (neighbours_for_noise).
  static constexpr int kMostRounds = 4;

  double narrow = kUnknown, wide = kUnknown;
};

/// Of so many `neighbours`, the sample itself among them. Pre: `orient_normals` was called on the
/// cloud.
QuadricDeviation quadric_deviation(const PointCloud& cloud, Index sample, int neighbours);

/// Of many samples those deviations that are known, in order.
class SortedDeviations {
 public:
  void add(const QuadricDeviation& deviation);
  void sort();
  bool is_empty() const { return wide_.empty(); }
  /// Which so large a part of them is below. Pre: sorted, `part` < 1.
  QuadricDeviation at(double part) const;

 private:
  std::vector<double> narrow_, wide_;
};

/// The variance of noise of which such deviations (of so many neighbours, in the median) tell. What
/// quadrics miss of a curved surface grows with the third power of the radius of the neighbourhood,
/// its square thus with the third power of the number of samples; noise does not grow. Two sizes
/// tell them apart, whose ratio is about the same whatever their number. 0 if nothing is known.
double variance_of_noise(const QuadricDeviation& median, int neighbours);

/// Neighbourhoods that are as thick as they are wide hide a part of the noise: how many neighbours
/// it takes, at most 200.
int neighbours_for_noise(double variance);

}  // namespace shrinkwrap
