// A patch of faces that no single change makes better is tiled anew, by chance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/progress.h"
#include "common/types.h"
#include "edge_optimisation/hinge_flips.h"

namespace shrinkwrap {

struct AnnealingOptions {
  /// Of which tiling is the best: the fewest pairs of faces that meet, or, of no more pairs than at
  /// first, the least bending (see HingeShape).
  enum class Goal { fewest_pairs, least_bending };
  Goal goal = Goal::fewest_pairs;
  /// The part of the bending that a tiling must spare to be better, where that is the goal.
  double least_gain = 0.03;
  /// Flips and relocations that are tried, for each face of the patch.
  int moves_per_face = 100;
  /// And no more of them, for each face of the set that a patch is around (`anneal_around`); 0: no
  /// such bound.
  std::int64_t moves_per_set_face = 0;
  /// At the start and the end, in pairs of faces: a change that adds so many is made with a chance
  /// of 1/e.
  double first_temperature = 1.0, last_temperature = 0.02;
  /// What bending by the length of an edge counts beside a pair of faces.
  double bending_weight = 0.6;
  double relocations = 0.15;  ///< the part of the moves that relocates a sample
  using Seed = std::uint32_t;
  Seed seed = 0;  ///< of the numbers that a patch draws
};

/// What all patches of a mesh may take together, before a repair insists (RepairOptions): moves,
/// and tests of pairs of faces for each. Patches of more faces are heaps, and of no use to try.
inline std::int64_t most_moves(const SurfaceMesh& mesh) {
  return 20000 + 2 * static_cast<std::int64_t>(mesh.face_slots());
}
constexpr std::int64_t kTestsPerMove = 30;
constexpr std::size_t kLargestPatch = 500;

/// Flips edges and relocates samples (sample_relocation.h) at random within a patch of faces, those
/// that add pairs or bend the mesh with a chance that falls as the patch "cools" (simulated
/// annealing: Kirkpatrick, Gelatt and Vecchi 1983; of triangulations: Schumaker 1993). The best
/// state is kept, and its edges are flipped while that bends the mesh less at no more pairs.
/// Without a state that is better than the first the patch is as before.
///
/// `patch`: faces, ascending; others do not change, and the fixed faces of `hinges` neither.
/// `moves_left` is lowered by the moves tried, which stop at 0. Returns true if the patch is
/// better. The vertices do not move, and the mesh stays a closed 2-manifold of the same topology.
/// Deterministic: the same patch draws the same numbers with the same seed. Progress stays at
/// `stage_done`; throws Cancelled.
bool anneal_patch(HingeFlips& hinges, const std::vector<Index>& patch, const FlipLimits& limits,
                  const AnnealingOptions& options, std::int64_t& moves_left, Progress& progress,
                  double stage_done);

struct AnnealedPatch {
  std::vector<Index> faces, changed;  ///< ascending
};

/// The faces of a set and so many rings around them, ascending; none if they are more than
/// `kLargestPatch`, or if pairs are the goal and the set has none.
std::vector<Index> patch_around(const HingeFlips& hinges, const std::vector<Index>& set, int rings,
                                const AnnealingOptions& options);

/// Anneals the patch around each of some sets of faces that has one. Patches whose boxes do not
/// overlap have nothing to do with each other and are annealed at the same time; of those that
/// overlap each waits for the ones before it. Of the tests that are left, patches of one time have
/// shares like their moves, and no more of them. Returns those that are better, in the order in
/// which they were annealed.
/// As anneal_patch otherwise; the result does not depend on the number of threads.
std::vector<AnnealedPatch> anneal_around(HingeFlips& hinges,
                                         const std::vector<std::vector<Index>>& sets, int rings,
                                         const FlipLimits& limits, const AnnealingOptions& options,
                                         std::int64_t& moves_left, Progress& progress,
                                         double stage_done);

}  // namespace shrinkwrap
