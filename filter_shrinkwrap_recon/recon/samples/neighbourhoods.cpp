#include "samples/neighbourhoods.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGroupPoints = 32;  // points that share one gathering, at most
constexpr Index kGroupsPerBlock =
    64;  // a block starts from scratch, so that blocks are independent
constexpr int kGatheredPerNeighbour = 16;  // at most: a radius that gathers more is shrunk
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The unit eigenvector to the smallest eigenvalue of a symmetric matrix with non-negative
// eigenvalues and trace 1, without a transcendental function. Up to the smallest root the
// characteristic polynomial rises and is concave, so that Newton's iteration from 0 rises to that
// root; the eigenvector is then normal to all rows. False where two eigenvalues nearly coincide.
bool find_least_eigenvector(const Eigen::Matrix3d& m, double& eigenvalue, Vec3& eigenvector) {
  constexpr int kMostIterations = 12;
  constexpr double kConverged = 1e-14;
  constexpr double kLeastGap = 1e-5;  // product of the distances to the other eigenvalues
  const double xx = m(0, 0), xy = m(0, 1), xz = m(0, 2), yy = m(1, 1), yz = m(1, 2), zz = m(2, 2);
  const double minors = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz;
  const double determinant =
      xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy);
  double root = 0.0, step = 1.0;
  for (int iteration = 0; step > kConverged; ++iteration) {
    const double value = ((root - 1.0) * root + minors) * root - determinant;
    const double slope = (3.0 * root - 2.0) * root + minors;
    if (iteration == kMostIterations || !(slope > 0.0)) return false;
    step = -value / slope;
    root += step;
  }
  const Vec3 row_x(xx - root, xy, xz), row_y(xy, yy - root, yz), row_z(xz, yz, zz - root);
  const Vec3 candidates[] = {row_x.cross(row_y), row_x.cross(row_z), row_y.cross(row_z)};
  double longest = 0.0;
  for (const Vec3& candidate : candidates) {
    const double squared_length = candidate.squaredNorm();
    if (squared_length <= longest) continue;
    longest = squared_length;
    eigenvector = candidate;
  }
  if (!(longest > kLeastGap * kLeastGap)) return false;
  eigenvector /= std::sqrt(longest);
  eigenvalue = root;
  return true;
}

struct FittedPlane {
  Vec3f normal = Vec3f::UnitZ();
  float deviation = 0.0f;  // of the points, root mean square
};

// The plane through the mean of points that fits them best. Sums about an origin near them.
class PlaneFit {
 public:
  void add(double x, double y, double z) {
    ++count_;
    x_ += x;
    y_ += y;
    z_ += z;
    xx_ += x * x;
    xy_ += x * y;
    xz_ += x * z;
    yy_ += y * y;
    yz_ += y * z;
    zz_ += z * z;
  }
  FittedPlane plane() const {
    const double mx = x_ / count_, my = y_ / count_, mz = z_ / count_;
    Eigen::Matrix3d covariance;
    covariance(0, 0) = xx_ - x_ * mx;
    covariance(1, 1) = yy_ - y_ * my;
    covariance(2, 2) = zz_ - z_ * mz;
    covariance(0, 1) = covariance(1, 0) = xy_ - x_ * my;
    covariance(0, 2) = covariance(2, 0) = xz_ - x_ * mz;
    covariance(1, 2) = covariance(2, 1) = yz_ - y_ * mz;
    const double trace = covariance.trace();
    if (!(trace > 1e-280)) return {};  // all in one place
    covariance *= 1.0 / trace;
    double eigenvalue = 0.0;
    Vec3 normal;
    if (!find_least_eigenvector(covariance, eigenvalue, normal)) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
      eigenvalue = solver.eigenvalues()[0];
      normal = solver.eigenvectors().col(0);
    }
    const double variance = std::max(eigenvalue, 0.0) * trace / count_;
    return {normal.cast<float>(), static_cast<float>(std::sqrt(variance))};
  }

 private:
  int count_ = 0;
  double x_ = 0.0, y_ = 0.0, z_ = 0.0;
  double xx_ = 0.0, xy_ = 0.0, xz_ = 0.0, yy_ = 0.0, yz_ = 0.0, zz_ = 0.0;
};

// The points around one voxel, and the selection of the nearest among them. One per block.
class Gathering {
 public:
  explicit Gathering(int k) : k_(k) {}

