// Openings of the scan where a run ends at the parametric surface: its membranes, stretched or
// left out.
#pragma once

#include <vector>

#include "complete_matching.h"
#include "openings.h"
#include "progress.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// A part of the surface that no sample supports.
struct SurfaceMembrane {
  std::vector<Index> vertices;  ///< ascending
  bool is_wide = false;  ///< one of them is farther than `membrane_high` spacings from every sample
  bool is_stretched = false;
};

/// The pieces of `is_membrane` (per vertex, see mark_membranes) that hang together, after vertices
/// have joined the majority of their neighbours, so that the outline is no more ragged than it has
/// to be. Ordered by their lowest vertices. O(V).
std::vector<SurfaceMembrane> find_surface_membranes(const SurfaceMesh& surface,
                                                    std::vector<char> is_membrane,
                                                    const PointCloud& cloud,
                                                    const CompleteMatchingOptions& options,
                                                    Progress& progress);

/// Stretches the wide membranes (harmonic_surface.h) over rims that are smoothed a little, and sets
/// `is_stretched`: the initial mesh had them bulge, and fitting knows nothing of them. One whose
/// faces would then meet others goes back half of the way, twice, and at last all of it; one of
/// several rims that would become a thin neck stays as it is.
void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress);

/// What becomes of the openings, as the options say (CompleteMatchingOptions::Openings; the width
/// of one is twice the greatest distance of its vertices from samples of their own side). The
/// borders of those that are left open are smoothed a little: these vertices move.
struct SurfaceOpenings {
  std::vector<Index> opening_faces;   ///< to be dropped, ascending
  std::vector<Index> spanning_faces;  ///< those too, and the others of wide membranes; ascending
  OpeningsReport report;
};
SurfaceOpenings decide_surface_openings(SurfaceMesh& surface,
                                        const std::vector<SurfaceMembrane>& membranes,
                                        const PointCloud& cloud,
                                        const CompleteMatchingOptions& options, Progress& progress);

}  // namespace shrinkwrap
