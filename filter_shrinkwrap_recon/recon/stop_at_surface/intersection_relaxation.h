// Self-intersections smoothed away: for a surface whose vertices are free to move.
#pragma once

#include <vector>

#include "common/progress.h"
#include "edge_optimisation/intersection_repair.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

struct RelaxationOptions {
  int max_rounds = 100;
  double most_growth = 2.5;  ///< ends when more than so many times as many faces meet as at first
  int steps = 4;             ///< of smoothing in a round, and one more for each ring
  double weight = 0.5;       ///< of a step: part of the way to the mean of the neighbours, 0 to 1
  int rounds_a_ring = 5;     ///< after so many rounds one more ring of faces around is smoothed too
  /// If more than this part of the faces meet others, the surface is left as it is: a heap.
  double most = 0.2;
  RepairOptions repair;  ///< of what smoothing leaves
};

struct RelaxationReport {
  Index faces_before = 0;  ///< that meet others
  Index faces_after = 0;
  std::vector<Index> remaining_faces;  ///< those, ascending
  Index moved = 0;                     ///< vertices
  Index flips = 0;  ///< of edges and relocated vertices, where moving did not help
  int rounds = 0;   ///< tried, also after the one that was kept
};

/// Smooths the neighbourhoods of faces that meet others, wider and wider, until none does, or far
/// more do: the folds of a parametric surface unfold, and sheets that overlap a little draw back.
/// Where sheets pass through each other, more and more faces may meet as the surface around
/// shrinks: of all rounds the vertices keep where the fewest did. Faces elsewhere stay as they are.
/// What is left is repaired by `repair_self_intersections`. Vertices move to where the host has
/// them, as faces might meet if they were rounded later (`frame`: the mesh's, in which its vertices
/// are of `scalar`). Finding the faces costs as much as `self_intersecting_faces`; the rest is
/// proportional to their number, but for a flag for each face in each round. Deterministic. Pre: no
/// removed slots.
RelaxationReport relax_self_intersections(SurfaceMesh& mesh, const Frame& frame, HostScalar scalar,
                                          const RelaxationOptions& options, Progress& progress);

}  // namespace shrinkwrap
