// A greatest genus that the user imposes: handles are cut.
#pragma once

#include "progress.h"
#include "surface_mesh.h"

namespace shrinkwrap {

/// Genus of a closed mesh, summed over its components. O(V), parallel.
Index genus_of(const SurfaceMesh& mesh, Progress& progress);

/// Cuts handles until the genus is at most `maximum`: along a loop of edges that does not separate
/// the surface, made short by searching again from where it passes (a shortest loop through one
/// vertex is found by a tree and a cotree: Erickson and Whittlesey 2005), and closes both sides
/// with a fan. A thin bridge is severed, a narrow tunnel filled. Returns how many were cut.
/// Pre: no removed slots, maximum >= 0. Post: closed 2-manifold in canonical order; the samples'
/// places play no part. O(V log V) per handle.
Index limit_genus(SurfaceMesh& mesh, Index maximum, Progress& progress);

}  // namespace shrinkwrap
