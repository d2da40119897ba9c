// Colours and other data of the samples, for the vertices of a mesh that are none.
#pragma once

#include <vector>

#include "common/progress.h"
#include "report/result_mesh.h"

namespace shrinkwrap {

/// Fills in `mesh.data_index`: of a vertex that is a sample, the sample, of another the nearest of
/// the caller's `points`, those `left_out` (ascending) left out. Stays empty if every vertex is a
/// sample. O((V + N) log N) otherwise, parallel.
void carry_data(ResultMesh& mesh, const std::vector<Vec3>& points,
                const std::vector<Index>& left_out, Progress& progress);

}  // namespace shrinkwrap
