// Section 2.4: Loop subdivision, fitted to the samples (Suzuki, Takeuchi and Kanai 1999).
#pragma once

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct ParametricSurfaceOptions {
  enum class Target {
    tangent_plane,   ///< foot on the plane of the normal-compatible neighbours
    nearest_sample,  ///< p* of eq. 14 as printed
  };
  Target target = Target::tangent_plane;
  /// At most, and none once there are three quarters as many vertices as samples: a control mesh
  /// that has them is the surface. One more is added if there are fewer than half as many then.
  int subdivisions = 2;
  /// Leave out the last subdivision where the surface is fine enough without it: of the samples all
  /// but one in a thousand lie within this many spacings of it. 0: always subdivide. What follows
  /// is several times faster then, and no worse.
  double fine_enough = 0.5;
  /// With fewer samples than this always subdivide: there is no time to be saved.
  Index fine_enough_from = 20000;
  /// Fitting iterations after each subdivision; half as many, rounded up, after the last, which
  /// starts from a surface that fits already.
  int iterations = 5;
  double attraction = 0.7;  ///< lambda of eq. 14, in [0, 1]
  double relaxation = 0.2;  ///< tangential, per iteration
};

struct ParametricSurfaceReport {
  Index vertices = 0;
  int subdivisions = 0;
  double mean_distance = 0.0;   ///< of the vertices from their targets, x spacing
  double max_distance = 0.0;    ///< x spacing, membranes left out
  Index membrane_vertices = 0;  ///< only smoothed: no sample supports the surface there
};

struct ParametricSurface {
  SurfaceMesh mesh;  ///< same topology as the control mesh, no removed slots
  ParametricSurfaceReport report;
};

/// Weight beta of Loop's rule for valence K: 3/16 for K = 3, else (1/K)(5/8 - (3/8 + cos(2
/// pi/K)/4)^2).
double loop_beta(Index valence);
/// Weight chi of eq. 13: limit position = v + chi * sum of (v_j - v) over the one-ring.
double loop_limit_weight(Index valence);
/// One step of Loop subdivision: V' = V + E, each face into four. O(F), parallel. Throws
/// InvalidInput if the result cannot be indexed (178 million faces and more).
SurfaceMesh loop_subdivide(const SurfaceMesh& mesh);
SurfaceMesh loop_subdivide(const SurfaceMesh& mesh, Progress& progress);

/// Subdivides and fits. Pre: for tangent_plane, `orient_normals` was called on the cloud.
ParametricSurface make_parametric_surface(SurfaceMesh control, const PointCloud& cloud,
                                          const ParametricSurfaceOptions& options,
                                          Progress& progress);

/// Part of the samples that are farther from the surface than they are from each other there, by
/// more than `noise` (x spacing; of the cloud) explains; a denoised cloud has none. Some, 20,000 or
/// more, stand for all.
double part_of_samples_far(const SurfaceMesh& surface, const PointCloud& cloud, double noise,
                           Progress& progress);

/// Per vertex: 1 if it belongs to a membrane, where no sample supports the surface. Pre: as above.
std::vector<char> mark_membranes(const SurfaceMesh& surface, const PointCloud& cloud,
                                 const ParametricSurfaceOptions& options, Progress& progress);

/// Measures `mean_distance`, `max_distance` and `membrane_vertices` anew, on the mesh as it is:
/// what the fit tells is of control vertices before they went to their limits. Pre: as above.
void measure_distances(ParametricSurface& surface, const PointCloud& cloud,
                       const ParametricSurfaceOptions& options, Progress& progress);

}  // namespace shrinkwrap
