// Where a run ends at the parametric surface: membranes that stay, stretched between their rims.
#pragma once

#include <vector>

#include "progress.h"
#include "surface_mesh.h"
#include "surface_openings.h"

namespace shrinkwrap {

/// Stretches the membranes that are far from samples and not left open (harmonic_surface.h) over
/// rims that are smoothed a little, and sets `is_stretched`: the initial mesh had them bulge, and
/// fitting knows nothing of them. Where faces would then meet others, though they did not before,
/// vertices go back half of the way, twice, and at last all of it, and those around them less and
/// less; what meets others still, goes back as a whole. So does a membrane of more area than what
/// was seen of its body, as its other side, of which it may show nothing but a flat shell. One of
/// several rims stays as it is if it would become a thin neck or is such an other side, and all do
/// if a fifth of the faces meet others anyway.
void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress);

}  // namespace shrinkwrap
