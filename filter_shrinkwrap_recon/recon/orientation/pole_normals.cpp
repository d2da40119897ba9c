#include "orientation/pole_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8, kGrainOfProbes = 1 << 5;
constexpr Index kProbes = 1 << 10;  // about
constexpr int kMostNeighbours = 64;
// Neighbours so near, x local spacing, count less: their direction is that of noise.
constexpr double kSoftening = 0.25;
constexpr float kTolerance = 1e-5f;  // x unit, of what lies on a plane of the inverted neighbours
constexpr float kLeastSquared = 1e-8f;  // of twice the area of three of them

// The neighbours of a sample, inverted at it: q = d / |d|^2, but for the nearest (kSoftening). The
// ball through the sample with its centre in the direction n is empty of them up to the diameter
// 1 / max q.n, and to any if that is negative. The largest that touches three: n is normal to the
// face of their convex hull with the least height, max q.n. (Where balls may be of any size, an
// edge or a corner of the hull may lie lower still; the faces around are as good.)
class InvertedNeighbours {
 public:
  InvertedNeighbours(const PointCloud& cloud, Index sample,
                     const std::vector<VoxelSearch::Hit>& neighbours) {
    const double unit = 1.0 / cloud.local_spacing[sample];
    x_.resize(static_cast<Eigen::Index>(neighbours.size()));
    y_.resize(x_.size());
    z_.resize(x_.size());
    for (const VoxelSearch::Hit& hit : neighbours) {
      if (hit.index == sample) continue;
      const Vec3 d = unit * (cloud.position[hit.index] - cloud.position[sample]);
      const Vec3 inverted = d / (d.squaredNorm() + kSoftening * kSoftening);
      x_[count_] = static_cast<float>(inverted.x());
      y_[count_] = static_cast<float>(inverted.y());
      z_[count_] = static_cast<float>(inverted.z());
      ++count_;
    }
    x_.conservativeResize(count_);
    y_.conservativeResize(count_);
    z_.conservativeResize(count_);
    if (count_ > 0) mean_ = Vec3f(x_.mean(), y_.mean(), z_.mean());
  }

  // One over the diameter of the largest empty ball in a direction or the opposite one, the larger.
  float least_height_along(const Vec3f& direction) const {
    const Row height = heights_over(direction);
    return count_ > 0 ? std::min(height.maxCoeff(), -height.minCoeff()) : 0.0f;
  }

  struct Face {
    Vec3f normal = Vec3f::Zero();  // unit, outwards; zero: there is none
    float height = 0.0f;
  };
  // The face of the hull that has the least height.
  Face lowest_face() const {
    Face lowest;
    lowest.height = std::numeric_limits<float>::infinity();
    for (Eigen::Index a = 0; a < count_; ++a)
      for (Eigen::Index b = a + 1; b + 1 < count_; ++b) lower(a, b, lowest);
    return lowest;
  }

 private:
  using Row = Eigen::Array<float, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostNeighbours>;

  Vec3f at(Eigen::Index k) const { return {x_[k], y_[k], z_[k]}; }
  Row heights_over(const Vec3f& n) const { return n.x() * x_ + n.y() * y_ + n.z() * z_; }

  // Takes a face with the corners a, b and any later one, if it is lower.
  void lower(Eigen::Index a, Eigen::Index b, Face& lowest) const {
    const Eigen::Index first = b + 1, rest = count_ - first;
    const Vec3f p = at(a), q = at(b), cross = p.cross(q), edge = p - q;
    const auto x = x_.segment(first, rest), y = y_.segment(first, rest),
               z = z_.segment(first, rest);
    const Row nx = cross.x() + (y * edge.z() - z * edge.y());
    const Row ny = cross.y() + (z * edge.x() - x * edge.z());
    const Row nz = cross.z() + (x * edge.y() - y * edge.x());
    const Row squared = nx.square() + ny.square() + nz.square();
    const Row length = squared.max(kLeastSquared).sqrt();
    const Row height = (cross.x() * x + cross.y() * y + cross.z() * z) / length;
    const Row above_mean = height - (mean_.x() * nx + mean_.y() * ny + mean_.z() * nz) / length;
    // Of a flat hull either side is outside, and one is lower.
    const Row side = (above_mean.abs() > kTolerance).select(above_mean, -height);
    const Row outward = (side < 0.0f).select(Row::Constant(rest, -1.0f), 1.0f);
    for (Eigen::Index c = 0; c < rest; ++c) {
      const float outer = outward[c] * height[c];
      if (!(outer < lowest.height) || !(squared[c] > kLeastSquared)) continue;
      const Vec3f normal = outward[c] / length[c] * Vec3f(nx[c], ny[c], nz[c]);
      if (heights_over(normal).maxCoeff() > outer + kTolerance) continue;
      lowest = {normal, outer};
    }
  }

