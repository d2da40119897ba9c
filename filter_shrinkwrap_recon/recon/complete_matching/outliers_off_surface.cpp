#include "complete_matching/outliers_off_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "common/parallel.h"
#include "geometry/coordinate_matches.h"
#include "geometry/triangle_geometry.h"
#include "mesh/box_tree.h"
#include "mesh/face_tree.h"
#include "samples/oriented_samples.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr Index kFewAtOnce = 1 << 6;  // of the samples that are off the surface
constexpr Index kLeastSamples = 64;   // as of the search for outliers
constexpr int kUsual = SampleOptions::kUsualNeighbours;
constexpr int kAround = kUsual - 1;
constexpr int kMostLookedAt = 3 * kAround;  // to find as many that are not left out
// A sample with a smaller spacing, x the median, is hardly farther from others than those around.
constexpr double kLeastSpacing = 0.9;
constexpr double kFlat = 1e-3;  // x spacing, from one plane: the rest of the samples
// Of a mesh: edges were chosen again since samples were judged, and normals are those of one plane.
constexpr double kOffMesh = 0.5;        // x distance of what lies on the mesh after all
constexpr double kLeastGap = 0.7;       // from the nearest vertex, x spacing
constexpr double kInPlaneOfMesh = 0.8;  // of the samples around, at most
constexpr std::int64_t kTestsPerFace = 50;

struct Surroundings {
  double spacing;             // of the sample itself
  std::vector<Index> around;  // the nearest that count, nearest first
};

template <class Counts>
Surroundings surroundings_of(const PointCloud& cloud, Index sample, const Counts& counts) {
  std::vector<VoxelSearch::Hit> hits;
  cloud.search.k_nearest(cloud.position[sample], std::min<int>(kMostLookedAt, cloud.size()), hits);
  Surroundings result;
  result.spacing = std::sqrt(kPi / kAround * hits[kAround].squared_distance);
  for (const VoxelSearch::Hit& hit : hits)
    if (hit.index != sample && result.around.size() < kAround && counts(hit.index))
      result.around.push_back(hit.index);
  return result;
}

// Whether a sample lies in the planes of more than a part of the samples around.
bool is_in_planes(const PointCloud& cloud, Index sample, const std::vector<Index>& around,
                  double slope, double part) {
  const auto count = std::count_if(around.begin(), around.end(), [&](Index other) {
    const Vec3 d = cloud.position[sample] - cloud.position[other];
    return std::abs(d.dot(cloud.normal[other].cast<double>())) <= slope * d.norm();
  });
  return static_cast<double>(count) > part * static_cast<double>(around.size());
}

// Leaves samples out, ascending, and those that are at the same place but for a little.
Index leave_out(const std::vector<Index>& stray, PointCloud& cloud, OutlierReport& report,
                const OutlierOptions& options, Progress& progress) {
  if (stray.empty()) return 0;
  const Index count = static_cast<Index>(stray.size());
  const std::size_t suspected =
      std::max(report.input_index.size(), static_cast<std::size_t>(report.suspected));
  const double all =
      static_cast<double>(report.input_index.size()) + static_cast<double>(cloud.size());
  if (static_cast<double>(suspected) + count > options.most * all) return 0;
  std::vector<OrientedSample> rest;
  std::vector<Vec3> position;
  OutlierReport told = report;
  auto next = stray.begin();
  for (const OrientedSample& sample : oriented_samples(cloud)) {
    if (next != stray.end() && sample.input_index == cloud.input_index[*next]) {
      told.input_index.push_back(sample.input_index);
      told.off_surface.push_back(sample.input_index);
      ++next;
      continue;
    }
    rest.push_back(sample);
    position.push_back(sample.position);
  }
  if (height_over_plane(position, progress) < kFlat * cloud.spacing) return 0;
  replace_samples(cloud, rest, progress);
  leave_out_copies(cloud, told);
  std::sort(told.input_index.begin(), told.input_index.end());
  std::sort(told.off_surface.begin(), told.off_surface.end());
  told.suspected += count;
  report = std::move(told);
  return count;
}

class OffSurface {
 public:
  OffSurface(const PointCloud& cloud, const SurfaceMesh& surface, double noise,
             const OutlierOptions& options, Progress& progress)
      : cloud_(cloud),
        options_(options),
        progress_(progress),
        noise_(noise),
        tree_(surface, progress),
        is_left_out_(cloud.position.size(), 0) {}

  // One after the other, since stray ones are around each other; ascending.
  std::vector<Index> find() {
    std::vector<Index> stray, left = far_from_surface();
    for (int round = 0; round < options_.most_rounds && !left.empty(); ++round) {
      const std::vector<Index> found =
          parallel_collect<Index>(static_cast<Index>(left.size()), kFewAtOnce, progress_,
                                  [&](Index begin, Index end, std::vector<Index>& alone) {
                                    FaceTree::Anchor anchor;
                                    for (Index n = begin; n < end; ++n)
                                      if (is_alone(left[static_cast<std::size_t>(n)], anchor))
                                        alone.push_back(left[static_cast<std::size_t>(n)]);
                                  });
      if (found.empty()) break;
      for (const Index i : found) is_left_out_[i] = 1;
      stray.insert(stray.end(), found.begin(), found.end());
      left.erase(
          std::remove_if(left.begin(), left.end(), [&](Index i) { return is_left_out_[i] != 0; }),
          left.end());
    }
    std::sort(stray.begin(), stray.end());
    return stray;
  }

 private:
  FaceTree::Hit nearest(Index sample, double limit, FaceTree::Anchor& anchor) const {
    const auto any = [](Index) { return true; };
    return tree_.nearest(cloud_.position[sample], limit * limit, kNone, any, anchor);
  }

