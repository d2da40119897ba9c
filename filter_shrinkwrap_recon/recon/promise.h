// What a run promises, checked on the mesh that it is about to return.
#pragma once

#include <vector>

#include "reconstruct.h"

namespace shrinkwrap {

/// Measures `mesh` against the samples that it must pass through. `counted`: self-intersecting
/// faces of the mesh as it is, if they are known; kNone to have them counted as
/// `options.report` wants it. Throws ReconstructionFailed, which says what does not hold, unless
/// the mesh is a 2-manifold, closed and oriented outwards (openings may be left open where the
/// options say so), and every sample is exactly one vertex (not where a run stops at the parametric
/// surface).
MeshReport check_promise(const ResultMesh& mesh, const std::vector<Vec3>& samples, Index counted,
                         const ReconstructionOptions& options, Progress& progress);

}  // namespace shrinkwrap
