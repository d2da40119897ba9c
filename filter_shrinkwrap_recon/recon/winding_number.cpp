#include "winding_number.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace shrinkwrap {
namespace {

constexpr Index kLeafSamples = 8;
constexpr double kOpening = 2.0;    // beta: a node is far from this many radii on
constexpr double kSoftening = 0.5;  // x median spacing
constexpr double kGreatestSpacing =
    4;  // x median spacing: a lone sample stands for no more area than that
constexpr double kFourPi = 12.566370614359172;

}  // namespace

WindingNumber::WindingNumber(const PointCloud& cloud)
    : cloud_(cloud), softening_(kSoftening * kSoftening * cloud.spacing * cloud.spacing) {
  node_.reserve(static_cast<std::size_t>(4 * cloud.size() / kLeafSamples + 8));
  if (cloud.size() > 0) build(0, cloud.size());
}

double WindingNumber::area(Index sample) const {
  const double side =
      std::min<double>(cloud_.local_spacing[sample], kGreatestSpacing * cloud_.spacing);
  return side * side;
}

Index WindingNumber::build(Index begin, Index end) {
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
    const Index middle = begin + (end - begin) / 2;
    const Index children[2] = {build(begin, middle), build(middle, end)};
    // The centre only has to be near the samples: half the samples each side weigh the same.
    for (const Index child : children) node.centre += 0.5 * node_[child].centre;
    for (const Index child : children) {
      const Node& part = node_[child];
      const Vec3 offset = part.centre - node.centre;
      node.dipole += part.dipole;
      node.moment += part.moment + part.dipole * offset.transpose();
      node.radius = std::max(node.radius, offset.norm() + part.radius);
    }
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
