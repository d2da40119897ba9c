// The paper's own start (section 2.2, eq. 3-8): a subdivided bounding box shrunk onto the nearest samples.
#pragma once

#include "initial_mesh.h"

namespace shrinkwrap {

/// Vertices of a genus-0 mesh after one 1-to-4 subdivision (eq. 3): 4V - 6.
constexpr Index subdivided_vertices(Index vertices) { return 4 * vertices - 6; }

/// The number of 1-to-4 subdivisions of the 8-vertex box: the largest whose vertices are at most a quarter of the
/// samples (1,538 vertices for 12,321 samples and 6,146 for 34,267, as in tables 1 and 2).
int levels_for(Index samples);

/// Shrink-wraps the bounding box level by level: eq. 4-5 with xi = `projection`, eq. 6-8 with eta = `box_relaxation`.
InitialMesh shrink_bounding_box(const PointCloud& cloud, const VoxelSearch& search,
                                const InitialMeshOptions& options, Progress& progress);

}  // namespace shrinkwrap
