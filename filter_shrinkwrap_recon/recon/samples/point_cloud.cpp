#include "samples/point_cloud.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "common/memory_estimate.h"
#include "common/parallel.h"
#include "geometry/bounding_box.h"
#include "geometry/morton.h"
#include "samples/neighbourhoods.h"
#include "samples/parallel_sheets.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;

// Positions in the input of the finite points.
std::vector<Index> finite_points(const std::vector<Vec3>& points, Progress& progress) {
  return parallel_collect<Index>(static_cast<Index>(points.size()), kGrain, progress,
                                 [&](Index begin, Index end, std::vector<Index>& out) {
                                   out.reserve(static_cast<std::size_t>(end - begin));
                                   for (Index i = begin; i < end; ++i)
                                     if (points[i].allFinite()) out.push_back(i);
                                 });
}

// Both ascending.
void leave_out(const std::vector<Index>& some, std::vector<Index>& indices) {
  if (some.empty()) return;
  std::vector<Index> left;
  std::set_difference(indices.begin(), indices.end(), some.begin(), some.end(),
                      std::back_inserter(left));
  indices = std::move(left);
}

// Drops all but the first (in the input) of points with equal coordinates. In Morton order these
// are next to each other, but where rounding to the unit frame made different points equal they are
// mixed: hence the sort of each run. Returns the input positions that stay, in Morton order.
std::vector<Index> without_duplicates(const std::vector<Vec3>& points,
                                      const std::vector<Vec3>& unit,
                                      const std::vector<Index>& input_index,
                                      const std::vector<Index>& order, Progress& progress) {
  const auto before = [&](Index a, Index b) {
    const Vec3 &p = points[a], &q = points[b];
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] != q[axis]) return p[axis] < q[axis];
    return a < b;
  };
  const Index count = static_cast<Index>(order.size());
  const auto unit_at = [&](Index i) -> const Vec3& { return unit[order[i]]; };
  // A run belongs to the block in which it begins.
  return parallel_collect<Index>(
      count, kGrain, progress, [&](Index first, Index last, std::vector<Index>& kept) {
        kept.reserve(static_cast<std::size_t>(last - first));
        std::vector<Index> run;
        Index begin = first;
        if (first > 0)
          while (begin < last && unit_at(begin) == unit_at(first - 1)) ++begin;
        while (begin < last) {
          Index end = begin + 1;
          while (end < count && unit_at(end) == unit_at(begin)) ++end;
          if (end - begin == 1) {
            kept.push_back(input_index[order[begin]]);
          } else {
            run.clear();
            for (Index i = begin; i < end; ++i) run.push_back(input_index[order[i]]);
            std::sort(run.begin(), run.end(), before);
            run.erase(std::unique(run.begin(), run.end(),
                                  [&](Index a, Index b) { return points[a] == points[b]; }),
                      run.end());
            std::sort(run.begin(), run.end());
            kept.insert(kept.end(), run.begin(), run.end());
          }
          begin = end;
        }
      });
}

// Whether a double holds no more digits than a float does. By its bits: GCC 12 vectorises a
// narrowing and the widening after it into nothing.
bool is_float(double x) {
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  constexpr std::uint64_t kBeyondFloat = (std::uint64_t{1} << 29) - 1;
  return (bits & kBeyondFloat) == 0;
}

// What coordinates have in common.
struct Digits {
  Vec3 largest = Vec3::Zero();  // per axis, without its sign
  bool are_floats = true;
  Digits& operator+=(const Digits& other) {
    largest = largest.cwiseMax(other.largest);
    are_floats = are_floats && other.are_floats;
    return *this;
  }
};

Digits digits_of(const Vec3& p) {
  return {p.cwiseAbs(), is_float(p.x()) && is_float(p.y()) && is_float(p.z())};
}

// How far rounding may have moved a point along each axis, in the unit frame: the coordinates may
// be floats or doubles.
struct Rounding {
  Vec3 along_axes = Vec3::Zero();
  double least = 0.0;  // of all: what the digits resolve of the whole extent
  double step = 0.0;   // ConditioningReport::coordinate_step
};

Rounding rounding_of_input(const std::vector<Vec3>& points, const PointCloud& cloud,
                           Progress& progress) {
  const auto extremes =
      parallel_sum<Digits>(cloud.size(), kGrain, progress, Digits(), [&](Index begin, Index end) {
        Digits some;
        for (Index i = begin; i < end; ++i) some += digits_of(points[cloud.input_index[i]]);
        return some;
      });
  const double last_digit = std::ldexp(1.0, extremes.are_floats ? -23 : -52);
  const double step = std::ldexp(last_digit, std::ilogb(extremes.largest.maxCoeff()));
  return {last_digit * cloud.frame.scale * extremes.largest, std::max(last_digit, 1e-12),
          extremes.are_floats ? step : 0.0};
}

