#include "orientation/station.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr double kCell = 3.0;           // x angle between samples
constexpr double kLeastUpright = 0.7;   // cosine with +z, of the mean normal of what lies below
constexpr double kLeastCell = 0x1p-19;  // of directions, for three to fit into a key

// How a sample is seen.
struct Sight {
  Vec3 way;         // from the station, of length 1
  double distance;  // 0: it is there
  double angle;     // between this sample and those beside it
};

std::vector<Sight> sights_from(const PointCloud& cloud, const Vec3& station, Progress& progress) {
  std::vector<Sight> sights(cloud.position.size(), {Vec3::Zero(), 0.0, 0.0});
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    const Vec3 way = cloud.position[i] - station;
    const double distance = way.stableNorm();
    if (!(distance > 0.0)) return;
    const double cosine = std::abs(way.dot(cloud.normal[i].cast<double>())) / distance;
    sights[i] = {way / distance, distance, cloud.local_spacing[i] * std::sqrt(cosine) / distance};
  });
  return sights;
}

double area_of(const PointCloud& cloud, Index sample) {
  const double spacing = cloud.local_spacing[sample];
  return spacing * spacing;
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

// Over the area, of normals that are turned to the station.
Vec3 mean_normal_towards(const PointCloud& cloud, const Vec3& station) {
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = cloud.normal[i].cast<double>();
    const double area = area_of(cloud, i);
    sum += normal.dot(station - cloud.position[i]) < 0.0 ? Vec3(-area * normal) : area * normal;
    total += area;
  }
  return total > 0.0 ? Vec3(sum / total) : sum;
}

// As far away beyond the samples.
Vec3 opposite_of(const Vec3& station, const PointCloud& cloud) {
  const Vec3 sum =
      std::accumulate(cloud.position.begin(), cloud.position.end(), Vec3(Vec3::Zero()));
  return 2.0 / cloud.size() * sum - station;
}

}  // namespace

double spread_left_from(const PointCloud& cloud, const Vec3& station, Progress& progress) {
  const std::vector<Sight> sights = sights_from(cloud, station, progress);
  std::vector<double> spacings(sights.size()), left(sights.size());  // logarithms
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    spacings[i] = std::log(static_cast<double>(cloud.local_spacing[i]));
    left[i] = std::log(sights[i].angle);
  });
  const double before = width_of_middle_two_thirds(spacings);
  const double after = width_of_middle_two_thirds(left);
  return (after / before) * (after / before);
}

double part_hidden_from(const PointCloud& cloud, const Vec3& station, Progress& progress) {
  const std::vector<Sight> sights = sights_from(cloud, station, progress);
  std::vector<double> angles(sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i) angles[i] = sights[i].angle;
  const double cell = std::clamp(kCell * nth_part(angles, 0.5), kLeastCell, 1.0);
  // Samples by cells of directions, the foremost first.
  struct Place {
    std::uint64_t cell;
    Index sample;
  };
  std::vector<Place> places(sights.size());
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    std::uint64_t key = 0;
    for (const double along : sights[i].way)
      key = (key << 21) + static_cast<std::uint64_t>((std::clamp(along, -1.0, 1.0) + 1.0) / cell);
    places[i] = {key, i};
  });
  std::sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
    return std::make_tuple(a.cell, sights[a.sample].distance, a.sample) <
           std::make_tuple(b.cell, sights[b.sample].distance, b.sample);
  });
  double hidden = 0.0, total = 0.0;
  for (auto foremost = places.begin(), place = foremost; place != places.end(); ++place) {
    if (place->cell != foremost->cell) foremost = place;
    const Index i = place->sample;
    const double off =
        cloud.normal[i].cast<double>().dot(cloud.position[foremost->sample] - cloud.position[i]);
    const double area = area_of(cloud, i);
    if (std::abs(off) > cell * sights[i].distance) hidden += area;
    total += area;
  }
  return total > 0.0 ? hidden / total : 0.0;
}

bool is_view_from(const PointCloud& cloud, const Vec3& station, const StationOptions& options,
                  Progress& progress) {
  if (!station.allFinite()) return false;
  const double left = spread_left_from(cloud, station, progress);
  if (!(left < options.most_spread_left)) return false;
  const bool is_sure = left < options.spread_left_for_sure;
  const Vec3 normal = mean_normal_towards(cloud, station);
  if (!(normal.norm() >= options.least_sheet_normal)) return false;
  const bool is_above = normal.z() > kLeastUpright * normal.norm();
  if (!(is_sure && is_above) &&
      !(left < options.most_over_opposite *
                   spread_left_from(cloud, opposite_of(station, cloud), progress)))
    return false;
  return part_hidden_from(cloud, station, progress) <=
         (is_sure ? options.most_hidden : options.most_hidden_in_doubt);
}

}  // namespace shrinkwrap
