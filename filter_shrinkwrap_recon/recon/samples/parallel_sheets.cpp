#include "samples/parallel_sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/parallel.h"
#include "samples/plane_support.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr double kOfThree = 0.3;  // variance that three sheets may have, x that of two
constexpr double kLeastOwn = 4.0 / 16.0, kLeastBeside = 2.0 / 16.0;  // parts of the neighbours

double spacing_of(int neighbours) {
  return std::sqrt(kPi / neighbours);
}

// Neighbours ordered by their height over a plane, any range of which may be a sheet.
class Heights {
 public:
  Heights(const PlaneSupport::Vectors& offset, const PlaneSupport::Row& height)
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
  const PlaneSupport::Vectors& offset_;
  const PlaneSupport::Row& height_;
  int count_;
  std::array<int, PlaneSupport::kMostNeighbours> order_;
};

// The neighbours of one point; lengths in the radius of the neighbourhood.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Vec3>& points, const Neighbourhoods& all, std::size_t point,
                const ParallelSheetsOptions& options)
      : options_(options),
        spacing_(spacing_of(all.k)),
        planes_(offsets_from(points, all, point), options.thickness * spacing_) {}

  // The normal of the sheet that the point is of if there are others, else zero. `deviation` is
  // that of all from one plane.
  Vec3f normal_of_sheet(double deviation) const {
    const Vec3f normal = planes_.normal_of_most_support();
    return !normal.isZero() && has_sheets_beside(normal, deviation) ? normal : Vec3f(Vec3f::Zero());
  }

 private:
  static PlaneSupport::Vectors offsets_from(const std::vector<Vec3>& points,
                                            const Neighbourhoods& all, std::size_t point) {
    PlaneSupport::Vectors offset(3, std::min(all.k, PlaneSupport::kMostNeighbours));
    const Index* list = all.neighbour.data() + point * static_cast<std::size_t>(all.k);
    const double scale = 1.0 / all.radius[point];
    for (Eigen::Index k = 0; k < offset.cols(); ++k)
      offset.col(k) = (scale * (points[list[k]] - points[point])).cast<float>();
    return offset;
  }
  bool has_sheets_beside(const Vec3f& normal, double deviation) const;

  const ParallelSheetsOptions& options_;
  double spacing_;
  PlaneSupport planes_;
};

bool Neighbourhood::has_sheets_beside(const Vec3f& normal, double deviation) const {
  const PlaneSupport::Row height = planes_.heights_over(normal);
  const Heights heights(planes_.offset(), height);
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