// Of the samples, from the plane and from the line that fit them best: the farthest.
struct Extent {
  double from_plane, from_line;
  Vec3 normal;  // of the plane

  // Whether rounding may have moved the samples off one plane, or off one line. Heights of level
  // ground are exact however far north it lies.
  bool is_flat(const Rounding& rounding) const {
    return !(from_plane > normal.cwiseAbs().dot(rounding.along_axes) + rounding.least);
  }
  bool is_line(const Rounding& rounding) const {
    return !(from_line > rounding.along_axes.maxCoeff() + rounding.least);
  }
};

Extent extent_of(const std::vector<Vec3>& position, Progress& progress) {
  const Index count = static_cast<Index>(position.size());
  const Vec3 mean = parallel_sum<Vec3>(count, kGrain, progress, Vec3(Vec3::Zero()),
                                       [&](Index begin, Index end) {
                                         Vec3 sum = Vec3::Zero();
                                         for (Index i = begin; i < end; ++i) sum += position[i];
                                         return sum;
                                       }) /
                    count;
  const Eigen::Matrix3d scatter = parallel_sum<Eigen::Matrix3d>(
      count, kGrain, progress, Eigen::Matrix3d(Eigen::Matrix3d::Zero()),
      [&](Index begin, Index end) {
        Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
        for (Index i = begin; i < end; ++i) {
          const Vec3 d = position[i] - mean;
          sum += d * d.transpose();
        }
        return sum;
      });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Matrix3d axes = solver.eigenvectors();  // least extent first
  // Farthest from the plane, and from the line along the greatest extent.
  const Vec3 farthest =
      parallel_sum<Box>(count, kGrain, progress, Box(), [&](Index begin, Index end) {
        Box box;
        for (Index i = begin; i < end; ++i) {
          const Vec3 d = axes.transpose() * (position[i] - mean);
          box.high = box.high.cwiseMax(Vec3(std::abs(d.x()), std::hypot(d.x(), d.y()), 0.0));
        }
        return box;
      }).high;
  return {farthest.x(), farthest.y(), axes.col(0)};
}

// A closed surface needs samples on all sides: refuses what is flat up to the rounding of its
// coordinates. Stray points may make a cloud look flat; those left out are told too.
void refuse_flat(const std::vector<Vec3>& points, const PointCloud& cloud, const Rounding& rounding,
                 const FarStrays& left_out, Progress& progress) {
  const Extent extent = extent_of(cloud.position, progress);
  if (!extent.is_flat(rounding)) return;
  const std::size_t strays = left_out.all.empty()
                                 ? find_far_strays(points, {}, progress).distinct.size()
                                 : left_out.distinct.size();
  const std::string count = std::to_string(strays);
  const std::string far = "ten thousand times as far away as the others reach";
  std::string what =
      "all " + std::to_string(cloud.size() + left_out.distinct.size()) + " distinct points";
  if (!left_out.all.empty()) what += " but " + count + " (" + far + ", left out)";
  what += extent.is_line(rounding) ? " lie on one line" : " lie in one plane";
  if (strays > 0 && left_out.all.empty())
    throw InvalidInput(what + ", as far as can be told with " + count + " of them " + far +
                       ". Let outliers be excluded, or delete points that are no measurements.");
  constexpr double kFewSteps = 1e-4;  // if the cloud is but ten thousand times as wide
  const bool is_coarse = rounding.step * cloud.frame.scale > kFewSteps;
  throw InvalidInput(what + ": no closed surface passes through them. Add points off it, or " +
                     "triangulate flat points with a planar method." +
                     (is_coarse ? " Or they are so far from the origin that single precision has "
                                  "few steps for them: " +
                                      std::string(advice_for_coarse_steps())
                                : ""));
}

