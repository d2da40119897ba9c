// Handles that no samples bear out: bridges between close parts, and tunnels through thin walls.
#pragma once

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct FalseHandleOptions {
  bool enabled = true;  ///< for the pipeline: cut any
  /// A handle is false if the normals of a loop around or through it agree less, in the mean, with
  /// those of the nearest samples: on the side of a bridge they are square to each other, around a
  /// true limb or hole they are alike ...
  double least_cosine = 0.5;
  /// ... and if samples do not bear it out all around: seen from the middle of the loop there is a
  /// wider gap (radians) between those near its plane that look away from the middle, where it lies
  /// around a limb, or towards it, where it lies around a hole. In a hole hardly wider than a voxel
  /// the nearest sample may be across it, and the normals of voxels tell little.
  double widest_gap = kPi;
  /// Loops of at most twice as many edges and one are looked at.
  Index radius = 3;
  /// Samples bear a handle clearly out if it is a hole with a loop around it of which the cosine is
  /// at least this, and the widest gap at most that.
  double clear_cosine = 0.8;
  double clear_gap = 120.0 * kPi / 180.0;
  Index least_of_cavity = 100;  ///< samples nearest to its wall, for its false mouth to be closed
};

struct FalseHandleReport {
  Index handles = 0;  ///< cut
  Index mouths = 0;   ///< of cavities, closed
};

/// Cuts false handles along such loops, and closes both sides of each with a fan: a bridge is
/// severed, a tunnel filled. None of these cuts separates the surface. Tunnels that lead into a
/// cavity are no handles; those that are false are closed at last, which parts the wall of the
/// cavity from the surface outside. Necks between bodies stay, as thin rods of few samples look
/// like false ones. Pre: a closed 2-manifold of even edges, about as long as the voxels' (the
/// boundary of a solid), without removed slots; `orient_normals` was called on the cloud. Post: the
/// same, in canonical order. O(V + N).
FalseHandleReport cut_false_handles(SurfaceMesh& mesh, const PointCloud& cloud,
                                    const FalseHandleOptions& options, Progress& progress);

/// Of handles along such loops cuts those that `other`, another boundary for the same cloud, does
/// not show, and that samples do not bear clearly out; returns how many. Bridges between close
/// sheets may look like limbs; of holes that are none, hardly any look like one. Handles without so
/// short a loop stay. Ends early once more than `most` were cut. As cut_false_handles otherwise.
Index cut_doubtful_handles(SurfaceMesh& mesh, const SurfaceMesh& other, const PointCloud& cloud,
                           const FalseHandleOptions& options, Index most, Progress& progress);

/// Tunnels of any width from what lies in shadow on a sheet (PointCloud::closedness) to its back.
/// Samples bear out where they begin, and none their walls. They are told by loops at their rims,
/// around which there is a wider gap than `widest_gap` between samples that look to the middle.
/// Returns how many of these can be cut at once and leave the surface in one piece; 0 without a
/// handle. As cut_false_handles otherwise, but the mesh stays. O((V + N) log V).
Index count_tunnels_of_shadows(SurfaceMesh& mesh, const PointCloud& cloud,
                               const FalseHandleOptions& options, Progress& progress);

}  // namespace shrinkwrap
