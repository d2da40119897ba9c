#include "parallel_sheets.h"

#include <Eigen/Eigenvalues>
#include <array>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kMostNeighbours = 64;
constexpr int kMostRounds = 6;
// Of the variance about one plane. Noise that is halved keeps 0.36 of it: there are no two planes.
constexpr double kHopeless = 0.3;

// Of the search, along the principal axes of the neighbourhood and between any two.
const std::array<Vec3, 9> kStarts = {Vec3(1, 0, 0),  Vec3(0, 1, 0),  Vec3(0, 0, 1),
                                     Vec3(1, 1, 0),  Vec3(1, -1, 0), Vec3(1, 0, 1),
                                     Vec3(1, 0, -1), Vec3(0, 1, 1),  Vec3(0, 1, -1)};

using Matrix = Eigen::Matrix3d;
using Principal = Eigen::SelfAdjointEigenSolver<Matrix>;
using Offsets = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostNeighbours, 3>;
using Side = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostNeighbours, 1>;  // 1 for its members

// The neighbours of one point, about their mean; lengths in the radius of the neighbourhood.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Vec3>& points, const Neighbourhoods& all, std::size_t point)
      : offset_(std::min(all.k, kMostNeighbours), 3) {
    const Index* list = all.neighbour.data() + point * static_cast<std::size_t>(all.k);
    for (Eigen::Index k = 0; k < offset_.rows(); ++k)
      offset_.row(k) = (points[list[k]] - points[point]) / all.radius[point];
    offset_.rowwise() -= offset_.colwise().mean().eval();
    squares_ = offset_.transpose() * offset_;
    principal_.computeDirect(squares_);
  }

  // The common normal of two planes that fit far better than one; else zero.
  Vec3 normal_of_sheets(const ParallelSheetsOptions& options) const {
    Vec3 best = Vec3::Zero();
    const double of_one = principal_.eigenvalues()[0];
    double least = options.most_variance * of_one;
    for (const Vec3& start : kStarts) {
      Side above = side_above(principal_.eigenvectors() * start);
      for (int round = 0; round < kMostRounds; ++round) {
        const double members = above.sum();
        if (std::min(members, offset_.rows() - members) < options.least_points) break;
        const Matrix squares = about_own_means(above);
        // Of three eigenvalues the least is at least 4 x product / sum^2.
        const double sum = squares.trace();
        if (4.0 * squares.determinant() > kHopeless * of_one * sum * sum) break;
        Principal within;
        within.computeDirect(squares);
        const double of_two = within.eigenvalues()[0];
        if (of_two > kHopeless * of_one) break;
        const Vec3 normal = within.eigenvectors().col(0);
        if (of_two < least && have_width(above, options.least_width)) {
          least = of_two;
          best = normal;
        }
        const Side next = side_above(normal);
        if (next == above) break;
        above = next;
      }
    }
    return best;
  }

 private:
  Side side_above(const Vec3& normal) const {
    return ((offset_ * normal).array() > 0.0).cast<double>();
  }
  // Sum over both sides of the squares about the mean of the side. Offsets about the mean of all
  // sum to nothing.
  Matrix about_own_means(const Side& above) const {
    const Vec3 sum = offset_.transpose() * above;
    const double members = above.sum();
    return squares_ - sum * sum.transpose() * (1.0 / members + 1.0 / (offset_.rows() - members));
  }
  // Whether neither side lies on a line.
  bool have_width(const Side& above, double least_width) const {
    const Side below = 1.0 - above.array();
    for (const Side& side : {above, below}) {
      const Vec3 sum = offset_.transpose() * side;
      const Matrix squares = offset_.transpose() * side.asDiagonal() * offset_;
      Principal own;
      own.computeDirect(squares - sum * sum.transpose() / side.sum(), Eigen::EigenvaluesOnly);
      if (!(own.eigenvalues()[1] > least_width * own.eigenvalues()[2])) return false;
    }
    return true;
  }

  Offsets offset_;
  Matrix squares_;
  Principal principal_;
};

}  // namespace

Index fit_parallel_sheets(const std::vector<Vec3>& points, Neighbourhoods& neighbourhoods,
                          const ParallelSheetsOptions& options, Progress& progress) {
  const auto count = static_cast<Index>(points.size());
  return parallel_sum(count, kGrain, progress, Index{0}, [&](Index begin, Index end) {
    Index replaced = 0;
    for (Index i = begin; i < end; ++i) {
      const double radius = neighbourhoods.radius[i];
      if (!(neighbourhoods.deviation[i] > options.least_deviation * radius)) continue;
      const Vec3 normal = Neighbourhood(points, neighbourhoods, static_cast<std::size_t>(i))
                              .normal_of_sheets(options);
      if (normal.isZero()) continue;
      neighbourhoods.normal[i] = normal.cast<float>();
      ++replaced;
    }
    return replaced;
  });
}

}  // namespace shrinkwrap
