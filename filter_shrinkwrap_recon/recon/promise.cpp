#include "promise.h"

namespace shrinkwrap {

MeshReport check_promise(const ResultMesh& mesh, const std::vector<Vec3>& samples, Index counted,
                         const ReconstructionOptions& options, Progress& progress) {
  MeshReportOptions report_options = options.report;
  if (counted != kNone) report_options.count_self_intersections = false;
  MeshReport report =
      measure_mesh(mesh.position, mesh.triangles, samples, report_options, progress);
  if (counted != kNone) report.self_intersecting_faces = counted;

  const bool may_be_open =
      options.complete_matching.openings != CompleteMatchingOptions::Openings::close;
  const auto fail = [](const std::string& part) {
    throw ReconstructionFailed(
        "the mesh would not be " + part +
        ": nothing was made. Try another voxel size or level for the initial mesh, remove "
        "stray points, or stop at the parametric surface if the cloud is noisy.");
  };
  if (!report.manifold()) fail("a 2-manifold");
  if (!report.closed() && !may_be_open) fail("closed");
  if (report.closed() && !report.outward()) fail("oriented outwards");
  if (options.stop_at_parametric_surface) return report;
  if (report.samples_missing > 0)
    fail("complete (" + std::to_string(report.samples_missing) + " samples are no vertex)");
  if (report.samples_matched_twice > 0) fail("one to one");
  return report;
}

}  // namespace shrinkwrap
