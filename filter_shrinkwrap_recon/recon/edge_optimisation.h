// Section 2.5, last step: edges re-chosen.
#pragma once

#include "progress.h"
#include "surface_mesh.h"

namespace shrinkwrap {

struct EdgeOptimisationOptions {
  enum class Criterion {
    bending,  ///< sum over the five hinge edges of length x |dihedral angle|, plus a term for triangle shape
    quadric,  ///< the paper's: keep the diagonal of lower quadric cost (eq. 12), here under the same guard
  };
  Criterion criterion = Criterion::bending;
  double shape_weight = 0.01;     ///< of sum (a^2 + b^2 + c^2) / (4 area), x mean hinge edge length
  double least_gain = 1e-5;       ///< x mean hinge edge length: smaller gains do not flip (planes would cycle)
};

struct EdgeOptimisationReport {
  Index flips = 0;
};

/// Flips edges while that lowers the criterion and turns no face away from the surface. Vertices do not move.
/// Pre: closed mesh, at best in Morton order. Post: same vertices, same topology, closed 2-manifold.
/// The same result for any number of threads.
EdgeOptimisationReport optimise_edges(SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                                      Progress& progress);

}  // namespace shrinkwrap
