#include "detail.h"

#include "common/attempted.h"

namespace shrinkwrap {
namespace {

constexpr Index kFiner = 4;
constexpr double kFewer = 0.75;  // x samples far: what is no nearer to most is only rougher

}  // namespace

bool may_keep_detail(const ReconstructionOptions& options) {
  return is_robust(options) && options.control_mesh.target_vertices == 0 &&
         options.most_samples_far < 1.0;
}

void keep_detail(const SurfaceMesh& initial, const PointCloud& cloud,
                 const ReconstructionOptions& options, FittedSurface& fitted,
                 Reconstruction& result, StageLog& log, Progress& progress) {
  DetailReport& detail = result.detail;
  const auto part_far = [&](const FittedSurface& of) {
    return part_of_samples_far(of.surface.mesh, cloud, result.noise.of_others(), progress);
  };
  const auto try_finer = [&](Index vertices) {
    const ControlMeshReport& coarse = result.control_mesh;
    if (vertices <= coarse.vertices || coarse.vertices >= coarse.vertices_before) return;
    ControlMeshOptions control_options = options.control_mesh;
    control_options.target_vertices = vertices;
    ControlMesh control = make_control_mesh(initial, cloud.size(), control_options, progress);
    round_to_host(control.mesh, cloud.frame, options.host_scalar);
    FittedSurface other = fit_surface(control.mesh, cloud, options, progress);
    ++detail.surfaces;
    const double far = part_far(other);
    if (far > kFewer * detail.far) return;
    detail.far = far;
    fitted = std::move(other);
    result.control_mesh = control.report;
    log.replace(control.mesh.vertex_count(),
                [&] { return to_result(control.mesh, cloud.frame, progress); });
  };
  detail.surfaces = 1;
  detail.far_at_first = detail.far = part_far(fitted);
  const Index finer = kFiner * result.control_mesh.target_vertices;
  attempted([&] {
    if (detail.far > options.most_samples_far && finer < cloud.size()) try_finer(finer);
    if (detail.far > options.most_samples_far) try_finer(cloud.size());
  });
}

}  // namespace shrinkwrap
