#include "orientation/winding_number.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "geometry/morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kLeafSamples = 8;
constexpr Index kSubtreeSamples = 1 << 14;  // at most, of a part that one thread builds
constexpr float kOpening = 2.0f;            // beta: a node is far from this many radii on
constexpr double kSoftening = 0.5;          // x median spacing
constexpr double kGreatestSpacing =
    4;  // x median spacing: a lone sample stands for no more area than that
constexpr double kFourPi = 12.566370614359172;

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
  Index begin = 0, end = 0;  // samples
};

// A part of the tree whose nodes count from its own first one.
struct WindingNumber::Subtree {
  Index begin = 0, end = 0;  // samples
  std::vector<Node> node;
  Range range;
};

// Builds the lower parts of the tree in parallel and joins them in depth-first order, so that the
// nodes are those of one recursion.
class WindingNumber::Builder {
 public:
  Builder(const std::vector<Dipole>& dipole, float softening,
          const std::vector<std::uint64_t>& keys)
      : dipole_(dipole), softening_(softening), keys_(keys) {}

  std::vector<Node> build(Progress& progress) {
    const Index samples = static_cast<Index>(dipole_.size());
    list_subtrees(0, samples);
    parallel_for_each(static_cast<Index>(subtrees_.size()), 1, progress, [&](Index i) {
      Subtree& subtree = subtrees_[i];
      subtree.range = build(subtree.begin, subtree.end, subtree.node);
    });
    std::size_t nodes = 2 * subtrees_.size();
    for (const Subtree& subtree : subtrees_) nodes += subtree.node.size();
    node_.reserve(nodes);
    join(0, samples);
    return std::move(node_);
  }

 private:
  void list_subtrees(Index begin, Index end) {
    if (end - begin <= kSubtreeSamples) {
      subtrees_.emplace_back();
      subtrees_.back().begin = begin;
      subtrees_.back().end = end;
      return;
    }
    const Index middle = split_of(begin, end, keys_);
    list_subtrees(begin, middle);
    list_subtrees(middle, end);
  }

  Range join(Index begin, Index end) {
    const Index me = static_cast<Index>(node_.size());
    if (end - begin <= kSubtreeSamples) {
      Subtree& subtree = subtrees_[next_subtree_++];
      for (Node& node : subtree.node) {
        node.skip += me;
        node_.push_back(node);
      }
      subtree.node = {};
      return subtree.range;
    }
    node_.emplace_back();
    const Index middle = split_of(begin, end, keys_);
    const Range first = join(begin, middle), second = join(middle, end);
    const Range range = union_of(first, second);
    finish(range, node_[me]);
    node_[me].skip = static_cast<Index>(node_.size());
    return range;
  }

  Range build(Index begin, Index end, std::vector<Node>& nodes) const {
    const std::size_t me = nodes.size();
    nodes.emplace_back();
    Range range;
    if (end - begin <= kLeafSamples) {
      range = leaf(begin, end);
    } else {
      const Index middle = split_of(begin, end, keys_);
      const Range first = build(begin, middle, nodes), second = build(middle, end, nodes);
      range = union_of(first, second);
    }
    finish(range, nodes[me]);
    nodes[me].skip = static_cast<Index>(nodes.size());
    return range;
  }

  Range leaf(Index begin, Index end) const {
    Range range;
    range.begin = begin;
    range.end = end;
    double total = 0.0;
    for (Index i = begin; i < end; ++i) {
      const double area = dipole_[i].moment.norm();
      range.centre += area * dipole_[i].position.cast<double>();
      total += area;
    }
    if (total > 0.0) {
      range.centre /= total;
    } else {  // all samples count as none
      for (Index i = begin; i < end; ++i)
        range.centre += dipole_[i].position.cast<double>() / (end - begin);
    }
    for (Index i = begin; i < end; ++i) {
      const Vec3 moment = dipole_[i].moment.cast<double>();
      range.dipole += moment;
      range.moment += moment * (dipole_[i].position.cast<double>() - range.centre).transpose();
    }
    return range;
  }

  static Range union_of(const Range& first, const Range& second) {
    Range range;
    range.begin = first.begin;
    range.end = second.end;
    for (const Range* child : {&first, &second})
      range.centre += static_cast<double>(child->end - child->begin) / (range.end - range.begin) *
                      child->centre;
    for (const Range* child : {&first, &second}) {
      range.dipole += child->dipole;
      range.moment += child->moment + child->dipole * (child->centre - range.centre).transpose();
    }
    return range;
  }

  // All of the node but `skip`.
  void finish(const Range& range, Node& node) const {
    node.centre = range.centre.cast<float>();
    node.dipole = range.dipole.cast<float>();
    const Eigen::Matrix3f moment = (0.5 * (range.moment + range.moment.transpose())).cast<float>();
    node.moment[0] = moment(0, 0);
    node.moment[1] = moment(1, 1);
    node.moment[2] = moment(2, 2);
    node.moment[3] = moment(1, 2);
    node.moment[4] = moment(2, 0);
    node.moment[5] = moment(0, 1);
    node.squared_opening =
        kOpening * kOpening * squared_radius(range.begin, range.end, node.centre) + softening_;
    node.begin = range.begin;
    node.end = range.end;
  }

  float squared_radius(Index begin, Index end, const Vec3f& centre) const {
    const auto greatest = [&](Index first, Index last) {
      float squared = 0.0f;
      for (Index i = first; i < last; ++i)
        squared = std::max(squared, (dipole_[i].position - centre).squaredNorm());
      return squared;
    };
    if (end - begin <= kSubtreeSamples) return greatest(begin, end);
    Progress silent;
    std::vector<float> partial(block_count(end - begin, kSubtreeSamples));
    parallel_blocks(end - begin, kSubtreeSamples, silent,
                    [&](Index block, Index first, Index last) {
                      partial[block] = greatest(begin + first, begin + last);
                    });
    return *std::max_element(partial.begin(), partial.end());
  }

  const std::vector<Dipole>& dipole_;
  float softening_;
  const std::vector<std::uint64_t>& keys_;
  std::vector<Subtree> subtrees_;  // in the order of the samples
  std::size_t next_subtree_ = 0;
  std::vector<Node> node_;
};

WindingNumber::WindingNumber(const PointCloud& cloud, Progress& progress)
    : WindingNumber(cloud, std::vector<signed char>(cloud.position.size(), 1), progress) {}

WindingNumber::WindingNumber(const PointCloud& cloud, const std::vector<signed char>& sign,
                             Progress& progress)
    : dipole_(cloud.position.size()),
      softening_(static_cast<float>(kSoftening * kSoftening * cloud.spacing * cloud.spacing)) {
  if (cloud.size() == 0) return;
  parallel_for_each(cloud.size(), kSubtreeSamples, progress, [&](Index i) {
    const float side =
        std::min(cloud.local_spacing[i], static_cast<float>(kGreatestSpacing * cloud.spacing));
    dipole_[i] = {cloud.position[i].cast<float>(),
                  side * side * static_cast<float>(sign[i]) * cloud.normal[i]};
  });
  const std::vector<std::uint64_t> keys =
      morton_keys(cloud.position, bounding_box(cloud.position), progress);
  node_ = Builder(dipole_, softening_, keys).build(progress);
}

WindingNumber::WindingNumber(const PointCloud& cloud) {
  Progress silent;
  *this = WindingNumber(cloud, silent);
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
