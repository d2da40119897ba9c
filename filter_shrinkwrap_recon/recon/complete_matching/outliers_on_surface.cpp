#include "complete_matching/outliers_on_surface.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "geometry/coordinate_matches.h"
#include "geometry/morton.h"
#include "geometry/triangle_geometry.h"
#include "mesh/face_tree.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8;

// An outlier that becomes a sample.
struct Kept {
  Index input_index;
  Vec3f normal;
  float more_noise;
};

// Moves outliers, ascending, from the report to the cloud.
void keep(const std::vector<Kept>& kept, PointCloud& cloud, OutlierReport& report,
          const std::vector<Vec3>& points, Progress& progress) {
  if (kept.empty()) return;
  std::vector<Index> left, kept_index;
  for (const Kept& outlier : kept) kept_index.push_back(outlier.input_index);
  std::set_difference(report.input_index.begin(), report.input_index.end(), kept_index.begin(),
                      kept_index.end(), std::back_inserter(left));

  std::vector<Vec3> position = cloud.position;
  for (const Index i : kept_index) position.push_back(cloud.frame.to_unit(points[i]));
  const std::vector<Index> order = morton_order(position, progress);
  PointCloud next;
  next.frame = cloud.frame;
  next.conditioning = cloud.conditioning;
  next.closedness = cloud.closedness;
  std::vector<Vec3f> normal;
  for (const Index i : order) {
    const bool is_new = i >= cloud.size();
    const Kept outlier =
        is_new ? kept[i - cloud.size()] : Kept{cloud.input_index[i], cloud.normal[i], 0.0f};
    next.position.push_back(position[i]);
    next.input_index.push_back(outlier.input_index);
    normal.push_back(outlier.normal);
    if (!cloud.more_noise.empty())
      next.more_noise.push_back(is_new ? outlier.more_noise : cloud.more_noise[i]);
    if (!cloud.plane.empty())
      next.plane.push_back(is_new ? TangentPlane{position[i].cast<float>(), outlier.normal}
                                  : cloud.plane[i]);
  }
  next.search = VoxelSearch(next.position, progress);
  measure_neighbourhoods(next, cloud.neighbour_count, progress);
  next.normal = std::move(normal);
  cloud = std::move(next);
  report.on_surface += static_cast<Index>(kept.size());
  report.input_index = std::move(left);
}

}  // namespace

Index keep_outliers_on_surface(PointCloud& cloud, OutlierReport& report,
                               const std::vector<Vec3>& points, const SurfaceMesh& mesh,
                               const OutlierOptions& options, Progress& progress) {
  if (report.input_index.empty() || !(options.foot > 0.0)) return 0;
  const FaceTree tree(mesh, progress);
  const std::vector<Index>& outliers = report.input_index;
  const auto find_kept = [&](Index begin, Index end, std::vector<Kept>& kept) {
    const auto any = [](Index) { return true; };
    FaceTree::Anchor anchor;
    for (Index n = begin; n < end; ++n) {
      const Vec3 p = cloud.frame.to_unit(points[outliers[n]]);
      const VoxelSearch::Hit nearest = cloud.search.nearest(p);
      const double gap = std::sqrt(nearest.squared_distance);
      const double spacing = cloud.spacing_at(nearest.index);
      if (gap > options.widest_gap * spacing) continue;
      const Index face = tree.nearest(p, std::pow(options.foot * gap, 2), kNone, any, anchor).face;
      if (face == kNone) continue;
      kept.push_back({outliers[n], unit_or_zero(mesh.area_vector(face)).cast<float>(),
                      cloud.more_noise.empty() ? 0.0f : cloud.more_noise[nearest.index]});
    }
  };
  const std::vector<Kept> kept =
      parallel_collect<Kept>(static_cast<Index>(outliers.size()), kGrain, progress, find_kept);
  keep(kept, cloud, report, points, progress);
  return static_cast<Index>(kept.size());
}

void keep_outliers_among(PointCloud& cloud, OutlierReport& report, const std::vector<Vec3>& points,
                         const std::vector<Vec3>& vertices, Progress& progress) {
  if (report.input_index.empty()) return;
  std::vector<Index> by_place = report.input_index, found;
  std::sort(by_place.begin(), by_place.end(),
            [&](Index a, Index b) { return coordinates_less(points[a], points[b]); });
  for (const Vec3& vertex : vertices) {
    if (!vertex.allFinite()) continue;
    const auto place = std::lower_bound(
        by_place.begin(), by_place.end(), vertex,
        [&](Index outlier, const Vec3& p) { return coordinates_less(points[outlier], p); });
    if (place != by_place.end() && points[*place] == vertex) found.push_back(*place);
  }
  sort_unique(found);
  std::vector<Kept> kept;
  for (const Index i : found) kept.push_back({i, Vec3f::UnitZ(), 0.0f});
  keep(kept, cloud, report, points, progress);
}

}  // namespace shrinkwrap
