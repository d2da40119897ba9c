// Section 2.5: the feet of all samples become vertices of the parametric surface.
#pragma once

#include "mesh/surface_mesh.h"
#include "parametric_surface/sample_feet.h"

namespace shrinkwrap {

/// Inserts a vertex at the foot of every sample by 1-to-3 splits of the face that holds it, in the
/// plane of that face: vertex V + i stands for sample i, V being the vertices of the surface. Feet
/// are kept off the edges and off each other by a small part of the (sub-)triangle they fall into,
/// so that every new face has an area, unless more than five lie on one edge of it. A face of k
/// feet costs O(k log k) expected, whatever the order of the samples, if few of them lie on its
/// edges. Parallel. Pre: no removed faces or vertices. Post: closed 2-manifold of the same
/// topology; the faces made of one face of the surface follow each other in the order of the
/// surface.
SurfaceMesh insert_feet(SurfaceMesh surface, const SampleFeet& feet, Progress& progress);

}  // namespace shrinkwrap
