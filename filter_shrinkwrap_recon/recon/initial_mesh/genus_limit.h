// A greatest genus that the user imposes: handles are cut.
#pragma once

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Genus of a closed mesh, summed over its components. O(V), parallel.
Index genus_of(const SurfaceMesh& mesh, Progress& progress);

struct GenusLimitReport {
  Index cut = 0;     ///< handles
  int rounds = 0;    ///< in each of which many may be cut
  int searches = 0;  ///< of the whole mesh for loops
};

/// Cuts handles until the genus is at most `maximum`: along loops of edges that do not separate the
/// surface (surface_loops.h), made short by searching again from where they pass, and closes both
/// sides of each with a fan. A thin bridge is severed, a narrow tunnel filled. Each round cuts
/// those loops that are at most twice as long as the shortest, have no vertex in common, and
/// together leave the surface in one piece; so that the shortest go first, rounds are few even for
/// thousands of handles. Pre: no removed slots, maximum >= 0. Post: closed 2-manifold in canonical
/// order; the samples' places play no part. O(V log V) per round.
GenusLimitReport limit_genus(SurfaceMesh& mesh, Index maximum, Progress& progress);

}  // namespace shrinkwrap
