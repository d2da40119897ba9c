#include "station.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace shrinkwrap {
namespace {

constexpr double kCell = 3.0;           // x angle between samples
constexpr double kLeastCell = 0x1p-19;  // of directions, for three to fit into a key

// How a sample is seen.
struct Sight {
  Vec3 way;  // from the station, of length 1
  double distance;
  double cosine;  // between the way and the normal, of either sign
  // Between this sample and those beside it.
  double angle(double spacing) const {
    return distance > 0.0 ? spacing * std::sqrt(cosine) / distance : 0.0;
  }
};

Sight sight_of(const PointCloud& cloud, Index sample, const Vec3& station) {
  const Vec3 way = cloud.position[sample] - station;
  const double distance = way.norm();
  if (!(distance > 0.0)) return {Vec3::Zero(), 0.0, 0.0};
  return {way / distance, distance,
          std::abs(way.dot(cloud.normal[sample].cast<double>())) / distance};
}

double nth_part(std::vector<double>& values, double part) {
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

double width_of_middle_two_thirds(std::vector<double>& values) {
  const double low = nth_part(values, 1.0 / 6.0);
  return nth_part(values, 5.0 / 6.0) - low;
}

// Length of the mean normal over the area, of normals that are turned to the station.
double mean_normal_towards(const PointCloud& cloud, const Vec3& station) {
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = cloud.normal[i].cast<double>();
    const double area = cloud.local_spacing[i] * cloud.local_spacing[i];
    sum += normal.dot(station - cloud.position[i]) < 0.0 ? Vec3(-area * normal) : area * normal;
    total += area;
  }
  return total > 0.0 ? sum.norm() / total : 0.0;
}

}  // namespace

double spread_left_from(const PointCloud& cloud, const Vec3& station) {
  std::vector<double> spacings, left;  // logarithms
  for (Index i = 0; i < cloud.size(); ++i) {
    const double spacing = cloud.local_spacing[i];
    spacings.push_back(std::log(spacing));
    left.push_back(std::log(sight_of(cloud, i, station).angle(spacing)));
  }
  const double before = width_of_middle_two_thirds(spacings);
  const double after = width_of_middle_two_thirds(left);
  return (after / before) * (after / before);
}

double part_hidden_from(const PointCloud& cloud, const Vec3& station) {
  std::vector<double> angles;
  for (Index i = 0; i < cloud.size(); ++i)
    angles.push_back(sight_of(cloud, i, station).angle(cloud.local_spacing[i]));
  const double cell = std::clamp(kCell * nth_part(angles, 0.5), kLeastCell, 1.0);
  using Place = std::pair<std::uint64_t, Index>;  // cell of directions, sample
  std::vector<Place> places;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 way = sight_of(cloud, i, station).way;
    std::uint64_t key = 0;
    for (const double along : {way.x(), way.y(), way.z()})
      key = (key << 21) + static_cast<std::uint64_t>((along + 1.0) / cell);
    places.emplace_back(key, i);
  }
  std::sort(places.begin(), places.end());
  const auto distance = [&](const Place& place) {
    return (cloud.position[place.second] - station).norm();
  };
  Index hidden = 0;
  for (auto first = places.begin(); first != places.end();) {
    const auto last = std::find_if(first, places.end(),
                                   [&](const Place& place) { return place.first != first->first; });
    const Vec3& foremost =
        cloud.position[std::min_element(first, last, [&](const Place& a, const Place& b) {
                         return distance(a) < distance(b);
                       })->second];
    for (; first != last; ++first) {
      const Index i = first->second;
      const double off = cloud.normal[i].cast<double>().dot(foremost - cloud.position[i]);
      hidden += std::abs(off) > cell * distance(*first);
    }
  }
  return static_cast<double>(hidden) / cloud.size();
}

bool is_view_from(const PointCloud& cloud, const Vec3& station, const StationOptions& options) {
  return station.allFinite() && spread_left_from(cloud, station) <= options.most_spread_left &&
         mean_normal_towards(cloud, station) >= options.least_sheet_normal &&
         part_hidden_from(cloud, station) <= options.most_hidden;
}

}  // namespace shrinkwrap
