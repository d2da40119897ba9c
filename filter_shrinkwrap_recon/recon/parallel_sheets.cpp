#include "parallel_sheets.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr int kMostNeighbours = 64;
constexpr int kNearest = 8;             // neighbours through which planes are tried
constexpr float kLeastSine = 0.3f;      // of the angle in which two of them are seen
constexpr int kRefinements = 2;         // of the plane with the most support
constexpr float kDistanceDecay = 1.5f;  // of the weights: exp(-1.5 r^2), r in [0, 1]
constexpr double kOfThree = 0.3;        // variance that three sheets may have, x that of two
constexpr double kLeastOwn = 4.0 / 16.0, kLeastBeside = 2.0 / 16.0;  // parts of the neighbours

double spacing_of(int neighbours) {
  return std::sqrt(kPi / neighbours);
}

using Offsets = Eigen::Array<float, 3, Eigen::Dynamic, 0, 3, kMostNeighbours>;
using Row = Eigen::Array<float, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostNeighbours>;

// Neighbours ordered by their height over a plane, any range of which may be a sheet.
class Heights {
 public:
  Heights(const Offsets& offset, const Row& height)
      : offset_(offset), height_(height), count_(static_cast<int>(height.cols())) {
    std::iota(order_.begin(), order_.begin() + count_, 0);
    std::sort(order_.begin(), order_.begin() + count_, [&](int a, int b) {
      return height_[a] != height_[b] ? height_[a] < height_[b] : a < b;
    });
  }
  int count() const { return count_; }
  double at(int place) const { return height_[order_[place]]; }
  int place_of_point() const {
    return static_cast<int>(std::find(order_.begin(), order_.begin() + count_, 0) - order_.begin());
  }
  // Sum of the squares of the heights about their mean.
  double squares(int begin, int end) const {
    double sum = 0.0, squares = 0.0;
    for (int place = begin; place < end; ++place) {
      sum += at(place);
      squares += at(place) * at(place);
    }
    return end > begin ? squares - sum * sum / (end - begin) : 0.0;
  }
  Vec3f mean(int begin, int end) const {
    Vec3f sum = Vec3f::Zero();
    for (int place = begin; place < end; ++place) sum += offset_.col(order_[place]).matrix();
    return sum / static_cast<float>(end - begin);
  }

 private:
  const Offsets& offset_;
  const Row& height_;
  int count_;
  std::array<int, kMostNeighbours> order_;
};

// The neighbours of one point, about it; lengths in the radius of the neighbourhood.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Vec3>& points, const Neighbourhoods& all, std::size_t point,
                const ParallelSheetsOptions& options)
      : options_(options), offset_(3, std::min(all.k, kMostNeighbours)) {
    const Index* list = all.neighbour.data() + point * static_cast<std::size_t>(all.k);
    const double scale = 1.0 / all.radius[point];
    for (Eigen::Index k = 0; k < offset_.cols(); ++k)
      offset_.col(k) = (scale * (points[list[k]] - points[point])).cast<float>();
    nearness_ = (-kDistanceDecay * offset_.square().colwise().sum()).exp();
    spacing_ = spacing_of(static_cast<int>(offset_.cols()));
    per_thickness_ = static_cast<float>(1.0 / (options.thickness * spacing_));
  }

  // The normal of the sheet that the point is of if there are others, else zero. `deviation` is
  // that of all from one plane.
  Vec3f normal_of_sheet(double deviation) const {
    Vec3f normal = normal_of_most_support();
    if (normal.isZero()) return normal;
    for (int k = 0; k < kRefinements; ++k) normal = refined(normal);
    return has_sheets_beside(normal, deviation) ? normal : Vec3f(Vec3f::Zero());
  }

 private:
  Row heights_over(const Vec3f& normal) const {
    return normal[0] * offset_.row(0) + normal[1] * offset_.row(1) + normal[2] * offset_.row(2);
  }
  // Of a plane through the point, by each neighbour: about exp(-h^2), h the height in thicknesses.
  Row support_of(const Vec3f& normal) const {
    const Row falling = (1.0f - (0.5f * per_thickness_ * heights_over(normal)).square()).max(0.0f);
    return nearness_ * falling.square().square();
  }
  Vec3f normal_of_most_support() const {
    const Eigen::Index nearest = std::min<Eigen::Index>(kNearest, offset_.cols() - 1);
    Vec3f best = Vec3f::Zero();
    float most = 0.0f;
    for (Eigen::Index a = 1; a <= nearest; ++a)
      for (Eigen::Index b = a + 1; b <= nearest; ++b) {
        const Vec3f p = offset_.col(a), q = offset_.col(b), cross = p.cross(q);
        const float length = cross.norm();
        if (!(length > kLeastSine * p.norm() * q.norm())) continue;
        const Vec3f normal = cross / length;
        const float support = support_of(normal).sum();
        if (!(support > most)) continue;
        most = support;
        best = normal;
      }
    return best;
  }
  Vec3f refined(const Vec3f& normal) const {
    const Row weight = support_of(normal);
    const float sum = weight.sum();  // the point itself has weight 1
    const Offsets weighted = offset_.rowwise() * weight;
    const Vec3f mean = weighted.rowwise().sum() / sum;
    const Eigen::Matrix3f squares =
        weighted.matrix() * offset_.matrix().transpose() - sum * mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal;
    principal.computeDirect(squares.cast<double>());
    return principal.eigenvectors().col(0).cast<float>();
  }

  bool has_sheets_beside(const Vec3f& normal, double deviation) const;

  const ParallelSheetsOptions& options_;
  Offsets offset_;
  Row nearness_;  // weights of the distances
  double spacing_;
  float per_thickness_;
};

