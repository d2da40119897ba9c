// What a mesh is, measured: closed, 2-manifold, one vertex per sample at its exact coordinates,
// outward.
#pragma once

#include <string>
#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// What a list of triangles is, whatever made it. Counts, never assumptions.
struct MeshReport {
  Index vertices = 0;  ///< used by faces
  Index edges = 0;
  Index faces = 0;
  Index degenerate_faces = 0;  ///< repeated vertex
  Index border_edges = 0;      ///< edges of one face
  Index border_loops = 0;
  Index nonmanifold_edges = 0;      ///< edges of more than two faces
  Index nonmanifold_vertices = 0;   ///< vertices whose faces are not one fan
  Index misoriented_edges = 0;      ///< edges whose two faces run along them in the same direction
  Index components = 0;             ///< by edges
  Index components_flat = 0;        ///< of a closed mesh: without volume, see signed_volumes
  Index cavities = 0;               ///< of a closed 2-manifold: see bodies.h
  Index components_inside_out = 0;  ///< of a closed 2-manifold
  Index genus =
      -1;  ///< summed over components; -1 unless manifold (openings are counted as capped)
  double volume = 0.0;                 ///< signed, of a closed mesh; may under- or overflow
  bool volume_is_positive = false;     ///< also where the number itself is too small or too large
  Index self_intersecting_faces = -1;  ///< -1: not counted

  Index samples = 0;          ///< distinct input samples
  Index samples_matched = 0;  ///< that are exactly one used vertex, bit for bit
  Index samples_missing = 0;
  Index samples_matched_twice = 0;
  Index vertices_extra = 0;  ///< used vertices that are no sample

  bool closed() const { return faces > 0 && border_edges == 0; }
  bool manifold() const {
    return faces > 0 && degenerate_faces == 0 && nonmanifold_edges == 0 &&
           nonmanifold_vertices == 0 && misoriented_edges == 0;
  }
  bool complete_matching() const {
    return samples_missing == 0 && samples_matched_twice == 0 && vertices_extra == 0 &&
           samples_matched == samples;
  }
  /// A flat component has no outside to face.
  bool outward() const {
    return closed() && manifold() && (volume_is_positive || components_flat == components);
  }
};

struct MeshReportOptions {
  bool count_self_intersections = true;
};

/// Measures a mesh against samples (both in one frame). Samples equal to an earlier one or not
/// finite are left out. O((V + F) log) time.
MeshReport measure_mesh(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                        const std::vector<Vec3>& samples, const MeshReportOptions& options,
                        Progress& progress);

/// The report in lines for a log.
std::vector<std::string> describe(const MeshReport& report);

}  // namespace shrinkwrap
