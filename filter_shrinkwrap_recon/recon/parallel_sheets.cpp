#include "parallel_sheets.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <bitset>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kMostNeighbours = 64;
constexpr int kMostRounds = 6;
constexpr double kHopeless = 0.5;

using Matrix = Eigen::Matrix3d;
using Principal = Eigen::SelfAdjointEigenSolver<Matrix>;
using Side = std::bitset<kMostNeighbours>;

// The neighbours of one sample, about their mean; lengths in its spacing.
class Neighbourhood {
 public:
  Neighbourhood(const PointCloud& cloud, Index sample)
      : count_(std::min(cloud.neighbour_count, kMostNeighbours)) {
    const Index* list = cloud.neighbours_of(sample);
    Vec3 mean = Vec3::Zero();
    for (int k = 0; k < count_; ++k) {
      offset_[k] = (cloud.position[list[k]] - cloud.position[sample]) / cloud.local_spacing[sample];
      mean += offset_[k];
    }
    mean /= count_;
    squares_ = Matrix::Zero();
    for (int k = 0; k < count_; ++k) {
      offset_[k] -= mean;
      squares_ += offset_[k] * offset_[k].transpose();
    }
    principal_.computeDirect(squares_);
  }

  // The common normal of two planes that fit far better than one; else zero.
  Vec3 normal_of_sheets(const ParallelSheetsOptions& options) const {
    Vec3 best = Vec3::Zero();
    double least = options.most_variance * principal_.eigenvalues()[0];
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 normal = principal_.eigenvectors().col(axis);
      Side above = side_above(normal);
      for (int round = 0; round < kMostRounds; ++round) {
        const int members = static_cast<int>(above.count());
        if (std::min(members, count_ - members) < options.least_samples) break;
        Principal within;
        within.computeDirect(about_own_means(above));
        const Vec3 variance = within.eigenvalues();
        normal = within.eigenvectors().col(0);
        if (variance[0] < least && variance[1] > options.least_width * variance[2]) {
          least = variance[0];
          best = normal;
        }
        if (variance[0] > kHopeless * principal_.eigenvalues()[0]) break;
        const Side next = side_above(normal);
        if (next == above) break;
        above = next;
      }
    }
    return best;
  }

 private:
  Side side_above(const Vec3& normal) const {
    Side above;
    for (int k = 0; k < count_; ++k) above[k] = offset_[k].dot(normal) > 0.0;
    return above;
  }
  // Sum over both sides of the squares about the mean of the side. Offsets about the mean of all
  // sum to nothing.
  Matrix about_own_means(const Side& above) const {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < count_; ++k)
      if (above[k]) sum += offset_[k];
    const double members = static_cast<double>(above.count());
    return squares_ - sum * sum.transpose() * (1.0 / members + 1.0 / (count_ - members));
  }

  int count_;
  std::array<Vec3, kMostNeighbours> offset_;
  Matrix squares_;
  Principal principal_;
};

}  // namespace

Index fit_parallel_sheets(PointCloud& cloud, const ParallelSheetsOptions& options,
                          Progress& progress) {
  return parallel_sum(cloud.size(), kGrain, progress, Index{0}, [&](Index begin, Index end) {
    Index replaced = 0;
    for (Index i = begin; i < end; ++i) {
      if (cloud.deviation[i] < options.least_deviation * cloud.local_spacing[i]) continue;
      const Vec3 normal = Neighbourhood(cloud, i).normal_of_sheets(options);
      if (!(normal.squaredNorm() > 0.5)) continue;
      cloud.normal[i] = normal.cast<float>();
      ++replaced;
    }
    return replaced;
  });
}

}  // namespace shrinkwrap