// Leaves near copies out, unless what is left is flat. Pre: `cloud.search` was made.
void leave_out_near_copies(PointCloud& cloud, const NearCopyOptions& options,
                           const Rounding& rounding, Progress& progress) {
  std::vector<NearCopy> copies = find_near_copies(cloud.position, cloud.search, options, progress);
  if (copies.empty()) return;
  std::vector<char> is_copy(cloud.position.size(), 0);
  for (const NearCopy& pair : copies) is_copy[pair.copy] = 1;
  PointCloud rest;
  std::vector<Index> input_index;
  for (Index i = 0; i < cloud.size(); ++i) {
    if (is_copy[i]) continue;
    rest.position.push_back(cloud.position[i]);
    input_index.push_back(cloud.input_index[i]);
  }
  if (extent_of(rest.position, progress).is_flat(rounding)) return;
  for (NearCopy& pair : copies)
    pair = {cloud.input_index[pair.copy], cloud.input_index[pair.original]};
  // The curve runs through the box of the samples, which may be smaller now.
  const std::vector<Index> order = morton_order(rest.position, progress);
  cloud.position.clear();
  cloud.input_index.clear();
  for (const Index i : order) {
    cloud.position.push_back(rest.position[i]);
    cloud.input_index.push_back(input_index[i]);
  }
  cloud.conditioning.near_copies = std::move(copies);
  cloud.search = VoxelSearch(cloud.position, progress);
}

void refuse_few(const ConditioningReport& report) {
  if (report.distinct >= 4) return;
  std::string what = "a closed surface needs at least 4 distinct points, but there are " +
                     std::to_string(report.distinct) + " (of " + std::to_string(report.given) +
                     " given";
  if (report.not_finite > 0)
    what += ", " + std::to_string(report.not_finite) + " have no finite coordinates";
  if (report.duplicates > 0)
    what += ", " + std::to_string(report.duplicates) + " are duplicates of others";
  throw InvalidInput(what + "). Load or select more points.");
}

}  // namespace

double height_over_plane(const std::vector<Vec3>& positions, Progress& progress) {
  return extent_of(positions, progress).from_plane;
}

const char* advice_for_coarse_steps() {
  return "if the file has more digits, subtract an offset from its coordinates, such as their "
         "middle, before loading it.";
}

Frame unit_frame(const std::vector<Vec3>& points) {
  Frame frame;
  if (points.empty()) return frame;
  const Box box = bounding_box(points);
  for (int axis = 0; axis < 3; ++axis) {
    // Halves first: the sum of two large coordinates may not be finite.
    const double middle = 0.5 * box.low[axis] + 0.5 * box.high[axis];
    // The difference of numbers within a factor of two of each other is exact (Sterbenz 1974).
    // Where the box is too near to zero for that, it stays where it is.
    const double nearest = std::min(std::abs(box.low[axis]), std::abs(box.high[axis]));
    const double farthest = std::max(std::abs(box.low[axis]), std::abs(box.high[axis]));
    const bool same_sign = (box.low[axis] > 0.0) == (box.high[axis] > 0.0);
    const double size = std::abs(middle);
    const bool is_exact = same_sign && 0.5 * size <= nearest && 0.5 * farthest <= size;
    frame.center[axis] = is_exact ? middle : 0.0;
  }
  const double half_extent = (0.5 * box.high - 0.5 * box.low).maxCoeff();
  if (half_extent > 0.0) {
    int exponent = 0;
    if (std::frexp(half_extent, &exponent) == 0.5) --exponent;
    frame.scale = std::ldexp(1.0, std::min(-exponent, 1000));  // finite also for subnormal extents
  }
  return frame;
}

PointCloud prepare_samples(const std::vector<Vec3>& points, const SampleOptions& options,
                           Progress& progress, const FarStrays& far_strays) {
  progress.begin(Stage::samples);
  if (options.neighbours < 4)
    throw InvalidInput("the number of neighbours per sample is " +
                       std::to_string(options.neighbours) + ": at least 4 are needed for a plane.");
  if (points.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 16)
    throw InvalidInput(std::to_string(points.size()) +
                       " points are too many for 32-bit indices. Subsample the cloud first.");
  PointCloud cloud;
  cloud.conditioning.given = points.size();

  progress.set_range(0.0, 0.05);
  std::vector<Index> input_index = finite_points(points, progress);
  cloud.conditioning.not_finite = points.size() - input_index.size();
  leave_out(far_strays.all, input_index);
  {
    std::vector<Vec3> unit(input_index.size());
    const Index count = static_cast<Index>(unit.size());
    parallel_for_each(count, kGrain, progress, [&](Index i) { unit[i] = points[input_index[i]]; });
    cloud.frame = unit_frame(unit);
    parallel_for_each(count, kGrain, progress,
                      [&](Index i) { unit[i] = cloud.frame.to_unit(unit[i]); });
    cloud.input_index =
        without_duplicates(points, unit, input_index, morton_order(unit, progress), progress);
    input_index = {};
  }
  cloud.conditioning.distinct = cloud.input_index.size() + far_strays.distinct.size();
  cloud.conditioning.duplicates =
      points.size() - cloud.conditioning.not_finite - cloud.conditioning.distinct;
  refuse_few(cloud.conditioning);

  progress.set_range(0.2, 0.3);
  cloud.position.resize(cloud.input_index.size());
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    cloud.position[i] = cloud.frame.to_unit(points[cloud.input_index[i]]);
  });
  const Rounding rounding = rounding_of_input(points, cloud, progress);
  cloud.conditioning.coordinate_step = rounding.step;
  refuse_flat(points, cloud, rounding, far_strays, progress);

  progress.set_range(0.3, 0.35);
  cloud.search = VoxelSearch(cloud.position, progress);
  leave_out_near_copies(cloud, options.near_copies, rounding, progress);
  progress.set_range(0.35, 0.4);
  // Lines are lines, also where so many are asked for that they lie on several.
  const int few = std::min(options.neighbours, SampleOptions::kUsualNeighbours);
  const int across =
      neighbours_across_lines(cloud.position, cloud.search, few, options.scan_lines, progress);
  cloud.conditioning.on_lines = across > few;
  const int neighbours = std::max(options.neighbours, across);
  if (neighbours != options.neighbours) {
    require_memory_for({cloud.input_index.size(), neighbours, options.keeps_stages},
                       options.memory_limit);
    cloud.conditioning.neighbours_across_lines = neighbours;
  }
  progress.set_range(0.4, 1.0);
  measure_neighbourhoods(cloud, neighbours, progress);
  return cloud;
}

