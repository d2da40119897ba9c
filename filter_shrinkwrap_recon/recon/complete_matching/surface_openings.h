// Openings of the scan where a run ends at the parametric surface: its membranes, which stay
// (membrane_stretching.h) or are left out.
#pragma once

#include <vector>

#include "common/progress.h"
#include "complete_matching/complete_matching.h"
#include "complete_matching/openings.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// A part of the surface that no sample supports, wide enough to be an opening of the scan: along
/// the surface a vertex of it is farther than `membrane_high` spacings from the samples.
struct SurfaceMembrane {
  std::vector<Index> vertices;  ///< ascending
  double width = 0.0;  ///< x median spacing: twice the greatest such distance; infinite without rim
  bool is_far = false;  ///< a vertex is as far from every sample as the crow flies, too: it is not
                        ///< the back of a sheet close behind its front
  bool is_left_open = false;  ///< as the options say
  bool is_stretched = false;
};

/// The openings, each a piece of `is_membrane` (per vertex, see mark_membranes) that hangs
/// together, after vertices have joined the majority of their neighbours, so that the outline is no
/// more ragged than it has to be. Ordered by their lowest vertices. O(V) expected where no vertex
/// is a membrane's, else O(V log V), parallel but for the distances along the surface. None if
/// there are so few samples that their normals tell no side.
std::vector<SurfaceMembrane> find_surface_membranes(const SurfaceMesh& surface,
                                                    std::vector<char> is_membrane,
                                                    const PointCloud& cloud,
                                                    const CompleteMatchingOptions& options,
                                                    Progress& progress);

/// What becomes of the faces of membranes, those with a corner in one.
struct SurfaceOpenings {
  std::vector<Index> opening_faces;   ///< to be dropped, ascending
  std::vector<Index> spanning_faces;  ///< those too, and those that stay; ascending
  OpeningsReport report;
};
/// Chooses the faces to be dropped (cut_openings), and smooths the borders that they leave if these
/// are no shorter than 16 edges and no faces there would meet others for it: their vertices move.
SurfaceOpenings cut_surface_openings(SurfaceMesh& surface,
                                     const std::vector<SurfaceMembrane>& membranes,
                                     Progress& progress);

}  // namespace shrinkwrap
