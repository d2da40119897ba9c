// Where a run ends at the parametric surface: membranes that stay, stretched between their rims.
#pragma once

#include <vector>

#include "common/progress.h"
#include "complete_matching/surface_openings.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Stretches the membranes that are far from samples and not left open (harmonic_surface.h) over
/// rims that are smoothed a little, and sets `is_stretched`: the initial mesh had them bulge, and
/// fitting knows nothing of them. Where faces would then meet others that they did not meet before,
/// vertices go back half of the way, twice, and at last all of it, and those around them so far
/// that none goes farther than its neighbour's share of its way by more than the two are distant. A
/// membrane that meets others even then goes back as a whole. So does one of more area than what
/// was seen of its body, as its other side, which would become a shell right behind what was seen.
///
/// A membrane that is no disc stays as it is if it would become a thin neck, or is such an other
/// side. All do if a fifth of the faces meet others anyway. The result does not depend on the order
/// of the membranes. As many searches for faces that meet others as it takes rounds, 34 at most;
/// the rest is O(F log F). Pre: no removed slots.
void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress);

}  // namespace shrinkwrap
