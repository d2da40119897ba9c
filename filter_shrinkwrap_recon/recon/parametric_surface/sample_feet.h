// Section 2.5: where on the parametric surface each sample belongs.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// The foot of a sample: a place on a face, by the weights of its second and third corner.
struct SampleFoot {
  Index face = kNone;
  float weight_b = 0.0f, weight_c = 0.0f;
};

struct SampleFeet {
  std::vector<SampleFoot> foot;  ///< one per sample
  /// The samples by the face of their foot, ascending within a face: those of face f are
  /// by_face[begin[f]] to by_face[begin[f + 1] - 1].
  std::vector<Index> by_face, begin;
  double mean_distance = 0.0;  ///< x spacing
  double max_distance = 0.0;   ///< x spacing
};

/// The nearest point of the surface whose face looks to the side of the sample's normal, unless
/// that is farther by three spacings than the nearest of any; then that one. Exact.
/// Pre: a mesh with faces, none of them removed. O(N log F), parallel.
SampleFeet find_sample_feet(const SurfaceMesh& surface, const PointCloud& cloud,
                            Progress& progress);

}  // namespace shrinkwrap
