#include "orientation/wide_normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstddef>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 7;
// A disc of radius r spacings holds pi r^2 samples: that of these is about ten times the noise.
constexpr double kNeighboursPerSquaredNoise = 300.0;
constexpr int kMostNeighbours = 64, kLeastNeighbours = 6;

// Of the samples around: so many that face the other way are more likely right.
constexpr double kMost = 0.6;

// Of the plane that fits those of the nearest samples best which face the way `sample` does.
Vec3f plane_normal(const PointCloud& cloud, Index sample,
                   const std::vector<VoxelSearch::Hit>& nearest) {
  Vec3f way = cloud.normal[sample];
  std::ptrdiff_t against = 0;
  for (const VoxelSearch::Hit& hit : nearest)
    if (cloud.normal[hit.index].dot(way) < 0.0f) ++against;
  if (against >= kMost * static_cast<double>(nearest.size() - 1)) way = -way;
  const Vec3& origin = cloud.position[sample];
  Vec3 sum = Vec3::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  int count = 0;
  for (const VoxelSearch::Hit& hit : nearest) {
    if (!(cloud.normal[hit.index].dot(way) > 0.0f)) continue;
    const Vec3 offset = (cloud.position[hit.index] - origin) / cloud.local_spacing[sample];
    sum += offset;
    squares += offset * offset.transpose();
    ++count;
  }
  const Eigen::Matrix3d scatter = squares - sum * sum.transpose() / std::max(count, 1);
  if (count < kLeastNeighbours || !(scatter.trace() > 0.0)) return cloud.normal[sample];
  const Vec3f normal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0).cast<float>();
  return normal.dot(way) < 0.0f ? Vec3f(-normal) : normal;
}

}  // namespace

std::vector<Vec3f> wide_normals(const PointCloud& cloud, Progress& progress) {
  std::vector<Vec3f> normal = cloud.normal;
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    const double noise = cloud.more_noise[i];
    const double needed = kNeighboursPerSquaredNoise * noise * noise;
    const int neighbours = static_cast<int>(std::min<double>(needed, kMostNeighbours));
    if (neighbours <= cloud.neighbour_count) return;
    std::vector<VoxelSearch::Hit> hits;
    cloud.search.k_nearest(cloud.position[i], neighbours, hits);
    normal[i] = plane_normal(cloud, i, hits);
  });
  return normal;
}

}  // namespace shrinkwrap