  // Gathers all points within `radius` of the box of a group. False: more than fit.
  bool gather(const VoxelSearch& search, const Vec3& low, const Vec3& high, double radius) {
    origin_ = 0.5 * (low + high);
    count_ = 0;
    const std::size_t most = static_cast<std::size_t>(k_ * kGatheredPerNeighbour + kGroupPoints);
    bool fits = true;
    search.for_each_near_box(low, high, radius, [&](VoxelSearch::Range range) {
      const std::size_t end = count_ + static_cast<std::size_t>(range.end - range.begin);
      fits = end <= most;
      if (!fits) return false;
      if (end + 4 > x_.size()) resize(2 * end + 4);
      for (Index i = range.begin; i < range.end; ++i, ++count_) {
        const Vec3 p = search.ordered_points()[i] - origin_;
        x_[count_] = static_cast<float>(p.x());
        y_[count_] = static_cast<float>(p.y());
        z_[count_] = static_cast<float>(p.z());
        order_[count_] = i;
      }
      return true;
    });
    return fits;
  }

  std::size_t size() const { return count_; }

  // Selects the k nearest of the gathered points around the point at position `self` of the order.
  // False if fewer than k lie within `radius`, the distance up to which the gathering is complete.
  bool select(Index self, float radius) {
    const std::size_t me = static_cast<std::size_t>(
        std::lower_bound(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count_),
                         self) -
        order_.begin());
    const float qx = x_[me], qy = y_[me], qz = z_[me];
    const float* x = x_.data();
    const float* y = y_.data();
    const float* z = z_.data();
    float* d = distance_.data();
    for (std::size_t j = 0; j < count_; ++j) {
      const float dx = x[j] - qx, dy = y[j] - qy, dz = z[j] - qz;
      d[j] = dx * dx + dy * dy + dz * dz;
    }
    d[me] = -1.0f;  // the point itself comes first, whoever shares its place
    const float complete = radius * radius;
    float threshold = std::min(complete, guess_);
    for (;;) {
      near_count_ = 0;
      for (std::size_t j = 0; j < count_; ++j) {
        near_[near_count_] = static_cast<std::int32_t>(j);
        near_count_ += d[j] <= threshold;
      }
      if (near_count_ >= static_cast<std::size_t>(k_)) break;
      if (threshold >= complete) return false;
      threshold = std::min(complete, threshold * 1.6f);
    }
    rank();
    guess_ = std::max(d[nearest_[static_cast<std::size_t>(k_) - 1]] * 1.25f, 1e-37f);
    return true;
  }

  // Results of the last successful selection.
  Index position_in_order(int entry) const { return order_[nearest_[entry]]; }
  float radius() const { return std::sqrt(std::max(distance_[nearest_[k_ - 1]], 0.0f)); }
  FittedPlane plane() const {
    PlaneFit fit;
    const float *x = x_.data(), *y = y_.data(), *z = z_.data();
    const std::int32_t me = nearest_[0];
    for (int entry = 0; entry < k_; ++entry) {
      const std::int32_t j = nearest_[entry];
      fit.add(static_cast<double>(x[j]) - x[me], static_cast<double>(y[j]) - y[me],
              static_cast<double>(z[j]) - z[me]);
    }
    return fit.plane();
  }

  void set_guess(float radius) { guess_ = std::max(radius * radius * 1.25f, 1e-37f); }

 private:
  void resize(std::size_t size) {
    for (auto* array : {&x_, &y_, &z_, &distance_, &near_distance_}) array->resize(size);
    order_.resize(size);
    near_.resize(size);
    nearest_.resize(size);
  }

  // Sorts the candidates by counting, for each, how many are nearer: no branch to mispredict.
  void rank() {
    const std::size_t m = near_count_;
    for (std::size_t a = 0; a < m; ++a) near_distance_[a] = distance_[near_[a]];
    const std::size_t padded = (m + 3) & ~std::size_t{3};
    for (std::size_t a = m; a < padded; ++a) near_distance_[a] = kInfinity;
    std::fill(nearest_.begin(), nearest_.begin() + static_cast<std::ptrdiff_t>(padded), -1);
    const float* d = near_distance_.data();
    for (std::size_t a = 0; a < m; ++a) {
      std::int32_t nearer = 0;
      for (std::size_t b = 0; b < padded; ++b) nearer += d[b] < d[a];
      while (nearest_[nearer] >= 0) ++nearer;  // equal distances: in order
      nearest_[nearer] = near_[a];
    }
  }

  int k_;
  Vec3 origin_ = Vec3::Zero();
  std::size_t count_ = 0, near_count_ = 0;
  float guess_ = kInfinity;
  std::vector<float> x_, y_, z_, distance_, near_distance_;
  std::vector<Index> order_;
  std::vector<std::int32_t> near_, nearest_;
};

