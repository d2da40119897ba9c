// What most stages start from.
#pragma once

#include <cmath>
#include <vector>

#include "orientation/orientation.h"
#include "samples/neighbourhoods.h"
#include "samples/point_cloud.h"

namespace shrinkwrap::testing {

/// The cloud of these points, with all defaults; its normals are of either sign.
inline PointCloud prepared_cloud(const std::vector<Vec3>& points) {
  Progress silent;
  return prepare_samples(points, {}, silent);
}

/// The same with oriented normals.
inline PointCloud oriented_cloud(const std::vector<Vec3>& points) {
  Progress silent;
  PointCloud cloud = prepared_cloud(points);
  orient_normals(cloud, {}, silent);
  return cloud;
}

/// The same, but every `stride`-th normal is that of one plane, be the neighbours of both sides of
/// a wall or not (parallel_sheets.h, pole_normals.h), or of two faces (crease_planes.h): walls as
/// thin as that have bridges and tunnels then.
inline PointCloud cloud_with_askew_normals(const std::vector<Vec3>& points, int stride) {
  Progress silent;
  PointCloud cloud = prepared_cloud(points);
  const Neighbourhoods around =
      find_neighbourhoods(cloud.position, cloud.search, cloud.neighbour_count, silent);
  for (Index i = 0; i < cloud.size(); i += stride) cloud.normal[i] = around.normal[i];
  OrientationOptions as_they_are;
  as_they_are.poles.least_deviation = INFINITY;
  as_they_are.most_noise_at_creases = -1.0;
  orient_normals(cloud, as_they_are, silent);
  return cloud;
}

}  // namespace shrinkwrap::testing
