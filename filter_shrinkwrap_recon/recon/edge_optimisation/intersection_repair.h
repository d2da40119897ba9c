// Self-intersections taken apart: the vertices are samples, so only the edges between them can
// change, and which faces have a sample between them.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "common/progress.h"
#include "edge_optimisation/fold_removal.h"
#include "edge_optimisation/patch_annealing.h"
#include "mesh/spanning_faces.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Of all faces: if more meet others, the mesh is a heap, and what is costly is not tried.
constexpr double kMostMeeting = 0.2;

struct RepairOptions {
  bool enabled = true;     ///< for the pipeline: repair at all
  int max_rounds = 64;     ///< passes over the edges near the faces that still meet others
  int max_look_ahead = 2;  ///< flips that are tried together where fewer do not help; 2 at most
  /// Hinges looked at bound the time, some 3 us each (coplanar samples: 30; a sample relocated
  /// counts as 50): for each face that meets another at the start, and in all; 0: 50,000 and one
  /// for each face of the mesh. So do the pairs of faces whose boxes meet: a million (200,000 if
  /// nearly all faces meet others), and 20 for each face of the mesh, never one more. Annealing
  /// comes on top: at most 20 moves for each trial for a face, and 20,000 and two for each face of
  /// the mesh (some 7 us each) with 30 tests each.
  std::int64_t max_trials_per_face = 1000;
  std::int64_t max_trials = 0;
  /// Cosine of the sharpest angle between the normals of neighbours that a flip may make anew, as
  /// long as there is another way.
  double fold_guard = -0.3;
  AnnealingOptions annealing;  ///< of patches of one ring; of n rings, n times as many moves
  int max_annealed_rings = 3;  ///< around faces that still meet others; 3 at most
  FoldOptions folds;           ///< that are removed at last
  /// Anneals what all this has left, if these are few faces, anew: by up to 8 other seeds, with up
  /// to three times as many moves beside those above, at most 500,000. Not with fewer than 3 rings.
  bool insists = true;
  /// Of a mesh that was repaired before and has changed in places: `surroundings` of the faces that
  /// were left. Near a face whose surroundings are all among these nothing is tried again, unless
  /// something changes there.
  std::vector<Triangle> tried = {};
};

/// The corners, ascending, of these faces and of those within one ring of them; ascending.
std::vector<Triangle> surroundings(const SurfaceMesh& mesh, const std::vector<Index>& faces);

struct RepairReport {
  Index before = 0;  ///< pairs of faces that meet, as far as they are known (face_meetings.h)
  Index after = 0;
  Index faces_before = 0;  ///< that meet others: exact however many pairs are known
  Index faces_after = 0;
  Index faces_before_annealing = 0;    ///< those that flips and relocations left; of several
                                       ///< repairs that annealed, the most
  std::vector<Index> remaining_faces;  ///< those that are left, ascending
  Index flips = 0;
  Index relocated = 0;  ///< samples
  Index annealed = 0;   ///< patches that came out with fewer pairs
  int rounds = 0;
  bool ran_short = false;  ///< of rounds, trials or tests: not all was tried, annealing aside
  std::int64_t tests = 0;  ///< of pairs of faces, after the first search
  FoldReport folds;        ///< that were left by all this

  /// Faces that meet others, or did until they were annealed: where the surface is right, flips and
  /// relocations leave few or none.
  Index persistent_faces() const {
    return annealed > 0 ? std::max(faces_before_annealing, faces_after) : faces_after;
  }

  /// Of a further repair of the same mesh: the most that either found, what it left, and the work
  /// of both. Of a heap, `after` then counts other pairs than `before`.
  void add(RepairReport further) {
    before = std::max(before, further.before);
    faces_before = std::max(faces_before, further.faces_before);
    after = further.after;
    faces_after = further.faces_after;
    // What a repair left that annealed nothing, moves of the other may have parted.
    faces_before_annealing = std::max(annealed > 0 ? faces_before_annealing : 0,
                                      further.annealed > 0 ? further.faces_before_annealing : 0);
    remaining_faces = std::move(further.remaining_faces);
    flips += further.flips;
    relocated += further.relocated;
    annealed += further.annealed;
    rounds += further.rounds;
    ran_short = further.ran_short;
    tests += further.tests;
    folds.faces_before = std::max(folds.faces_before, further.folds.faces_before);
    folds.faces_after = further.folds.faces_after;
    folds.flips += further.folds.flips;
    folds.annealed += further.folds.annealed;
  }
};

/// Flips edges near faces that meet others while that lowers the number of pairs, or, at the same
/// number, unfolds the hinge. Where no flip does, relocates samples (sample_relocation.h), and then
/// looks for two neighbouring flips that do together. What failed is tried again only where
/// something has changed nearby. Sharper folds than the guard allows are made only where all this
/// fails, and unfolded at the end if that costs no pair; needles only where folds do not help. At
/// last the patches around the faces that still meet are annealed (patch_annealing.h), of one ring,
/// then of more, the smallest first, unless they are more than a fifth of all: a heap.
/// Whether faces meet or not, folds are removed then (fold_removal.h).
/// Vertices neither move nor vanish, no face becomes degenerate, and the mesh stays a closed
/// 2-manifold of the same genus. `after` is never above `before`.
///
/// Finding the pairs costs as much as `self_intersections`; the rest is proportional to the number
/// of faces in them. Deterministic.
/// `opening_faces` (ascending) are not to be in the result: they stay as they are, and whatever
/// meets them does not count. `spanning_faces` (ascending, those too; optional) may change where
/// faces meet, but not for a fold: around an opening they may well lie on the surface. They take
/// other slots then, and are told anew (spanning_faces.h); `extra` vertices are no samples.
RepairReport repair_self_intersections(SurfaceMesh& mesh, const RepairOptions& options,
                                       Progress& progress,
                                       const std::vector<Index>& opening_faces = {},
                                       std::vector<Index>* spanning_faces = nullptr,
                                       const ExtraVertices& extra = {});

}  // namespace shrinkwrap
