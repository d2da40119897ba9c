#include "samples/layers.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/sort_unique.h"
#include "geometry/widest_turn.h"

namespace shrinkwrap {
namespace {

constexpr float kAcross = 0.5f;  // cosine between the axis and the normal in a layer, at least

// Whether the surface runs across the axis and the neighbours that have the same coordinate as a
// sample lie all around it: not so where they lie on a line, open or closed.
bool is_in_patch(const PointCloud& cloud, Index sample, int axis, double widest_gap) {
  if (std::abs(cloud.normal[sample][axis]) < kAcross) return false;
  const Vec3& centre = cloud.position[sample];
  const Index* neighbours = cloud.neighbours_of(sample);
  const int across = (axis + 1) % 3, up = (axis + 2) % 3;
  std::vector<double> directions;
  for (int e = 1; e < cloud.neighbour_count; ++e) {
    const Vec3& p = cloud.position[neighbours[e]];
    if (p[axis] == centre[axis])
      directions.push_back(std::atan2(p[up] - centre[up], p[across] - centre[across]));
  }
  return widest_turn(std::move(directions)) < widest_gap;
}

// Of how many values, equally frequent, two would be the same as often (Simpson's index). Pre: not
// empty.
double effective_count(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double squares = 0.0;
  for (auto begin = values.begin(); begin != values.end();) {
    const auto end = std::upper_bound(begin, values.end(), *begin);
    squares += static_cast<double>(end - begin) * static_cast<double>(end - begin);
    begin = end;
  }
  return static_cast<double>(values.size()) * static_cast<double>(values.size()) / squares;
}

// From a value to the nearest other one, infinite if there is none. Pre: `value` is among them.
double step_at(const std::vector<double>& values, double value) {
  const auto at = std::lower_bound(values.begin(), values.end(), value);
  double step = INFINITY;
  if (at != values.begin()) step = value - *(at - 1);
  if (at + 1 != values.end()) step = std::min(step, *(at + 1) - value);
  return step;
}

Layers layers_along(const PointCloud& cloud, int axis, const LayerOptions& options,
                    Progress& progress) {
  const Index stride = std::max<Index>(cloud.size() / std::max<Index>(options.probes, 1), 1);
  const Index probes = (cloud.size() + stride - 1) / stride;
  std::vector<Index> in_patch;
  for (Index i = 0; i < cloud.size(); i += stride)
    if (is_in_patch(cloud, i, axis, options.widest_gap)) in_patch.push_back(i);
  const auto is_enough = [&](std::size_t count) {
    return static_cast<double>(count) >= options.least_part * probes;
  };
  if (!is_enough(in_patch.size())) return {};
  progress.update(1.0);

  std::vector<double> values;
  values.reserve(cloud.position.size());
  for (const Vec3& p : cloud.position) values.push_back(p[axis]);
  sort_unique(values);
  std::vector<double> steps, layers;  // x local spacing; coordinates
  for (const Index i : in_patch) {
    const double value = cloud.position[i][axis];
    const double step = step_at(values, value) / static_cast<double>(cloud.local_spacing[i]);
    if (!(step >= options.least_step && step <= options.most_step)) continue;
    steps.push_back(step);
    layers.push_back(value);
  }
  if (steps.empty() || !is_enough(steps.size()) ||
      effective_count(layers) < options.least_effective_count)
    return {};
  std::sort(steps.begin(), steps.end());
  sort_unique(layers);
  return {axis, static_cast<Index>(layers.size()), steps[steps.size() / 2],
          steps[steps.size() * 4 / 5]};
}

}  // namespace

Layers find_layers(const PointCloud& cloud, const LayerOptions& options, Progress& progress) {
  Layers layers;
  if (cloud.conditioning.on_lines) return layers;
  for (int axis = 0; axis < 3 && layers.axis == kNone; ++axis)
    layers = layers_along(cloud, axis, options, progress);
  return layers;
}

}  // namespace shrinkwrap
