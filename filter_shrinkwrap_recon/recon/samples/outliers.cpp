#include "samples/outliers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/parallel.h"
#include "common/shared_sets.h"
#include "geometry/widest_turn.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr int kUsual = SampleOptions::kUsualNeighbours;
constexpr int kJoinedNeighbours = 6;  // of a core sample, before the small sets are looked at again
constexpr Index kLeastSamples = 64;   // fewer tell nothing of what is dense
constexpr double kOwnRoughness =
    1.1;  // a single neighbourhood may be a little rougher than the mean
// A sample at height h over a patch has no neighbour within that, but for other strays, and lifts
// the deviation of its neighbourhood of k to about h / sqrt(k).
constexpr double kGapOfHeight = 0.8, kDeviationOfHeight = 0.6;
// x spacing: the foot of a sample in the plane of its neighbours has those nearer to it on no side.
constexpr double kBesideFoot = 0.5;
constexpr double kHeightInPlane = 0.5;  // x that of the sample: neighbours in the plane, at most
constexpr int kRingsGoneOn = 2;
constexpr double kUsualRadius = 2.2;  // spacings to the farthest of 16 neighbours
// x median spacing: no sample reaches farther than if it were so isolated.
constexpr double kGreatestSpacing = 4.0;

class OutlierSearch {
 public:
  OutlierSearch(const PointCloud& cloud, const OutlierOptions& options, Progress& progress)
      : cloud_(cloud), options_(options), progress_(progress) {}

  std::vector<Index> find() {
    mark_core();
    join_core();
    join_small_sets();
    measure_sets();
    dissolve_hazes();
    attach_others();
    return collect();
  }

 private:
  bool are_within(double reach, Index a, Index b) const {
    const double distance =
        widening_ * reach * std::min(cloud_.local_spacing[a], cloud_.local_spacing[b]);
    return (cloud_.position[a] - cloud_.position[b]).squaredNorm() <= distance * distance;
  }

  double roughness(Index sample) const {
    return cloud_.deviation[sample] / (spacings_per_radius_ * cloud_.local_spacing[sample]);
  }

  // Core samples hold others.
  void mark_core() {
    core_.assign(cloud_.position.size(), 0);
    parallel_for_each(cloud_.size(), kGrain, progress_,
                      [&](Index i) { core_[i] = is_dense(i) && !is_haze(i); });
  }

  // As dense as most of its neighbours.
  bool is_dense(Index sample) const {
    const Index* list = cloud_.neighbours_of(sample);
    const float least = cloud_.local_spacing[sample] / static_cast<float>(options_.least_alike);
    int alike = 0;
    for (int e = 1; e < cloud_.neighbour_count; ++e)
      alike += cloud_.local_spacing[list[e]] >= least;
    return 2 * alike >= cloud_.neighbour_count - 1;
  }

  // Stray points all over a box are as dense as their neighbours where these are stray too, but
  // sparse, and not in planes.
  bool is_haze(Index sample) const {
    const double spacing = cloud_.local_spacing[sample];
    if (spacing <= options_.sparse * cloud_.spacing) return false;
    const Index* list = cloud_.neighbours_of(sample);
    const double gap = options_.gap * spacing;
    if ((cloud_.position[list[1]] - cloud_.position[sample]).squaredNorm() > gap * gap) return true;
    if (roughness(sample) > kOwnRoughness * options_.roughness) return true;
    double sum = 0.0;
    for (int e = 0; e < cloud_.neighbour_count; ++e) sum += roughness(list[e]);
    return sum > options_.roughness * cloud_.neighbour_count;
  }

  void join_core() {
    parallel_for_each(cloud_.size(), kGrain, progress_, [&](Index i) {
      if (!core_[i]) return;
      const Index* list = cloud_.neighbours_of(i);
      for (int e = 1; e <= kJoinedNeighbours; ++e)
        if (core_[list[e]] && are_within(options_.reach, i, list[e])) sets_.unite(i, list[e]);
    });
    count_sets();
  }

  void count_sets() {
    size_.assign(cloud_.position.size(), 0);
    for (Index i = 0; i < cloud_.size(); ++i)
      if (core_[i]) ++size_[sets_.find(i)];
  }
  bool is_large(Index core_sample) { return size_[sets_.find(core_sample)] >= smallest_; }

