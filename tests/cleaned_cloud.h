// A cloud without its outliers, and what they were.
#pragma once

#include <vector>

#include "samples/outliers.h"
#include "samples/point_cloud.h"

namespace shrinkwrap::testing {

struct Cleaned {
  PointCloud cloud;
  OutlierReport report;
};

inline Cleaned cleaned(const std::vector<Vec3>& points, const OutlierOptions& options = {},
                       const SampleOptions& sample_options = {}) {
  Progress silent;
  Cleaned result;
  const FarStrays far_strays = find_far_strays(points, options.far_strays, silent);
  result.cloud = prepare_samples(points, sample_options, silent, far_strays);
  result.report = exclude_outliers(result.cloud, points, options, silent, far_strays);
  return result;
}

}  // namespace shrinkwrap::testing
