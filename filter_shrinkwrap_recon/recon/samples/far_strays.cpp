#include "samples/far_strays.h"

#include <algorithm>

#include "common/parallel.h"
#include "geometry/coordinate_matches.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;
constexpr std::size_t kProbes = 4096, kLeastSamples = 64;
constexpr std::size_t kAlways = 4;  // fewer are strays, also of less than 400 points
constexpr double kTenth = 0.1;

// Every so many-th of the points, each place once: they stand for all.
std::vector<Vec3> probes_of(const std::vector<Vec3>& points, std::size_t stride) {
  std::vector<Vec3> probes;
  for (std::size_t i = 0; i < points.size(); i += stride)
    if (points[i].allFinite()) probes.push_back(points[i]);
  std::sort(probes.begin(), probes.end(), coordinates_less);
  probes.erase(std::unique(probes.begin(), probes.end()), probes.end());
  return probes;
}

// The middle of the probes, and the greatest extent of all but a tenth at either end.
struct Middle {
  Vec3 centre;
  double extent = 0.0;
};

Middle middle_of(const std::vector<Vec3>& probes) {
  Middle middle;
  std::vector<double> value(probes.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < probes.size(); ++i) value[i] = probes[i][axis];
    const auto at = [&](double part) {
      const auto place =
          value.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(value.size() - 1));
      std::nth_element(value.begin(), place, value.end());
      return *place;
    };
    middle.centre[axis] = at(0.5);
    middle.extent = std::max(middle.extent, at(1.0 - kTenth) - at(kTenth));
  }
  return middle;
}

}  // namespace

FarStrays find_far_strays(const std::vector<Vec3>& points, const FarStrayOptions& options,
                          Progress& progress) {
  progress.begin(Stage::samples);
  progress.set_range(0.0, 0.0);
  std::size_t stride = std::max<std::size_t>(points.size() / kProbes, 1);
  std::vector<Vec3> probes = probes_of(points, stride);
  if (probes.size() < kLeastSamples && stride > 1) probes = probes_of(points, stride = 1);
  if (probes.size() < kLeastSamples) return {};
  const Middle middle = middle_of(probes);
  if (!(middle.extent > 0.0)) return {};
  const double limit = options.times_extent * middle.extent;
  FarStrays strays;
  strays.all = parallel_collect<Index>(
      static_cast<Index>(points.size()), kGrain, progress,
      [&](Index begin, Index end, std::vector<Index>& far) {
        for (Index i = begin; i < end; ++i)
          if (points[i].allFinite() && (points[i] - middle.centre).cwiseAbs().maxCoeff() > limit)
            far.push_back(i);
      });
  strays.distinct = strays.all;
  std::sort(strays.distinct.begin(), strays.distinct.end(), [&](Index a, Index b) {
    const Vec3 &p = points[a], &q = points[b];
    return p == q ? a < b : coordinates_less(p, q);
  });
  strays.distinct.erase(std::unique(strays.distinct.begin(), strays.distinct.end(),
                                    [&](Index a, Index b) { return points[a] == points[b]; }),
                        strays.distinct.end());
  std::sort(strays.distinct.begin(), strays.distinct.end());
  const std::size_t most = std::min(static_cast<std::size_t>(std::max(options.most, Index{0})),
                                    std::max(probes.size() * stride / 100, kAlways));
  if (strays.distinct.size() >= most) return {};
  return strays;
}

}  // namespace shrinkwrap