  // Of small sets, all that they hold together with is searched, in the neighbour lists or not.
  void join_small_sets() {
    std::vector<Index> set(cloud_.position.size(), kNone), small;
    for (Index i = 0; i < cloud_.size(); ++i) {
      if (!core_[i]) continue;
      set[i] = sets_.find(i);
      if (size_[set[i]] < smallest_) small.push_back(i);
    }
    std::vector<Index> other(small.size(), kNone);
    parallel_for_each(static_cast<Index>(small.size()), kGrain / 16, progress_, [&](Index n) {
      const Index own = set[small[n]];
      other[n] = nearest_within(options_.reach, small[n],
                                [&](Index j) { return core_[j] && set[j] != own; });
    });
    for (std::size_t n = 0; n < small.size(); ++n)
      if (other[n] != kNone) sets_.unite(small[n], other[n]);
    count_sets();
  }

  void measure_sets() {
    roughness_of_.assign(cloud_.position.size(), 0.0);
    spacing_of_.assign(cloud_.position.size(), 0.0);
    for (Index i = 0; i < cloud_.size(); ++i) {
      if (!core_[i]) continue;
      const Index set = sets_.find(i);
      roughness_of_[set] += roughness(i);
      spacing_of_[set] += cloud_.local_spacing[i];
    }
    for (Index set = 0; set < cloud_.size(); ++set) {
      if (size_[set] == 0) continue;
      roughness_of_[set] /= size_[set];
      spacing_of_[set] /= size_[set];
    }
  }
  // Whether a set, by its root, is a part of a surface, however small, if it is near the rest.
  bool is_flat_and_dense(Index set) const {
    return size_[set] > 0 && roughness_of_[set] <= options_.roughness &&
           spacing_of_[set] <= options_.spacing_of_flat_sets * cloud_.spacing;
  }

  // Of many stray points far apart, some are core samples by chance, and hold each other.
  void dissolve_hazes() {
    std::vector<Index> hazes;
    Index samples = 0;
    for (Index set = 0; set < cloud_.size(); ++set)
      if (spacing_of_[set] > options_.spacing_of_haze * cloud_.spacing &&
          roughness_of_[set] > options_.roughness_of_haze) {
        hazes.push_back(set);
        samples += size_[set];
      }
    if (samples < options_.part_of_hazes * cloud_.size())
      for (const Index set : hazes) size_[set] = 0;
  }

  // Samples that hold no others belong to the large sets near them, and so may small sets, to which
  // others belong in turn.
  void attach_others() {
    kept_.assign(cloud_.position.size(), 0);
    for (Index i = 0; i < cloud_.size(); ++i) kept_[i] = core_[i] && is_large(i);
    holds_ = kept_;
    keep_those_held();
    keep_more([&](Index i) { return !core_[i] && is_held_beyond(i); });
    keep_flat_sets();
    keep_more([&](Index i) { return is_supported(i); });
    for (int ring = 0; ring < kRingsGoneOn; ++ring) keep_more([&](Index i) { return goes_on(i); });
    keep_sets_that_go_on();
    keep_those_held();
  }
  void keep_those_held() {
    keep_more([&](Index i) { return !core_[i] && is_held(i); });
  }

  // Keeps small sets that are flat, dense, and near for their width, or by the spacing of most, to
  // samples that are kept.
  void keep_flat_sets() {
    struct Set {
      Vec3 centre = Vec3::Zero();
      double radius = 0.0;
      bool is_near = false;
    };
    std::vector<Index> place(cloud_.position.size(), kNone);  // in `sets`, of their roots
    std::vector<Index> sample;
    std::vector<Set> sets;
    for (Index i = 0; i < cloud_.size(); ++i) {
      if (kept_[i] || !core_[i]) continue;
      const Index root = sets_.find(i);
      if (size_[root] < kUsual || !is_flat_and_dense(root)) continue;
      if (place[root] == kNone) {
        place[root] = static_cast<Index>(sets.size());
        sets.emplace_back();
      }
      sets[place[root]].centre += cloud_.position[i] / size_[root];
      sample.push_back(i);
    }
    const auto set_of = [&](Index i) -> Set& { return sets[place[sets_.find(i)]]; };
    for (const Index i : sample) {
      Set& set = set_of(i);
      set.radius = std::max(set.radius, (cloud_.position[i] - set.centre).norm());
    }
    const auto is_kept = [&](Index j) { return kept_[j] != 0; };
    for (const Index i : sample) {
      Set& set = set_of(i);
      if (set.is_near) continue;
      const double reach = std::max(options_.reach_of_flat_sets * 2.0 * set.radius,
                                    options_.gap_of_flat_sets * cloud_.spacing);
      set.is_near = cloud_.search.nearest_if(cloud_.position[i], reach, is_kept).index != kNone;
    }
    for (const Index i : sample)
      if (set_of(i).is_near) kept_[i] = 1;
  }