bool is_exact_in_unit_frame(const PointCloud& cloud, const std::vector<Vec3>& points,
                            Progress& progress) {
  // The scale is a power of two, and to subtract the centre rounds nothing (unit_frame).
  const Frame& frame = cloud.frame;
  const std::vector<NearCopy>& copies = cloud.conditioning.near_copies;
  const auto is_exact = [&](const Vec3& position, Index input_index) {
    return position / frame.scale + frame.center == points[input_index];
  };
  return parallel_sum(cloud.size(), kGrain, progress, Index{0},
                      [&](Index begin, Index end) {
                        Index inexact = 0;
                        for (Index i = begin; i < end; ++i)
                          inexact += !is_exact(cloud.position[i], cloud.input_index[i]);
                        return inexact;
                      }) == 0 &&
         std::all_of(copies.begin(), copies.end(), [&](const NearCopy& pair) {
           return is_exact(frame.to_unit(points[pair.copy]), pair.copy);
         });
}

void measure_neighbourhoods(PointCloud& cloud, int neighbours, Progress& progress) {
  Neighbourhoods neighbourhoods =
      find_neighbourhoods(cloud.position, cloud.search, neighbours, progress);
  fit_parallel_sheets(cloud.position, neighbourhoods, ParallelSheetsOptions(), progress);
  cloud.neighbour_count = neighbourhoods.k;
  cloud.neighbour = std::move(neighbourhoods.neighbour);
  cloud.normal = std::move(neighbourhoods.normal);
  cloud.deviation = std::move(neighbourhoods.deviation);
  cloud.local_spacing = std::move(neighbourhoods.radius);

  // A disc of radius d_k around a sample holds k - 1 others, each with an area of s^2 to itself.
  const float spacing_per_radius = static_cast<float>(std::sqrt(kPi / (cloud.neighbour_count - 1)));
  for (float& spacing : cloud.local_spacing) spacing *= spacing_per_radius;
  std::vector<float> sorted = cloud.local_spacing;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  cloud.spacing = std::max(static_cast<double>(*middle), 1e-12);
  // Points that rounding brought together have no spacing of their own: stages divide by it.
  const float floor = static_cast<float>(1e-3 * cloud.spacing);
  for (float& spacing : cloud.local_spacing) spacing = std::max(spacing, floor);
}

std::vector<Vec3> points_at(const std::vector<Vec3>& points,
                            const std::vector<Index>& input_index) {
  std::vector<Vec3> result;
  result.reserve(input_index.size());
  for (const Index i : input_index) result.push_back(points[i]);
  return result;
}

std::vector<Index> PointCloud::input_indices() const {
  std::vector<Index> indices = input_index;
  for (const NearCopy& pair : conditioning.near_copies) indices.push_back(pair.copy);
  return indices;
}

double PointCloud::spacing_beside(Index sample) const {
  std::vector<float> around;
  const Index* list = neighbours_of(sample);
  for (int e = 0; e < neighbour_count; ++e) around.push_back(local_spacing[list[e]]);
  const auto median = around.begin() + neighbour_count / 2;
  std::nth_element(around.begin(), median, around.end());
  return std::max(spacing, static_cast<double>(std::min(*median, local_spacing[sample])));
}

}  // namespace shrinkwrap
