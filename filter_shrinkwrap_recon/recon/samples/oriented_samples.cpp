#include "samples/oriented_samples.h"

#include <utility>

#include "geometry/morton.h"

namespace shrinkwrap {

std::vector<OrientedSample> oriented_samples(const PointCloud& cloud) {
  std::vector<OrientedSample> samples(cloud.position.size());
  for (Index i = 0; i < cloud.size(); ++i) {
    OrientedSample& sample = samples[static_cast<std::size_t>(i)];
    sample.position = cloud.position[i];
    sample.input_index = cloud.input_index[i];
    sample.normal = cloud.normal[i];
    if (!cloud.plane.empty()) sample.plane = cloud.plane[i];
    if (!cloud.more_noise.empty()) sample.more_noise = cloud.more_noise[i];
  }
  return samples;
}

void replace_samples(PointCloud& cloud, const std::vector<OrientedSample>& samples,
                     Progress& progress) {
  std::vector<Vec3> position;
  position.reserve(samples.size());
  for (const OrientedSample& sample : samples) position.push_back(sample.position);
  PointCloud next;
  next.frame = cloud.frame;
  next.conditioning = cloud.conditioning;
  next.closedness = cloud.closedness;
  std::vector<Vec3f> normal;
  for (const Index i : morton_order(position, progress)) {
    const OrientedSample& sample = samples[static_cast<std::size_t>(i)];
    next.position.push_back(sample.position);
    next.input_index.push_back(sample.input_index);
    normal.push_back(sample.normal);
    if (!cloud.plane.empty()) next.plane.push_back(sample.plane);
    if (!cloud.more_noise.empty()) next.more_noise.push_back(sample.more_noise);
  }
  next.search = VoxelSearch(next.position, progress);
  measure_neighbourhoods(next, cloud.neighbour_count, progress);
  next.normal = std::move(normal);
  cloud = std::move(next);
}

}  // namespace shrinkwrap