// Finds the neighbourhoods of one block of groups.
class BlockSearch {
 public:
  BlockSearch(const std::vector<Vec3>& points, const VoxelSearch& search, Neighbourhoods& result)
      : points_(points), search_(search), result_(result), gathering_(result.k) {}

  void find(VoxelSearch::Range group) {
    if (group.end - group.begin > kGroupPoints || !gather(group)) {
      for (Index i = group.begin; i < group.end; ++i) find_exactly(i);
      return;
    }
    double sum = 0.0;
    for (Index i = group.begin; i < group.end; ++i) {
      if (gathering_.select(i, static_cast<float>(radius_))) {
        const Index point = search_.ordered_index()[i];
        Index* entry = entries_of(point);
        for (int e = 0; e < result_.k; ++e)
          entry[e] = search_.ordered_index()[gathering_.position_in_order(e)];
        result_.radius[point] = gathering_.radius();
        set_plane(point, gathering_.plane());
      } else {
        find_exactly(i);
      }
      sum += result_.radius[search_.ordered_index()[i]];
    }
    mean_radius_ = sum / (group.end - group.begin);
  }

 private:
  // Gathers what is near the group, within a radius that should hold the k nearest of its points:
  // that of the group before if it suits the density here, else the one of a point of this group.
  bool gather(VoxelSearch::Range group) {
    const auto& points = search_.ordered_points();
    Vec3 low = points[group.begin], high = low;
    for (Index i = group.begin + 1; i < group.end; ++i) {
      low = low.cwiseMin(points[i]);
      high = high.cwiseMax(points[i]);
    }
    const std::size_t enough = static_cast<std::size_t>(result_.k) * 2;
    if (mean_radius_ > 0.0) {
      radius_ = kMargin * mean_radius_;
      if (gathering_.gather(search_, low, high, radius_) && gathering_.size() >= enough)
        return true;
    }
    const Index middle = group.begin + (group.end - group.begin) / 2;
    find_exactly(middle);
    mean_radius_ = result_.radius[search_.ordered_index()[middle]];
    gathering_.set_guess(static_cast<float>(mean_radius_));
    radius_ = kMargin * mean_radius_;
    return mean_radius_ > 0.0 && gathering_.gather(search_, low, high, radius_);
  }

  void find_exactly(Index i) {
    const Vec3 origin = search_.ordered_points()[i];
    const Index point = search_.ordered_index()[i];
    search_.k_nearest(origin, result_.k, hits_);
    // Itself first: among more than k points at one place it may even be missing.
    std::size_t self = 0;
    while (self + 1 < hits_.size() && hits_[self].index != point) ++self;
    const VoxelSearch::Hit itself{point, 0.0};
    for (; self > 0; --self) hits_[self] = hits_[self - 1];
    hits_[0] = itself;
    Index* entry = entries_of(point);
    PlaneFit fit;
    for (int e = 0; e < result_.k; ++e) {
      entry[e] = hits_[e].index;
      const Vec3 p = points_[hits_[e].index] - origin;
      fit.add(p.x(), p.y(), p.z());
    }
    result_.radius[point] = static_cast<float>(std::sqrt(hits_[result_.k - 1].squared_distance));
    set_plane(point, fit.plane());
  }

  void set_plane(Index point, const FittedPlane& plane) {
    result_.normal[point] = plane.normal;
    result_.deviation[point] = plane.deviation;
  }

  static constexpr double kMargin = 1.35;

  Index* entries_of(Index point) {
    return result_.neighbour.data() + static_cast<std::size_t>(point) * result_.k;
  }

  const std::vector<Vec3>& points_;
  const VoxelSearch& search_;
  Neighbourhoods& result_;
  Gathering gathering_;
  std::vector<VoxelSearch::Hit> hits_;
  double mean_radius_ = 0.0;  // of the points of the group before
  double radius_ = 0.0;       // of the gathering
};

}  // namespace

Neighbourhoods find_neighbourhoods(const std::vector<Vec3>& points, const VoxelSearch& search,
                                   int k, Progress& progress) {
  Neighbourhoods result;
  const std::size_t count = points.size();
  result.k = static_cast<int>(std::min(static_cast<std::size_t>(k), count));
  result.neighbour.resize(count * static_cast<std::size_t>(result.k));
  result.radius.resize(count);
  result.normal.resize(count);
  result.deviation.resize(count);
  const std::vector<VoxelSearch::Range> groups = search.groups(kGroupPoints);
  parallel_blocks(static_cast<Index>(groups.size()), kGroupsPerBlock, progress,
                  [&](Index, Index begin, Index end) {
                    BlockSearch block(points, search, result);
                    for (Index g = begin; g < end; ++g) block.find(groups[g]);
                  });
  return result;
}

}  // namespace shrinkwrap
