#include "complete_matching/outliers_on_surface.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "geometry/coordinate_matches.h"
#include "geometry/triangle_geometry.h"
#include "mesh/face_tree.h"
#include "samples/oriented_samples.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8;

// Moves outliers, ascending, from the report to the cloud.
void keep(const std::vector<OrientedSample>& kept, PointCloud& cloud, OutlierReport& report,
          Progress& progress) {
  if (kept.empty()) return;
  std::vector<Index> left, kept_index;
  for (const OrientedSample& outlier : kept) kept_index.push_back(outlier.input_index);
  std::set_difference(report.input_index.begin(), report.input_index.end(), kept_index.begin(),
                      kept_index.end(), std::back_inserter(left));
  std::vector<OrientedSample> samples = oriented_samples(cloud);
  samples.insert(samples.end(), kept.begin(), kept.end());
  replace_samples(cloud, samples, progress);
  std::vector<Index> still_off;
  std::set_difference(report.off_surface.begin(), report.off_surface.end(), kept_index.begin(),
                      kept_index.end(), std::back_inserter(still_off));
  report.off_surface = std::move(still_off);
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
  const auto find_kept = [&](Index begin, Index end, std::vector<OrientedSample>& kept) {
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
      const Vec3f normal = unit_or_zero(mesh.area_vector(face)).cast<float>();
      kept.push_back({p,
                      outliers[n],
                      normal,
                      {p.cast<float>(), normal},
                      cloud.more_noise.empty() ? 0.0f : cloud.more_noise[nearest.index]});
    }
  };
  const std::vector<OrientedSample> kept = parallel_collect<OrientedSample>(
      static_cast<Index>(outliers.size()), kGrain, progress, find_kept);
  keep(kept, cloud, report, progress);
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
  std::vector<OrientedSample> kept;
  for (const Index i : found) {
    const Vec3 p = cloud.frame.to_unit(points[i]);
    kept.push_back({p, i, Vec3f::UnitZ(), {p.cast<float>(), Vec3f::UnitZ()}, 0.0f});
  }
  keep(kept, cloud, report, progress);
}

}  // namespace shrinkwrap