bool Neighbourhood::has_sheets_beside(const Vec3f& normal, double deviation) const {
  const Row height = heights_over(normal);
  const Heights heights(offset_, height);
  const int count = heights.count(), point = heights.place_of_point();
  const int least_own = std::max(1, static_cast<int>(kLeastOwn * count));
  const int least_beside = std::max(1, static_cast<int>(kLeastBeside * count));
  const double gap = options_.least_gap * spacing_;
  const double most = std::min(options_.most_variance * heights.squares(0, count),
                               options_.most_of_plane * deviation * deviation * count);
  const auto is_gap = [&](int place) { return heights.at(place) - heights.at(place - 1) >= gap; };
  const auto is_over = [&](const Vec3f& way) {
    return std::abs(way.dot(normal)) >= options_.least_cosine * way.norm();
  };
  for (int begin = 0; begin <= point; ++begin) {
    if (begin > 0 && !is_gap(begin)) continue;
    for (int end = std::max(point + 1, begin + least_own); end <= count; ++end) {
      if (end < count && !is_gap(end)) continue;
      const bool has_below = begin > 0, has_above = end < count, has_both = has_below && has_above;
      if (!has_both && count - (end - begin) < least_beside) continue;
      const double within =
          heights.squares(0, begin) + heights.squares(begin, end) + heights.squares(end, count);
      if (within > (has_both ? kOfThree * most : most)) continue;
      const Vec3f own = heights.mean(begin, end);
      if ((!has_below || is_over(heights.mean(0, begin) - own)) &&
          (!has_above || is_over(heights.mean(end, count) - own)))
        return true;
    }
  }
  return false;
}

}  // namespace

Index fit_parallel_sheets(const std::vector<Vec3>& points, Neighbourhoods& neighbourhoods,
                          const ParallelSheetsOptions& options, Progress& progress) {
  const auto count = static_cast<Index>(points.size());
  const double least = options.least_deviation * spacing_of(std::max(neighbourhoods.k, 1));
  return parallel_sum(count, kGrain, progress, Index{0}, [&](Index begin, Index end) {
    Index replaced = 0;
    for (Index i = begin; i < end; ++i) {
      const double deviation = neighbourhoods.deviation[i] / neighbourhoods.radius[i];
      if (!(deviation > least)) continue;
      const Vec3f normal =
          Neighbourhood(points, neighbourhoods, static_cast<std::size_t>(i), options)
              .normal_of_sheet(deviation);
      if (normal.isZero()) continue;
      neighbourhoods.normal[i] = normal;
      ++replaced;
    }
    return replaced;
  });
}

}  // namespace shrinkwrap