  // Keeps small sets of which some samples go on the surface, if they are flat and dense. Like
  // large ones, all sets that are kept then hold others.
  void keep_sets_that_go_on() {
    std::vector<char> has_kept(cloud_.position.size(), 0);  // at the root
    for (Index i = 0; i < cloud_.size(); ++i)
      if (core_[i] && kept_[i]) has_kept[sets_.find(i)] = 1;
    for (Index i = 0; i < cloud_.size(); ++i) {
      if (!core_[i]) continue;
      const Index root = sets_.find(i);
      if (has_kept[root] && is_flat_and_dense(root)) kept_[i] = holds_[i] = 1;
    }
  }

  // Keeps those of the samples left over of which `belongs` says so, all at once.
  template <class Belongs>
  void keep_more(const Belongs& belongs) {
    std::vector<Index> left;
    for (Index i = 0; i < cloud_.size(); ++i)
      if (!kept_[i]) left.push_back(i);
    std::vector<char> keep(left.size(), 0);
    parallel_for_each(static_cast<Index>(left.size()), kGrain / 16, progress_,
                      [&](Index n) { keep[n] = belongs(left[n]); });
    for (std::size_t n = 0; n < left.size(); ++n) kept_[left[n]] = keep[n];
  }

  // Whether a sample lies in the planes of most of its neighbours, these are kept, and it is within
  // their surface, or not far beyond its edge.
  bool is_supported(Index sample) const {
    const Index* list = cloud_.neighbours_of(sample);
    Index nearest = kNone;  // that is kept
    int support = 0;
    Vec3 towards_kept = Vec3::Zero();
    for (int e = 1; e < cloud_.neighbour_count; ++e) {
      if (!kept_[list[e]]) continue;
      if (nearest == kNone) nearest = list[e];
      const Vec3 d = cloud_.position[list[e]] - cloud_.position[sample];
      towards_kept += d;
      support += is_in_plane(d, list[e], options_.slope);
    }
    if (nearest == kNone || support < options_.support * (cloud_.neighbour_count - 1)) return false;
    const double distance = (cloud_.position[nearest] - cloud_.position[sample]).norm();
    if (distance <= options_.gap_at_edge * cloud_.local_spacing[nearest]) return true;
    const auto goes_on_beyond = [&](Index other) {
      const Vec3 d = cloud_.position[other] - cloud_.position[sample];
      return other != sample && d.dot(towards_kept) <= 0.0 &&
             is_in_plane(d, nearest, options_.slope_beyond_edge);
    };
    return cloud_.search
               .nearest_if(cloud_.position[sample], options_.reach_beyond_edge * distance,
                           goes_on_beyond)
               .index != kNone;
  }
  // Whether two places `d` apart lie in one plane parallel to that of a sample, by the slope.
  bool is_in_plane(const Vec3& d, Index of_sample, double slope) const {
    const double height = d.dot(cloud_.normal[of_sample].cast<double>());
    return height * height <= slope * slope * d.squaredNorm();
  }

