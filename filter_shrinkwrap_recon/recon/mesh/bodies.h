// Which components of a closed mesh are cavities of others, and which are inside out.
#pragma once

#include <vector>

#include "common/types.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

struct ComponentVolumes {
  std::vector<double> volume;  ///< signed, 0 of a flat component
  Index flat = 0;              ///< components of less volume than its sum is rounded by
};

/// The volumes of closed components, times the cube of `scale`, which should be a power of two and
/// bring the coordinates to a moderate size. A flat component has no inside: moving its faces by
/// eight roundings of their coordinates changes its volume by as much as it has. Faces that are not
/// finite count as nothing, and components with such faces not as flat. O(F), parallel, the same
/// for any number of threads. `component_of_face`: below `components`.
ComponentVolumes signed_volumes(const std::vector<Vec3>& position,
                                const std::vector<Triangle>& triangles,
                                const std::vector<Index>& component_of_face, Index components,
                                double scale, Progress& progress);

struct ComponentSides {
  std::vector<Index> cavities;    ///< within the solid of others, whichever way they face
  std::vector<Index> inside_out;  ///< a body of negative volume, or a cavity of positive volume
};

/// Looks from each component along a ray through the faces of all others: within their solid it is
/// a cavity. Of a component that is inside out, the side counts that it should have.
/// `component_of_face`: indices into `volume`, which is signed, and 0 for a component that is not
/// to be judged, and what such a component encloses is not either. Both lists ascend. Where
/// components meet one another the answer is a guess, but what reaches beyond another is no cavity
/// of it. O(F log C) unless many components lie in one row, parallel, the same for any number of
/// threads. Pre: closed components.
ComponentSides find_sides(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                          const std::vector<Index>& component_of_face,
                          const std::vector<double>& volume, Progress& progress);

/// Turns the faces of components that are inside out: few samples leave both sides alike to the
/// stages, and a sheet that is seen from its hollow side is so once it is closed. Components with
/// `opening_faces` (ascending) keep the side that is seen. Faces and vertices keep their indices.
/// Returns how many components were turned. Pre: closed mesh without removed slots.
Index turn_outward(SurfaceMesh& mesh, const std::vector<Index>& opening_faces, Progress& progress);

}  // namespace shrinkwrap
