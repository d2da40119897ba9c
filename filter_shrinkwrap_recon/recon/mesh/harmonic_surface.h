// Fairing: patches of a mesh stretched like a membrane, harmonic between what surrounds them.
#pragma once

#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Moves some vertices to where the membrane energy, the integral of the squared gradient of the
/// position, is least while the others stay (Botsch, Kobbelt, Pauly, Alliez, Levy: Polygon Mesh
/// Processing, 4.2.1): in the metric of the patch as it is, by its cotangents (Pinkall and Polthier
/// 1993), none of which counts as negative. Within a flat rim the patch becomes flat, and nowhere
/// does it leave the convex hull of its rim.
///
/// `vertices`: ascending; each piece of them that hangs together has a neighbour that stays.
/// Returns false, and leaves the mesh as it was, if the system cannot be solved. Near-linear: the
/// number of iterations hardly depends on that of the vertices. Deterministic. Throws Cancelled.
bool make_harmonic(SurfaceMesh& mesh, const std::vector<Index>& vertices, Progress& progress);

}  // namespace shrinkwrap
