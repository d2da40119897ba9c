#include "orientation/crease_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/parallel.h"
#include "samples/plane_support.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8;

int neighbours_asked_for(const CreasePlaneOptions& options) {
  return std::clamp(options.neighbours, 1, PlaneSupport::kMostNeighbours);
}

PlaneSupport planes_around(const PointCloud& cloud, Index sample, const CreasePlaneOptions& options,
                           std::vector<VoxelSearch::Hit>& hits) {
  const Vec3& origin = cloud.position[sample];
  cloud.search.k_nearest(origin, neighbours_asked_for(options), hits);
  // Infinite if all are at one place: no plane has any support then.
  const double scale = 1.0 / std::sqrt(hits.back().squared_distance);
  const auto count = static_cast<Eigen::Index>(hits.size());
  PlaneSupport::Vectors offset(3, count), normal(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Index other = hits[static_cast<std::size_t>(k)].index;
    offset.col(k) = (scale * (cloud.position[other] - origin)).cast<float>();
    normal.col(k) = cloud.normal[other];
  }
  return PlaneSupport(std::move(offset), std::move(normal),
                      options.thickness * scale * cloud.local_spacing[sample]);
}

// The normal of the face that a sample beside an edge is of; its own one if that is of a face, or
// if there is none.
Vec3f normal_of_face(const PointCloud& cloud, Index sample, const CreasePlaneOptions& options,
                     std::vector<VoxelSearch::Hit>& hits) {
  const PlaneSupport planes = planes_around(cloud, sample, options, hits);
  const double least = options.least_members * neighbours_asked_for(options);
  const Vec3f& own = cloud.normal[sample];
  if (planes.members_of(own) >= least) return own;
  const Vec3f normal = planes.normal_of_most_support();
  const bool is_face = !normal.isZero() && planes.members_of(normal) >= least &&
                       planes.agreement_with(normal) >= options.least_agreement;
  return is_face ? normal : own;
}

}  // namespace

Index fit_crease_planes(PointCloud& cloud, const CreasePlaneOptions& options, Progress& progress) {
  std::vector<Vec3f> fitted = cloud.normal;
  const Index replaced =
      parallel_sum(cloud.size(), kGrain, progress, Index{0}, [&](Index begin, Index end) {
        std::vector<VoxelSearch::Hit> hits;
        Index count = 0;
        for (Index i = begin; i < end; ++i) {
          if (!(cloud.deviation[i] > options.least_deviation * cloud.local_spacing[i])) continue;
          fitted[i] = normal_of_face(cloud, i, options, hits);
          count += fitted[i] != cloud.normal[i];
        }
        return count;
      });
  cloud.normal = std::move(fitted);
  return replaced;
}

}  // namespace shrinkwrap
