// Folds: edges at which one face lies on the other, which surfaces seldom have.
#pragma once

#include <vector>

#include "common/progress.h"
#include "edge_optimisation/hinge_flips.h"
#include "edge_optimisation/patch_annealing.h"

namespace shrinkwrap {

struct FoldOptions {
  double angle = 120.0 * kPi / 180.0;  ///< between the normals of two faces at a fold, at least
  /// Where more of the faces than this part are at folds, noise is what folds the mesh, and less
  /// bending is no nearer to the surface: nothing is done. 0: never anything.
  double most_folded = 0.01;
  /// Of the patch around each set of folds that no flip removes: these faces and one ring.
  AnnealingOptions annealing = {AnnealingOptions::Goal::least_bending};
};

struct FoldReport {
  Index faces_before = 0, faces_after = 0;  ///< at folds
  Index flips = 0;
  Index annealed = 0;  ///< patches that came out with less bending
  bool has_done_any() const { return flips > 0 || annealed > 0; }
};

/// Faces at folds but those at `fixed_faces` (ascending), ascending. O(F), parallel.
std::vector<Index> folded_faces(const SurfaceMesh& mesh, const FoldOptions& options,
                                Progress& progress, const std::vector<Index>& fixed_faces = {});

/// Flips the edges of a mesh at which or beside which it folds while it bends less for that, and
/// anneals what is left of the folds. A fold of the surface itself, such as the rim of a blade,
/// stays: without it the mesh would bend more. No more faces meet than before; fixed faces stay.
/// The vertices do not move, and the mesh stays a closed 2-manifold of the same topology.
/// Slivers are made only where the folds stay without them.
/// O(F), and at most 20,000 moves of annealing and two for each face (some 7 us each).
/// Deterministic. Throws Cancelled.
FoldReport remove_folds(HingeFlips& hinges, const FoldOptions& options, Progress& progress);

}  // namespace shrinkwrap
