// What the orientation found of samples, so that a cloud may lose some, or get others, and keep it.
#pragma once

#include <vector>

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct OrientedSample {
  Vec3 position;  ///< unit frame
  Index input_index = kNone;
  Vec3f normal;
  TangentPlane plane;
  float more_noise = 0.0f;
};

/// Those of a cloud, with planes if it has any. Pre: it is not denoised.
std::vector<OrientedSample> oriented_samples(const PointCloud& cloud);

/// Gives a cloud these samples, in any order, in place of its own. Post: it has them in the order
/// of a Morton curve, with neighbours and spacing as `prepare_samples` finds them, with the normals
/// (and, if it had any, the planes and the noise) that are given, and all else as before, its frame
/// among it. Pre: it is not denoised. O(N) expected, parallel; the same for any number of threads.
/// Throws Cancelled, and the cloud is then as it was.
void replace_samples(PointCloud& cloud, const std::vector<OrientedSample>& samples,
                     Progress& progress);

}  // namespace shrinkwrap