  // Whether a sample goes on a surface, by the spacing and the plane of the sample there: a patch
  // of close samples among wide ones is detached if measured by its own spacing, and the sparsest
  // part of a surface looks like a haze.
  bool goes_on(Index sample) const {
    const Vec3& p = cloud_.position[sample];
    const auto is_near = [&](Index other) {
      const double distance = options_.reach_going_on * cloud_.local_spacing[other];
      return kept_[other] && (cloud_.position[other] - p).squaredNorm() <= distance * distance;
    };
    const Index near =
        cloud_.search
            .nearest_if(p, options_.reach_going_on * kGreatestSpacing * cloud_.spacing, is_near)
            .index;
    if (near == kNone) return false;
    const double height =
        std::abs((p - cloud_.position[near]).dot(cloud_.normal[near].cast<double>()));
    return height <= options_.slope * cloud_.local_spacing[near];
  }

  // The nearest sample that `accept` is true of, no farther than `reach` times the smaller of the
  // two spacings.
  template <class Accept>
  Index nearest_within(double reach, Index sample, const Accept& accept) const {
    const auto is_near = [&](Index other) {
      return other != sample && accept(other) && are_within(reach, sample, other);
    };
    return cloud_.search
        .nearest_if(cloud_.position[sample], widening_ * reach * cloud_.local_spacing[sample],
                    is_near)
        .index;
  }
  bool is_held(Index sample) const {
    return nearest_within(options_.reach_of_others, sample, [&](Index other) {
             return holds_[other] && is_beside(sample, other);
           }) != kNone;
  }
  bool is_held_beyond(Index sample) const {
    return nearest_within(options_.reach_beyond, sample,
                          [&](Index other) { return kept_[other] != 0; }) != kNone;
  }
  // Whether a sample is near another, or as near to its plane as surfaces and noise bring it.
  bool is_beside(Index sample, Index other) const {
    const Vec3 d = cloud_.position[sample] - cloud_.position[other];
    const double near = widening_ * options_.reach_off_plane * cloud_.local_spacing[other];
    if (d.squaredNorm() <= near * near) return true;
    const double height = std::abs(d.dot(cloud_.normal[other].cast<double>()));
    return height <= std::max(options_.slope_of_others * d.norm(),
                              options_.deviations_of_others * cloud_.deviation[other]);
  }

  // Whether a sample lies in the planes of some of its neighbours. By the slope it would, however
  // high over them, if they are far enough away: so only as many are asked as are usual.
  bool is_corner(Index sample) const {
    const Index* list = cloud_.neighbours_of(sample);
    int planes = 0, kept = 0;
    for (int e = 1; e < kUsual; ++e) {
      if (!kept_[list[e]]) continue;
      ++kept;
      planes +=
          is_in_plane(cloud_.position[list[e]] - cloud_.position[sample], list[e], options_.slope);
    }
    return planes >= options_.planes_of_corner * kept;
  }

  // Whether a sample juts out of the plane of its neighbours: of a flat, dense patch around it. No
  // corner far from the rest does, which lies in the planes of the faces that lead to it.
  bool juts_out(Index sample) const {
    const Index* list = cloud_.neighbours_of(sample);
    const double gap = (cloud_.position[list[1]] - cloud_.position[sample]).norm();
    const double least_height = options_.height * cloud_.local_spacing[list[1]];
    if (gap < kGapOfHeight * least_height ||
        cloud_.deviation[sample] * std::sqrt(cloud_.neighbour_count) <
            kDeviationOfHeight * least_height ||
        is_corner(sample))
      return false;
    std::vector<Index> near;
    for (int e = 1; e < cloud_.neighbour_count; ++e)
      if (kept_[list[e]]) near.push_back(list[e]);
    if (2 * static_cast<int>(near.size()) < cloud_.neighbour_count) return false;
    const double spacing = median_spacing(near);
    const auto stands_over = [&](const Plane& plane, double spacings, double deviations) {
      const double height = std::abs((cloud_.position[sample] - plane.point).dot(plane.normal));
      return height > spacings * spacing && height > deviations * plane.deviation &&
             is_surrounded(sample, plane, height, near, kBesideFoot * spacing);
    };
    return stands_over(fitted_plane(near), options_.height, options_.height_deviations) ||
           (spacing >= options_.least_robust_spacing * cloud_.spacing &&
            stands_over(robust_plane(near), options_.robust_height, options_.robust_deviations));
  }

