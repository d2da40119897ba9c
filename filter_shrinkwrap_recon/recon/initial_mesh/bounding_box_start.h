// The paper's own start (section 2.2, eq. 3-8): a subdivided bounding box shrunk onto the nearest
// samples.
#pragma once

#include <cstdint>

#include "initial_mesh/initial_mesh.h"

namespace shrinkwrap {

/// Vertices of a genus-0 mesh after one 1-to-4 subdivision (eq. 3): 4V - 6.
constexpr Index subdivided_vertices(Index vertices) {
  return 4 * vertices - 6;
}

/// The number of 1-to-4 subdivisions of the 8-vertex box: the largest whose vertices are at most a
/// quarter of the samples (1,538 vertices for 12,321 samples and 6,146 for 34,267, as in tables 1
/// and 2); 0 if there is none.
int levels_for(Index samples);

/// Vertices of the box after so many subdivisions.
std::uint64_t vertices_after(int levels);

/// What the start shrinks: the box of the samples with a margin of a spacing, in the unit frame.
SurfaceMesh box_around(const PointCloud& cloud);

/// The closed mesh of a box: 8 vertices, 12 triangles, outward. Pre: low < high on every axis.
SurfaceMesh box_mesh(const Vec3& low, const Vec3& high);

/// Splits every face into four at the midpoints of its edges. The vertices given come first, then
/// the midpoints in the order of their first half-edge. O(F), parallel. Pre: no free slots.
SurfaceMesh midpoint_subdivide(const SurfaceMesh& mesh, Progress& progress);

/// Shrink-wraps the bounding box: at each level a subdivision, then `iterations_per_level` times
/// eq. 4-5 with xi = `projection` and eq. 6-8 with eta = `box_relaxation`, all vertices at once.
/// `levels` below 0 means levels_for. Throws InvalidInput if `levels` is more than 12. Post:
/// closed, genus 0, canonical order. O(V log N), parallel, the same for any number of threads.
InitialMesh shrink_bounding_box(const PointCloud& cloud, const InitialMeshOptions& options,
                                Progress& progress);

}  // namespace shrinkwrap
