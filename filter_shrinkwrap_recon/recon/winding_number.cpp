#include "winding_number.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kLeafSamples = 8;
constexpr double kOpening = 2.0;    // beta: a node is far from this many radii on
constexpr double kSoftening = 0.5;  // x median spacing
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

WindingNumber::WindingNumber(const PointCloud& cloud)
    : cloud_(cloud), softening_(kSoftening * kSoftening * cloud.spacing * cloud.spacing) {
  node_.reserve(static_cast<std::size_t>(4 * cloud.size() / kLeafSamples + 8));
  if (cloud.size() > 0) build(0, cloud.size(), morton_keys(cloud.position));
}

double WindingNumber::area(Index sample) const {
  const double side =
      std::min<double>(cloud_.local_spacing[sample], kGreatestSpacing * cloud_.spacing);
  return side * side;
}

Index WindingNumber::build(Index begin, Index end, const std::vector<std::uint64_t>& keys) {
  const Index me = static_cast<Index>(node_.size());
  node_.emplace_back();
  Node node{Vec3::Zero(), Vec3::Zero(), Eigen::Matrix3d::Zero(), 0.0, begin, end, 0};
  double total = 0.0;
  if (end - begin <= kLeafSamples) {
    for (Index i = begin; i < end; ++i) {
      node.centre += area(i) * cloud_.position[i];
      total += area(i);
    }
    node.centre /= total;
    for (Index i = begin; i < end; ++i) {
      const Vec3 offset = cloud_.position[i] - node.centre,
                 normal = cloud_.normal[i].cast<double>();
      node.dipole += area(i) * normal;
      node.moment += area(i) * normal * offset.transpose();
      node.radius = std::max(node.radius, offset.norm());
    }
  } else {
    const Index middle = split_of(begin, end, keys);
    const Index children[2] = {build(begin, middle, keys), build(middle, end, keys)};
    for (const Index child : children)
      node.centre += static_cast<double>(node_[child].end - node_[child].begin) / (end - begin) *
                     node_[child].centre;
    for (const Index child : children) {
      const Node& part = node_[child];
      const Vec3 offset = part.centre - node.centre;
      node.dipole += part.dipole;
      node.moment += part.moment + part.dipole * offset.transpose();
    }
    for (Index i = begin; i < end; ++i)
      node.radius = std::max(node.radius, (cloud_.position[i] - node.centre).squaredNorm());
    node.radius = std::sqrt(node.radius);
  }
  node.skip = static_cast<Index>(node_.size());
  node_[me] = node;
  return me;
}

double WindingNumber::at(const Vec3& query) const {
  double sum = 0.0;
  const Index nodes = static_cast<Index>(node_.size());
  for (Index i = 0; i < nodes;) {
    const Node& node = node_[i];
    const Vec3 d = node.centre - query;
    const double squared = d.squaredNorm();
    if (squared > kOpening * kOpening * node.radius * node.radius + softening_) {
      const double inverse = 1.0 / std::sqrt(squared), inverse_squared = inverse * inverse;
      sum += inverse * inverse_squared *
             (node.dipole.dot(d) + node.moment.trace() -
              3.0 * inverse_squared * d.dot(node.moment * d));
      i = node.skip;
    } else if (node.end - node.begin <= kLeafSamples) {
      for (Index sample = node.begin; sample < node.end; ++sample) {
        const Vec3 offset = cloud_.position[sample] - query;
        const double softened = offset.squaredNorm() + softening_;
        sum += area(sample) * cloud_.normal[sample].cast<double>().dot(offset) /
               (softened * std::sqrt(softened));
      }
      i = node.skip;
    } else {
      ++i;
    }
  }
  return sum / kFourPi;
}

}  // namespace shrinkwrap