  struct Plane {
    Vec3 point, normal;
    double deviation;  // how far samples are from it: root mean square, or a quantile
  };
  // The plane of least squares.
  Plane fitted_plane(const std::vector<Index>& samples) const {
    const Vec3& origin = cloud_.position[samples.front()];
    Vec3 sum = Vec3::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const Index i : samples) {
      const Vec3 d = cloud_.position[i] - origin;
      sum += d;
      squares += d * d.transpose();
    }
    const double count = static_cast<double>(samples.size());
    const Vec3 mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(squares / count -
                                                                mean * mean.transpose());
    return {origin + mean, solver.eigenvectors().col(0),
            std::sqrt(std::max(solver.eigenvalues()[0], 0.0))};
  }
  // Of the samples' own planes the one of least quantile of squares (Rousseeuw and Leroy 1987):
  // stray ones among them tilt it less.
  Plane robust_plane(const std::vector<Index>& samples) const {
    Plane best{Vec3::Zero(), Vec3::Zero(), std::numeric_limits<double>::infinity()};
    std::vector<double> height(samples.size());
    const auto quantile =
        height.begin() +
        static_cast<std::ptrdiff_t>(options_.quantile * static_cast<double>(samples.size() - 1));
    for (const Index i : samples) {
      const Plane plane{cloud_.position[i], cloud_.normal[i].cast<double>(), 0.0};
      std::transform(samples.begin(), samples.end(), height.begin(), [&](Index j) {
        return std::abs((cloud_.position[j] - plane.point).dot(plane.normal));
      });
      std::nth_element(height.begin(), quantile, height.end());
      if (*quantile < best.deviation) best = {plane.point, plane.normal, *quantile};
    }
    return best;
  }

  double median_spacing(const std::vector<Index>& samples) const {
    std::vector<float> spacing;
    for (const Index i : samples) spacing.push_back(cloud_.local_spacing[i]);
    const auto middle = spacing.begin() + static_cast<std::ptrdiff_t>(spacing.size() / 2);
    std::nth_element(spacing.begin(), middle, spacing.end());
    return *middle;
  }

  // Whether those neighbours of a sample at some height over a plane that lie about in it are all
  // around, farther than `beside` from its foot.
  bool is_surrounded(Index sample, const Plane& plane, double height,
                     const std::vector<Index>& near, double beside) const {
    const Vec3 across = plane.normal.unitOrthogonal(), along = plane.normal.cross(across);
    std::vector<double> directions;
    for (const Index i : near) {
      const Vec3 d = cloud_.position[i] - cloud_.position[sample];
      const double x = d.dot(across), y = d.dot(along);
      const double off_plane = (cloud_.position[i] - plane.point).dot(plane.normal);
      if (std::abs(off_plane) <= kHeightInPlane * height && std::hypot(x, y) >= beside)
        directions.push_back(std::atan2(y, x));
    }
    return widest_turn(std::move(directions)) < options_.widest_turn;
  }

  std::vector<Index> collect() {
    return parallel_collect<Index>(cloud_.size(), kGrain, progress_,
                                   [&](Index begin, Index end, std::vector<Index>& out) {
                                     for (Index i = begin; i < end; ++i)
                                       if (!kept_[i] || juts_out(i)) out.push_back(i);
                                   });
  }

  const PointCloud& cloud_;
  const OutlierOptions& options_;
  Progress& progress_;
  // A disc of radius r around a sample holds the k - 1 others: spacing s = r sqrt(pi / (k - 1)).
  const double spacings_per_radius_ = std::sqrt((cloud_.neighbour_count - 1) / kPi);
  // Where samples lie on lines, the lines beside are as far as the farthest neighbours, which are
  // more spacings away the more neighbours it takes.
  const double widening_ =
      cloud_.conditioning.on_lines ? std::max(1.0, spacings_per_radius_ / kUsualRadius) : 1.0;
  const Index smallest_ = std::min(options_.smallest_set, std::max<Index>(cloud_.size() / 100, 4));
  std::vector<char> core_, kept_;
  std::vector<char> holds_;  // core samples that are kept with their sets
  SharedSets sets_{cloud_.size(), progress_};
  // Of the sets, each at its root: how many core samples, and their mean roughness and spacing.
  std::vector<Index> size_;
  std::vector<double> roughness_of_, spacing_of_;
};

}  // namespace

