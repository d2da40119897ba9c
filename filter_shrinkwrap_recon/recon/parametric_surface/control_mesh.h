// Section 2.3: the control mesh, by quadric edge contraction (Garland and Heckbert 1997).
#pragma once

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

struct ControlMeshOptions {
  /// Vertices wanted; 0: the count from which two subdivisions come nearest to the number of
  /// samples.
  Index target_vertices = 0;
  /// Weigh the plane of a face by its area (false: eq. 11 as printed).
  bool area_weighted = true;
  /// Refuse contractions that turn a face normal by more than this cosine allows (cosine of about
  /// 78 degrees).
  double normal_guard = 0.2;
};

struct ControlMeshReport {
  Index vertices_before = 0;
  Index target_vertices = 0;
  /// Above the target only where contractions were refused. One that was is tried again only if its
  /// edge has changed.
  Index vertices = 0;
};

struct ControlMesh {
  SurfaceMesh mesh;  ///< same topology as the input, no removed slots
  ControlMeshReport report;
};

/// V_c with 16 V_c - 15 chi nearest to N: round((N + 15 chi) / 16), chi the Euler characteristic (2
/// per component of genus 0: 772 for 12,321 samples and 2,144 for 34,267), at least 4 per
/// component.
Index control_vertices_for(Index samples, Index euler_characteristic, Index components);

/// Contracts edges in order of quadric cost (eq. 9-12), each only under the link condition and the
/// normal guard. A mesh at or below the target is returned as it is. Deterministic; O(V log V).
ControlMesh make_control_mesh(SurfaceMesh mesh, Index samples, const ControlMeshOptions& options,
                              Progress& progress);

}  // namespace shrinkwrap