  Row x_, y_, z_;
  Eigen::Index count_ = 0;
  Vec3f mean_ = Vec3f::Zero();  // within the hull
};

bool is_of_face(const PointCloud& cloud, Index sample,
                const std::vector<VoxelSearch::Hit>& neighbours, const PoleNormalOptions& options) {
  const Vec3 normal = cloud.normal[sample].cast<double>();
  const double thickness = options.thickness * cloud.local_spacing[sample];
  const auto members =
      std::count_if(neighbours.begin(), neighbours.end(), [&](const VoxelSearch::Hit& hit) {
        return std::abs((cloud.position[hit.index] - cloud.position[sample]).dot(normal)) <
               thickness;
      });
  return static_cast<double>(members) >=
         options.least_members * static_cast<double>(neighbours.size());
}

// The way to the pole, or the normal that there is.
Vec3f pole_normal(const PointCloud& cloud, Index sample, const PoleNormalOptions& options,
                  std::vector<VoxelSearch::Hit>& neighbours) {
  const Vec3f& own = cloud.normal[sample];
  cloud.search.k_nearest(cloud.position[sample], std::clamp(options.neighbours, 1, kMostNeighbours),
                         neighbours);
  const InvertedNeighbours inverted(cloud, sample, neighbours);
  const InvertedNeighbours::Face face = inverted.lowest_face();
  if (face.normal.isZero() || std::abs(face.normal.dot(own)) >= options.most_cosine) return own;
  const double least_ratio = is_of_face(cloud, sample, neighbours, options)
                                 ? options.least_ratio_to_face
                                 : options.least_ratio;
  const double height = std::max<double>(face.height, 1.0 / options.most_diameter);
  const bool is_much_larger = least_ratio * height < inverted.least_height_along(own);
  return is_much_larger ? face.normal : own;
}

bool may_have_another(const PointCloud& cloud, Index sample, double least_deviation) {
  return cloud.deviation[sample] > least_deviation * cloud.local_spacing[sample];
}

// Part of the samples, by some evenly spread, that have another normal if none is noise.
double part_with_another(const PointCloud& cloud, const PoleNormalOptions& options,
                         Progress& progress) {
  const Index stride = cloud.size() / kProbes + 1, probes = block_count(cloud.size(), stride);
  const Index count =
      parallel_sum(probes, kGrainOfProbes, progress, Index{0}, [&](Index begin, Index end) {
        std::vector<VoxelSearch::Hit> neighbours;
        Index found = 0;
        for (Index probe = begin; probe < end; ++probe) {
          const Index i = probe * stride;
          found += may_have_another(cloud, i, options.least_deviation) &&
                   pole_normal(cloud, i, options, neighbours) != cloud.normal[i];
        }
        return found;
      });
  return static_cast<double>(count) / static_cast<double>(std::max<Index>(probes, 1));
}

}  // namespace

Index fit_pole_normals(PointCloud& cloud, double noise, const PoleNormalOptions& options,
                       Progress& progress) {
  double least = options.least_deviation;
  if (options.least_over_noise * noise > least &&
      part_with_another(cloud, options, progress) < options.thin_part)
    least = options.least_over_noise * noise;
  std::vector<Vec3f> fitted = cloud.normal;
  const Index replaced =
      parallel_sum(cloud.size(), kGrain, progress, Index{0}, [&](Index begin, Index end) {
        std::vector<VoxelSearch::Hit> neighbours;
        Index count = 0;
        for (Index i = begin; i < end; ++i) {
          if (!may_have_another(cloud, i, least)) continue;
          fitted[i] = pole_normal(cloud, i, options, neighbours);
          count += fitted[i] != cloud.normal[i];
        }
        return count;
      });
  cloud.normal = std::move(fitted);
  return replaced;
}

}  // namespace shrinkwrap
