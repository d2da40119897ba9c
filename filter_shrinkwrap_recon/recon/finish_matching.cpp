#include "finish_matching.h"

#include <algorithm>

#include "close_openings.h"
#include "self_intersection.h"

namespace shrinkwrap {
namespace {

// Faces that meet others once the opening faces are dropped.
std::vector<Index> meeting_faces_that_stay(const CompleteMatching& matching, Progress& progress) {
  const SurfaceMesh& mesh = matching.mesh;
  const std::vector<Index>& open = matching.opening_faces;
  std::vector<Index> staying;
  std::vector<Triangle> triangles;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    if (std::binary_search(open.begin(), open.end(), f)) continue;
    staying.push_back(f);
    triangles.push_back(mesh.triangle(f));
  }
  std::vector<Index> meeting = self_intersecting_faces(mesh.position, triangles, progress);
  for (Index& f : meeting) f = staying[f];
  return meeting;
}

}  // namespace

FinishReport finish_matching(CompleteMatching& matching, Index samples, double spacing,
                             const RepairOptions& options, OpeningsReport& openings,
                             Progress& progress) {
  FinishReport report;
  RepairReport& repair = report.repair;
  repair = repair_self_intersections(matching.mesh, options, progress, matching.opening_faces);
  if (matching.spanning_faces.empty()) return report;
  if (extra_vertices_kept(matching.mesh, samples, matching.opening_faces) > 0) {
    report.removed_extra = close_openings(matching, samples, progress);
    if (repair.faces_after > 0) {
      // Flips may part what is left now, and all faces have other indices.
      repair.add(
          repair_self_intersections(matching.mesh, options, progress, matching.opening_faces));
    }
  }
  measure_openings(matching, spacing, openings);
  if (repair.faces_after > 0 && !matching.opening_faces.empty()) {
    repair.remaining_faces = meeting_faces_that_stay(matching, progress);
    repair.faces_after = static_cast<Index>(repair.remaining_faces.size());
  }
  return report;
}

}  // namespace shrinkwrap
