// Colours and other data of the samples, for the vertices of a mesh that are none.
#pragma once

#include <vector>

#include "common/progress.h"
#include "report/result_mesh.h"

namespace shrinkwrap {

/// Fills in `data_index` of each mesh: of a vertex that is a sample, the sample, of another the
/// nearest of the caller's `points`, those `left_out` (ascending) left out. Stays empty if every
/// vertex is a sample. O((V + N) log N) for all of them, parallel; O(V) if all vertices are.
void carry_data(const std::vector<ResultMesh*>& meshes, const std::vector<Vec3>& points,
                const std::vector<Index>& left_out, Progress& progress);

}  // namespace shrinkwrap
