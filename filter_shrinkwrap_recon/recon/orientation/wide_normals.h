// Normals of samples in noisy parts of a cloud, of more neighbours.
#pragma once

#include <vector>

#include "common/progress.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// The normals of the cloud; where there is more noise (`more_noise`), which turns them, those of
/// planes through so many samples that their disc is wider than thick, at most 64, if that is more
/// than they have neighbours. Only samples count that face the way the sample itself does, or, if
/// three fifths of those around it face the other way, that. Pre: `orient_normals` and
/// `measure_more_noise` were called on the cloud. O(N), the same for any number of threads. Throws
/// Cancelled.
std::vector<Vec3f> wide_normals(const PointCloud& cloud, Progress& progress);

}  // namespace shrinkwrap
