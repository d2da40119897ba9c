// Section 2.5, last step: edges re-chosen.
#pragma once

#include <vector>

#include "common/progress.h"
#include "common/types.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

struct EdgeOptimisationOptions {
  enum class Criterion {
    bending,  ///< length x phi(dihedral angle) over the five edges of the hinge, plus triangle
              ///< shape
    quadric,  ///< the paper's: keep the diagonal of lower quadric cost (eq. 12), here under the
              ///< same guard
  };
  Criterion criterion = Criterion::bending;
  /// Of sum (a^2 + b^2 + c^2) / (4 area), x mean hinge edge length. 0.03 follows creases as closely
  /// as 0.01 does, and takes half as much from the smallest angles of evenly spread samples.
  double shape_weight = 0.03;
  /// Smaller gains do not flip (planes would cycle): x mean hinge edge length; quadric: x squared
  /// length of the edge.
  double least_gain = 1e-5;
  // What follows: triangles that are well shaped for it. Where the samples are the vertices of a
  // mesh of such triangles, this is nearer to it, often by half; of the surface beneath, least
  // bending tells more (up to a quarter of the distance, the more the more evenly samples are
  // spread).
  /// Above 0 (radians): when no flip lowers the criterion, edges become Delaunay where without them
  /// no side of their hinge bends by more than this, or than before. 0: the criterion has the last
  /// word.
  double crease_angle = 50.0 * kPi / 180.0;
  /// Where the edge bends by more than the crease angle, or one of the two faces would have a
  /// smaller angle than this (radians) ...
  double least_angle = 25.0 * kPi / 180.0;
  /// ... that is done only if the five edges then bend by no more than so many times as much as
  /// before.
  double most_bending = 1.3;
  // What follows: the surface beneath, where it shows.
  /// At last, where the two diagonals of a hinge pass each other at a distance of at least this, x
  /// the geometric mean of their lengths, the one nearer to the surface is taken, as far as the
  /// planes of the faces around the hinge tell that clearly. 0: wherever the diagonals differ,
  /// which comes up to a third nearer to a finer surface, and two or three times as far from a mesh
  /// of well-shaped triangles that has these vertices; 1: nowhere, whatever the others say.
  double least_gap = 0.03;
  /// Unless it is 0, the least gap is at least so many times the median of all gaps: where most are
  /// large, noise or coarse sampling makes them so, and planes tell little.
  double gap_over_median = 5.0;
  /// The same for this share of the hinges, those with the largest distances of the mesh, whatever
  /// the least gap: a wrong choice costs most there. 0: only where the least gap is reached.
  double largest_gaps = 0.05;
  /// That share is left alone if the median of all gaps, x as the least gap, is this or more: the
  /// faces around a hinge are as rough as itself then, and tell nothing. Noise of 0.1 spacings
  /// makes it 0.06, of 0.25 0.11; the sparsest clean clouds have 0.04.
  double rough_gap = 0.08;
};

struct EdgeOptimisationReport {
  Index flips = 0;  ///< of all steps: a later one may undo some of those before
};

/// Flips edges while that lowers the criterion and turns no face away from the surface, then, if
/// there is a crease angle, towards the Delaunay triangulation between creases, where that has
/// well-shaped faces, then towards the surface that the planes of the faces around suggest, where
/// the diagonals of a hinge are far enough apart. Vertices do not move. While the criterion is
/// lowered the surface is known by `guide_normals`, one per vertex; without, by the area-weighted
/// vertex normals of the mesh as given. Edges of `fixed_faces` stay. Pre: closed mesh without
/// removed slots, vertices in any order (best along a Morton curve). Post: same vertices, same
/// topology, closed 2-manifold. O(E) expected, bounded in any case; parallel, the same for any
/// number of threads.
EdgeOptimisationReport optimise_edges(SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                                      Progress& progress,
                                      const std::vector<Index>& fixed_faces = {},
                                      const std::vector<Vec3>* guide_normals = nullptr);

}  // namespace shrinkwrap