  std::vector<Index> far_from_surface() {
    return parallel_collect<Index>(
        cloud_.size(), kGrain, progress_, [&](Index begin, Index end, std::vector<Index>& far) {
          FaceTree::Anchor anchor;
          for (Index i = begin; i < end; ++i) {
            if (cloud_.local_spacing[i] < kLeastSpacing * cloud_.spacing) continue;
            const double limit =
                options_.off_surface + options_.noise_off_surface * cloud_.noise_at(i, noise_);
            if (nearest(i, limit * cloud_.spacing_beside(i), anchor).face == kNone)
              far.push_back(i);
          }
        });
  }

  bool is_alone(Index sample, FaceTree::Anchor& anchor) const {
    const Surroundings s =
        surroundings_of(cloud_, sample, [&](Index other) { return !is_left_out_[other]; });
    if (s.spacing <= options_.spacing_off_it * cloud_.spacing_beside(sample) ||
        is_in_planes(cloud_, sample, s.around, options_.slope, options_.support))
      return false;
    const double infinite = std::numeric_limits<double>::infinity();
    const double near =
        options_.on_surface * std::sqrt(nearest(sample, infinite, anchor).squared_distance);
    const auto count = std::count_if(s.around.begin(), s.around.end(), [&](Index other) {
      return nearest(other, near, anchor).face != kNone;
    });
    return static_cast<double>(count) >= options_.part_on_surface * kAround;
  }

  const PointCloud& cloud_;
  const OutlierOptions& options_;
  Progress& progress_;
  double noise_;
  FaceTree tree_;
  std::vector<char> is_left_out_;
};

}  // namespace

Index leave_out_samples_off_surface(PointCloud& cloud, OutlierReport& report,
                                    const SurfaceMesh& surface, double noise,
                                    const OutlierOptions& options, Progress& progress) {
  if (cloud.size() < kLeastSamples || !std::isfinite(options.off_surface)) return 0;
  const std::vector<Index> stray = OffSurface(cloud, surface, noise, options, progress).find();
  return leave_out(stray, cloud, report, options, progress);
}

Index leave_out_samples_off_mesh(PointCloud& cloud, OutlierReport& report,
                                 const std::vector<Vec3>& points, const std::vector<Vec3>& vertices,
                                 const std::vector<Triangle>& triangles,
                                 const OutlierOptions& options, Progress& progress) {
  if (cloud.size() < kLeastSamples || !std::isfinite(options.off_surface)) return 0;
  const Index missing =
      match_coordinates(points_at(points, cloud.input_index), vertices, progress).missing;
  if (missing == 0 || missing > options.most * cloud.size()) return 0;

  std::vector<Vec3> places;
  std::copy_if(vertices.begin(), vertices.end(), std::back_inserter(places),
               [](const Vec3& p) { return p.allFinite(); });
  std::sort(places.begin(), places.end(), coordinates_less);
  std::vector<char> is_missing(cloud.position.size());
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    is_missing[i] = !std::binary_search(places.begin(), places.end(), points[cloud.input_index[i]],
                                        coordinates_less);
  });

  std::vector<Vec3> unit(vertices.size());
  std::transform(vertices.begin(), vertices.end(), unit.begin(),
                 [&](const Vec3& p) { return cloud.frame.to_unit(p); });
  const BoxTree boxes(unit, triangles, progress);
  // Where faces lie in a heap, each search may meet all of them.
  std::int64_t tests_left = kTestsPerFace * static_cast<std::int64_t>(triangles.size());
  const auto has_face_within = [&](const Vec3& p, double distance) {
    bool has = false;
    const std::vector<Vec3> corners = {p - Vec3::Constant(distance), p + Vec3::Constant(distance)};
    boxes.for_each_overlap(boxes.box_of(corners, {0, 1, 1}), [&](Index f) {
      const Triangle& t = triangles[static_cast<std::size_t>(f)];
      --tests_left;
      has = has || foot_on_triangle(p, unit[t[0]], unit[t[1]], unit[t[2]]).squared_distance <=
                       distance * distance;
    });
    return has;
  };
  std::vector<char> is_left_out(cloud.position.size(), 0);
  const auto is_off_mesh = [&](Index sample) {
    std::vector<Index> around =
        surroundings_of(cloud, sample, [&](Index other) { return !is_left_out[other]; }).around;
    around.erase(std::remove_if(around.begin(), around.end(),
                                [&](Index other) { return is_missing[other] != 0; }),
                 around.end());
    if (static_cast<double>(around.size()) < options.part_on_surface * kAround ||
        is_in_planes(cloud, sample, around, options.slope, kInPlaneOfMesh))
      return false;
    // What is nearer to the mesh is on it (outliers_on_surface.h).
    const double gap = (cloud.position[around.front()] - cloud.position[sample]).norm();
    return gap > kLeastGap * cloud.spacing_beside(sample) &&
           (gap > options.widest_gap * cloud.spacing_at(around.front()) ||
            !has_face_within(cloud.position[sample], kOffMesh * options.foot * gap));
  };
  std::vector<Index> stray, left;
  for (Index i = 0; i < cloud.size(); ++i)
    if (is_missing[i]) left.push_back(i);
  for (int round = 0; round < options.most_rounds; ++round) {
    std::vector<Index> found;
    for (const Index i : left) {
      progress.update(0.0);
      if (tests_left > 0 && !is_left_out[i] && is_off_mesh(i)) found.push_back(i);
    }
    if (found.empty()) break;
    for (const Index i : found) is_left_out[i] = 1;
    stray.insert(stray.end(), found.begin(), found.end());
  }
  std::sort(stray.begin(), stray.end());
  return leave_out(stray, cloud, report, options, progress);
}

}  // namespace shrinkwrap
