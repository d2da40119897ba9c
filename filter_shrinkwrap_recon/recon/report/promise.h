// What a run promises, checked on the mesh that it is about to return.
#pragma once

#include <vector>

#include "report/mesh_report.h"
#include "report/result_mesh.h"

namespace shrinkwrap {

struct PromiseOptions {
  bool may_be_open = false;     ///< openings of the scan may be left open
  bool matches_samples = true;  ///< every sample is exactly one vertex
  MeshReportOptions report;
};

/// Measures `mesh` against the samples, the caller's. `self_intersecting_faces`: of the mesh as it
/// is, if they are known; kNone to have them counted as the options want it. Throws
/// ReconstructionFailed, which says what does not hold, unless the mesh is a 2-manifold, closed and
/// oriented outwards, and matches the samples, as far as the options promise it.
MeshReport check_promise(const ResultMesh& mesh, const std::vector<Vec3>& samples,
                         Index self_intersecting_faces, const PromiseOptions& options,
                         Progress& progress);

}  // namespace shrinkwrap