std::vector<Index> find_outliers(const PointCloud& cloud, const OutlierOptions& options,
                                 Progress& progress) {
  if (cloud.size() < kLeastSamples) return {};
  return OutlierSearch(cloud, options, progress).find();
}

void leave_out_copies(PointCloud& cloud, OutlierReport& report) {
  std::vector<Index> originals = report.input_index;
  std::sort(originals.begin(), originals.end());
  std::vector<NearCopy>& copies = cloud.conditioning.near_copies;
  const auto is_left_out = [&](const NearCopy& pair) {
    return std::binary_search(originals.begin(), originals.end(), pair.original);
  };
  for (const NearCopy& pair : copies)
    if (is_left_out(pair)) report.input_index.push_back(pair.copy);
  copies.erase(std::remove_if(copies.begin(), copies.end(), is_left_out), copies.end());
}

namespace {

OutlierReport exclude_from(PointCloud& cloud, const std::vector<Vec3>& points,
                           const OutlierOptions& options, Progress& progress) {
  OutlierReport report;
  std::vector<Index> stray = find_outliers(cloud, options, progress);
  report.rounds = 1;
  if (stray.empty()) return report;

  const std::size_t most = static_cast<std::size_t>(options.most * cloud.position.size());
  SampleOptions as_before;  // what is left lies on lines, or not, as all did
  as_before.neighbours = cloud.neighbour_count;
  as_before.scan_lines.most_neighbours = 0;
  as_before.near_copies.enabled = false;
  const bool on_lines = cloud.conditioning.on_lines;
  PointCloud rest;
  std::vector<Index> input_index;  // of the points that are left
  const auto leave_out = [&](const PointCloud& from) {
    std::vector<char> is_stray(from.position.size(), 0);
    for (const Index i : stray) {
      is_stray[i] = 1;
      report.input_index.push_back(from.input_index[i]);
    }
    input_index.clear();
    for (Index i = 0; i < from.size(); ++i)
      if (!is_stray[i]) input_index.push_back(from.input_index[i]);
    std::sort(input_index.begin(), input_index.end());
  };
  for (leave_out(cloud);; leave_out(rest)) {
    report.suspected = static_cast<Index>(report.input_index.size());
    if (report.input_index.size() > most) {
      report.input_index.clear();
      return report;
    }
    try {
      rest = prepare_samples(points_at(points, input_index), as_before, progress);
      rest.conditioning.on_lines = on_lines;
    } catch (const InvalidInput&) {
      report.input_index.clear();
      return report;
    }
    progress.begin(Stage::outliers);
    for (Index& i : rest.input_index) i = input_index[i];
    if (report.rounds == options.most_rounds) break;
    stray = find_outliers(rest, options, progress);
    ++report.rounds;
    if (stray.empty()) break;
  }
  const double step = rest.conditioning.coordinate_step;  // strays may be farther from the origin
  rest.conditioning = cloud.conditioning;
  rest.conditioning.coordinate_step = step;
  cloud = std::move(rest);
  leave_out_copies(cloud, report);
  return report;
}

}  // namespace

OutlierReport exclude_outliers(PointCloud& cloud, const std::vector<Vec3>& points,
                               const OutlierOptions& options, Progress& progress,
                               const FarStrays& far_strays) {
  progress.begin(Stage::outliers);
  // The limits are of as many neighbours as are usual, whatever number was asked for. Samples on
  // lines may need more.
  OutlierReport report;
  if (cloud.size() >= kLeastSamples) {
    const int before = cloud.neighbour_count;
    const int searched = std::max(cloud.conditioning.on_lines ? before : 0, kUsual);
    if (searched != before) measure_neighbourhoods(cloud, searched, progress);
    report = exclude_from(cloud, points, options, progress);
    if (searched != before) measure_neighbourhoods(cloud, before, progress);
  }
  report.suspected += static_cast<Index>(far_strays.distinct.size());
  std::vector<Index>& all = report.input_index;
  all.insert(all.end(), far_strays.distinct.begin(), far_strays.distinct.end());
  std::sort(all.begin(), all.end());
  return report;
}

}  // namespace shrinkwrap
