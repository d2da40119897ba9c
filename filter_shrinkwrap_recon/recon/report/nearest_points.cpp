#include "report/nearest_points.h"

#include <cmath>
#include <utility>

#include "common/parallel.h"
#include "geometry/voxel_search.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;

}  // namespace

std::vector<NearestPoint> nearest_points(const std::vector<Vec3>& points,
                                         const std::vector<Vec3>& queries, Progress& progress) {
  std::vector<NearestPoint> nearest(queries.size());
  std::vector<Vec3> finite;
  std::vector<Index> index;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    finite.push_back(points[i]);
    index.push_back(static_cast<Index>(i));
  }
  if (finite.empty()) return nearest;
  const Frame frame = unit_frame(finite);
  for (Vec3& p : finite) p = frame.to_unit(p);
  const VoxelSearch search(std::move(finite), progress);
  parallel_for_each(static_cast<Index>(queries.size()), kGrain, progress, [&](Index q) {
    if (!queries[q].allFinite()) return;
    const VoxelSearch::Hit hit = search.nearest(frame.to_unit(queries[q]));
    const double distance = frame.to_input_length(std::sqrt(hit.squared_distance));
    if (std::isfinite(distance)) nearest[q] = {index[hit.index], distance};
  });
  return nearest;
}

}  // namespace shrinkwrap
