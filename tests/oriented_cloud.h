// What most stages start from.
#pragma once

#include <vector>

#include "orientation.h"
#include "point_cloud.h"

namespace shrinkwrap::testing {

/// The cloud of these points, with oriented normals and all defaults.
inline PointCloud oriented_cloud(const std::vector<Vec3>& points) {
  Progress silent;
  PointCloud cloud = prepare_samples(points, {}, silent);
  orient_normals(cloud, {}, silent);
  return cloud;
}

}  // namespace shrinkwrap::testing
