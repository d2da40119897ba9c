// Where the local surface is, seen from a mesh vertex: the target of shrinking and fitting.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

/// Lengths in s, the greater of the median spacing and the local spacing of the nearest sample.
struct TangentTargetOptions {
  double min_cosine = 0.1;  ///< normals of samples and planes agree with the mesh's above this
  double reach = 3.0;       ///< x s: a vertex without a compatible sample so near is a membrane's
  double off_centre = 0.6;  ///< x s: from here, samples on one side only, the plane counts less ...
  double beyond_rim = 1.0;  ///< x s: ... and from here not at all
  int planes = 6;           ///< neighbouring planes that are blended ...
  int quadric_planes = 8;   ///< ... if the cloud is denoised: planes that leave no bias
  int rim_neighbours = 14;  ///< samples whose centroid tells how far off the data the query is
};

/// Foot of a mesh vertex on the surface that the samples of its own side suggest. Projecting to the
/// nearest sample folds the mesh in concavities and thin parts; the planes of the normal-compatible
/// neighbours do not. Where samples support no surface (openings, and beyond the rim of the data)
/// the vertex belongs to a membrane, which is only smoothed.
class TangentTarget {
 public:
  /// Pre: `orient_normals` was called on the cloud, which must outlive the object.
  TangentTarget(const PointCloud& cloud, const TangentTargetOptions& options = {})
      : cloud_(cloud), options_(options) {}

  struct Target {
    Vec3 point;                ///< where to go; the query itself if `is_membrane`
    Index nearest = kNone;     ///< nearest compatible sample: the hint for the next call
    bool is_membrane = false;  ///< no sample supports the surface here: smooth only
  };
  /// `normal`: of the mesh at `query`, unit. `centroid`: mean of the vertex's one-ring, towards
  /// which the target fades near the rim of the data, so that it changes smoothly into a membrane.
  /// `hint`: a sample near the last answer, from which a walk over the neighbour graph starts, or
  /// kNone for a full search. Thread-safe, no allocation.
  Target find(const Vec3& query, const Vec3& normal, const Vec3& centroid, Index hint) const;

 private:
  bool is_compatible(Index sample, const Vec3f& normal) const {
    return cloud_.normal[sample].dot(normal) > static_cast<float>(options_.min_cosine);
  }
  Index walk(const Vec3& query, const Vec3f& normal, Index from) const;
  Index search_all(const Vec3& query, const Vec3f& normal) const;

  const PointCloud& cloud_;
  TangentTargetOptions options_;
};

}  // namespace shrinkwrap
