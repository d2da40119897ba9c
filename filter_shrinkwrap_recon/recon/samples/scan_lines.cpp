#include "samples/scan_lines.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kProbes = 2000;  // at least; one neighbourhood of so many is looked at
constexpr Index kGrain = 64;
constexpr int kLeastParts = 4;    // neighbourhoods are no larger parts of the cloud
constexpr double kVolume = 0.5;   // thickness, x the width, of what is no surface either
constexpr double kMostOff = 0.5;  // of the neighbourhoods, that may be none
constexpr int kInnerPart = 4;     // of a neighbourhood, one in so many, for its growth

struct Shapes {
  double lines = 0.0, volumes = 0.0;  // parts of all neighbourhoods
  double growth = 0.0;                // the median of theirs
};

// The exponent with which the number of neighbours grows with the distance: 1 along a line, 2 on a
// surface. Without bias for samples spread at random, the j-th of which has a squared distance of a
// logarithm that grows by 1 / j to the next on average.
double growth_of(const std::vector<VoxelSearch::Hit>& hits) {
  constexpr double kAtOnce = std::numeric_limits<double>::infinity();
  if (hits.size() < 3) return kAtOnce;
  const std::size_t last = hits.size() - 1, inner = std::max<std::size_t>(last / kInnerPart, 1);
  double expected = 0.0;
  for (std::size_t j = inner; j < last; ++j) expected += 1.0 / static_cast<double>(j);
  const double squares = hits[last].squared_distance / hits[inner].squared_distance;
  return squares > 1.0 ? 2.0 * expected / std::log(squares) : kAtOnce;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Shapes shapes_of(const std::vector<Vec3>& points, const VoxelSearch& search, int neighbours,
                 const ScanLineOptions& options, Progress& progress) {
  const Index count = static_cast<Index>(points.size());
  const Index stride = std::max<Index>(count / kProbes, 1);
  const Index probes = (count + stride - 1) / stride;
  std::vector<char> is_line(static_cast<std::size_t>(probes)), is_volume(is_line.size());
  std::vector<double> growth(is_line.size());
  parallel_blocks(probes, kGrain, progress, [&](Index, Index begin, Index end) {
    std::vector<VoxelSearch::Hit> hits;
    for (Index i = begin; i < end; ++i) {
      search.k_nearest(points[i * stride], neighbours, hits);
      Vec3 mean = Vec3::Zero();
      for (const VoxelSearch::Hit& hit : hits) mean += points[hit.index];
      mean /= static_cast<double>(hits.size());
      Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
      for (const VoxelSearch::Hit& hit : hits) {
        const Vec3 offset = points[hit.index] - mean;
        scatter += offset * offset.transpose();
      }
      const Vec3 squared =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly)
              .eigenvalues();  // ascending
      const auto is_thin = [](double across, double along, double limit) {
        return across < limit * limit * along;
      };
      is_line[i] = is_thin(squared[1], squared[2], options.thinness);
      is_volume[i] = !is_thin(squared[0], squared[1], kVolume);
      growth[i] = growth_of(hits);
    }
  });
  const auto part = [&](const std::vector<char>& is) {
    return static_cast<double>(std::count(is.begin(), is.end(), 1)) / static_cast<double>(probes);
  };
  return {part(is_line), part(is_volume), median_of(std::move(growth))};
}

}  // namespace

int neighbours_across_lines(const std::vector<Vec3>& points, const VoxelSearch& search,
                            int neighbours, const ScanLineOptions& options, Progress& progress) {
  const int most =
      std::min<int>(options.most_neighbours, static_cast<int>(points.size()) / kLeastParts);
  int best = neighbours;
  for (int count = neighbours; count <= most; count *= 2) {
    const Shapes shapes = shapes_of(points, search, count, options, progress);
    if (shapes.lines > options.on_lines) continue;
    if (count > neighbours && shapes.volumes > kMostOff) break;
    if (shapes.growth >= options.least_growth) return count;
    // Few of them lie on the lines beside: taken if more do not help.
    if (best == neighbours) best = count;
  }
  return best;
}

}  // namespace shrinkwrap
