#include "winding_number.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kLeafSamples = 8;
constexpr Index kProgressStride = 1 << 12;  // nodes
constexpr float kOpening = 2.0f;            // beta: a node is far from this many radii on
constexpr double kSoftening = 0.5;          // x median spacing
constexpr double kGreatestSpacing =
    4;  // x median spacing: a lone sample stands for no more area than that
constexpr double kFourPi = 12.566370614359172;

// Keys that rise along the order of the samples.
std::vector<std::uint64_t> morton_keys(const std::vector<Vec3>& points) {
  Vec3 low = points[0], high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double cells = 2097151.0 / std::max((high - low).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 cell = (points[i] - low) * cells;
    keys[i] = morton_key(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                         static_cast<std::uint32_t>(cell.z()));
  }
  return keys;
}

// Where the range passes into the other half of the smallest octree cell, cut in two along one
// axis, that holds it: the parts are compact, unlike two halves of equal count.
Index split_of(Index begin, Index end, const std::vector<std::uint64_t>& keys) {
  const std::uint64_t difference = keys[begin] ^ keys[end - 1];
  if (difference == 0) return begin + (end - begin) / 2;
  std::uint64_t bit = difference;
  while (bit & (bit - 1)) bit &= bit - 1;
  const auto split = std::partition_point(keys.begin() + begin, keys.begin() + end,
                                          [&](std::uint64_t key) { return (key & bit) == 0; });
  return static_cast<Index>(split - keys.begin());
}

}  // namespace

// What a node needs of its children, in double precision.
struct WindingNumber::Range {
  Vec3 centre = Vec3::Zero(), dipole = Vec3::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  Index begin, end;
};

WindingNumber::WindingNumber(const PointCloud& cloud, Progress& progress)
    : dipole_(cloud.position.size()),
      softening_(static_cast<float>(kSoftening * kSoftening * cloud.spacing * cloud.spacing)) {
  for (Index i = 0; i < cloud.size(); ++i) {
    const float side =
        std::min(cloud.local_spacing[i], static_cast<float>(kGreatestSpacing * cloud.spacing));
    dipole_[i] = {cloud.position[i].cast<float>(), side * side * cloud.normal[i]};
  }
  node_.reserve(static_cast<std::size_t>(4 * cloud.size() / kLeafSamples + 8));
  if (cloud.size() > 0) build(0, cloud.size(), morton_keys(cloud.position), progress);
}

WindingNumber::WindingNumber(const PointCloud& cloud) {
  Progress silent;
  *this = WindingNumber(cloud, silent);
}

WindingNumber::Range WindingNumber::build(Index begin, Index end,
                                          const std::vector<std::uint64_t>& keys,
                                          Progress& progress) {
  const Index me = static_cast<Index>(node_.size());
  if (me % kProgressStride == 0)
    progress.update(static_cast<double>(begin) / static_cast<double>(dipole_.size()));
  node_.emplace_back();
  Range range;
  range.begin = begin;
  range.end = end;
  if (end - begin <= kLeafSamples) {
    double total = 0.0;
    for (Index i = begin; i < end; ++i) {
      const double area = dipole_[i].moment.norm();
      range.centre += area * dipole_[i].position.cast<double>();
      total += area;
    }
    if (total > 0.0) range.centre /= total;
    for (Index i = begin; i < end; ++i) {
      const Vec3 moment = dipole_[i].moment.cast<double>();
      range.dipole += moment;
      range.moment += moment * (dipole_[i].position.cast<double>() - range.centre).transpose();
    }
  } else {
    const Index middle = split_of(begin, end, keys);
    const Range children[2] = {build(begin, middle, keys, progress),
                               build(middle, end, keys, progress)};
    for (const Range& child : children)
      range.centre += static_cast<double>(child.end - child.begin) / (end - begin) * child.centre;
    for (const Range& child : children) {
      range.dipole += child.dipole;
      range.moment += child.moment + child.dipole * (child.centre - range.centre).transpose();
    }
  }
  Node& node = node_[me];
  node.centre = range.centre.cast<float>();
  node.dipole = range.dipole.cast<float>();
  const Eigen::Matrix3f moment = (0.5 * (range.moment + range.moment.transpose())).cast<float>();
  node.moment[0] = moment(0, 0);
  node.moment[1] = moment(1, 1);
  node.moment[2] = moment(2, 2);
  node.moment[3] = moment(1, 2);
  node.moment[4] = moment(2, 0);
  node.moment[5] = moment(0, 1);
  float squared_radius = 0.0f;
  for (Index i = begin; i < end; ++i)
    squared_radius = std::max(squared_radius, (dipole_[i].position - node.centre).squaredNorm());
  node.squared_opening = kOpening * kOpening * squared_radius + softening_;
  node.begin = begin;
  node.end = end;
  node.skip = static_cast<Index>(node_.size());
  return range;
}

double WindingNumber::at(const Vec3& query) const {
  const Vec3f from = query.cast<float>();
  double sum = 0.0;
  const Index nodes = static_cast<Index>(node_.size());
  for (Index i = 0; i < nodes;) {
    const Node& node = node_[i];
    const Vec3f d = node.centre - from;
    const float squared = d.squaredNorm();
    if (squared > node.squared_opening) {
      const float inverse_squared = 1.0f / squared;
      const auto& [xx, yy, zz, yz, zx, xy] = node.moment;
      const float along = d.x() * (xx * d.x() + 2.0f * xy * d.y()) +
                          d.y() * (yy * d.y() + 2.0f * yz * d.z()) +
                          d.z() * (zz * d.z() + 2.0f * zx * d.x());
      sum += std::sqrt(inverse_squared) * inverse_squared *
             (node.dipole.dot(d) + (xx + yy + zz) - 3.0f * inverse_squared * along);
      i = node.skip;
    } else if (node.end - node.begin <= kLeafSamples) {
      for (Index sample = node.begin; sample < node.end; ++sample) {
        const Vec3f offset = dipole_[sample].position - from;
        const float softened = offset.squaredNorm() + softening_;
        sum += dipole_[sample].moment.dot(offset) / (softened * std::sqrt(softened));
      }
      i = node.skip;
    } else {
      ++i;
    }
  }
  return sum / kFourPi;
}

}  // namespace shrinkwrap
