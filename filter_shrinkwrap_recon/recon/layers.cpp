#include "layers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sort_unique.h"

namespace shrinkwrap {
namespace {

// Whether the neighbours that have the same coordinate as a sample lie on a patch, not on a line.
bool is_in_patch(const PointCloud& cloud, Index sample, int axis, double thinness) {
  const Vec3& centre = cloud.position[sample];
  const Index* neighbours = cloud.neighbours_of(sample);
  const int across = (axis + 1) % 3, up = (axis + 2) % 3;
  int beside = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (int e = 0; e < cloud.neighbour_count; ++e) {
    const Vec3& p = cloud.position[neighbours[e]];
    if (p[axis] != centre[axis]) continue;
    const Eigen::Vector2d offset(p[across] - centre[across], p[up] - centre[up]);
    sum += offset;
    squares += offset * offset.transpose();
    ++beside;
  }
  const Eigen::Matrix2d scatter = squares / beside - sum * sum.transpose() / (beside * beside);
  const Eigen::Vector2d extent =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  return extent[0] > thinness * thinness * extent[1];
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
    if (is_in_patch(cloud, i, axis, options.thinness)) in_patch.push_back(i);
  const auto is_most = [&](std::size_t count) {
    return static_cast<double>(count) >= options.least_part * probes;
  };
  if (!is_most(in_patch.size())) return {};
  progress.update(1.0);

  std::vector<double> values;
  values.reserve(cloud.position.size());
  for (const Vec3& p : cloud.position) values.push_back(p[axis]);
  sort_unique(values);
  if (static_cast<Index>(values.size()) < options.least_count) return {};
  std::vector<double> steps;  // x local spacing
  for (const Index i : in_patch) {
    const double step =
        step_at(values, cloud.position[i][axis]) / static_cast<double>(cloud.local_spacing[i]);
    if (step >= options.least_step && step <= options.most_step) steps.push_back(step);
  }
  if (!is_most(steps.size())) return {};
  std::sort(steps.begin(), steps.end());
  return {axis, static_cast<Index>(values.size()), steps[steps.size() / 2],
          steps[steps.size() * 4 / 5]};
}

}  // namespace

Layers find_layers(const PointCloud& cloud, const LayerOptions& options, Progress& progress) {
  Layers layers;
  for (int axis = 0; axis < 3 && layers.axis == kNone; ++axis)
    layers = layers_along(cloud, axis, options, progress);
  return layers;
}

}  // namespace shrinkwrap
