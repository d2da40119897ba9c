// Section 2.5: where on the parametric surface each sample belongs.
#pragma once

#include <vector>

#include "mesh/face_tree.h"
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

/// Looks for the feet of samples, which are best given along a curve: the face of the last bounds
/// the search for the next. Exact. Pre: a mesh with faces, none of them removed, which outlives
/// this as the tree does. For one thread.
class FootSearch {
 public:
  FootSearch(const SurfaceMesh& surface, const FaceTree& tree, double spacing)
      : surface_(surface), tree_(tree), spacing_(spacing) {}
  /// The nearest point of the surface; face 0 if every distance overflows. O(log F).
  FaceTree::Hit nearest(const Vec3& p);
  /// The nearest point whose face looks to the side of `normal`, unless that is farther by three
  /// spacings than the nearest of any; then that one.
  FaceTree::Hit nearest_facing(const Vec3& p, const Vec3& normal);

 private:
  const SurfaceMesh& surface_;
  const FaceTree& tree_;
  double spacing_;
  Index hint_ = kNone;
  FaceTree::Anchor anchor_;
};

/// The foot of every sample, as `FootSearch::nearest_facing` finds it by the sample's normal.
/// Pre: a mesh with faces, none of them removed. O(N log F), parallel.
SampleFeet find_sample_feet(const SurfaceMesh& surface, const PointCloud& cloud,
                            Progress& progress);

}  // namespace shrinkwrap
