#include "report/promise.h"

namespace shrinkwrap {

MeshReport check_promise(const ResultMesh& mesh, const std::vector<Vec3>& samples,
                         Index self_intersecting_faces, const PromiseOptions& options,
                         Progress& progress) {
  const bool is_counted = self_intersecting_faces != kNone;
  MeshReportOptions report_options = options.report;
  if (is_counted) report_options.count_self_intersections = false;
  MeshReport report =
      measure_mesh(mesh.position, mesh.triangles, samples, report_options, progress);
  if (is_counted) report.self_intersecting_faces = self_intersecting_faces;

  const auto fail = [&](const std::string& part) {
    throw ReconstructionFailed(
        "the mesh would not be " + part +
        ": nothing was made. Try another voxel size or level for the initial mesh" +
        (options.matches_samples
             ? ", remove stray points, or stop at the parametric surface if the cloud is noisy."
             : ", or remove stray points."));
  };
  if (!report.manifold()) fail("a 2-manifold");
  if (!report.closed() && !options.may_be_open) fail("closed");
  if (report.closed() && !report.outward()) fail("oriented outwards");
  if (!options.matches_samples) return report;
  if (report.samples_missing > 0)
    fail("complete (" + std::to_string(report.samples_missing) + " samples are no vertex)");
  if (report.samples_matched_twice > 0) fail("one to one");
  return report;
}

}  // namespace shrinkwrap
