#include "orient_and_smooth.h"

#include <algorithm>
#include <cmath>

namespace shrinkwrap {

bool may_denoise(const ReconstructionOptions& options, double noise) {
  return options.stop_at_parametric_surface && is_robust(options) &&
         noise >= options.denoising.from;
}

DenoisingReport smooth_for_noise(PointCloud& cloud, const NoiseEstimate& noise,
                                 ReconstructionOptions& options, OrientationReport& orientation,
                                 Progress& progress) {
  constexpr double kWider = 1.0, kLargerVoxels = 0.35;
  constexpr double kNoisyFrom = 0.04;  // below: what the upper fifth tells may be thin parts
  constexpr double kAttraction = 0.4, kRelaxation = 0.3;  // from one unit on
  const NoiseOptions& limits = options.noise;
  const bool is_noisy = noise.median >= kNoisyFrom;
  const double units =
      is_noisy ? std::clamp((noise.upper_fifth - limits.smooth_from) / limits.smooth_unit, 0.0,
                            std::max(limits.most_units, 0.0))
               : 0.0;
  const int neighbours = options.samples.neighbours;
  if (units > 0.0) {
    const double widening = cloud.conditioning.on_lines ? 0.0 : kWider * units;
    const int wider = static_cast<int>(std::lround(neighbours * (1.0 + widening)));
    OrientationOptions orientation_options = options.orientation;
    orientation_options.plane_neighbours = std::max(orientation_options.plane_neighbours, wider);
    progress.set_part(0.2, 0.3);
    measure_neighbourhoods(cloud, wider, progress);
    progress.set_part(0.3, 0.45);
    orientation = orient_normals(cloud, orientation_options, progress);
  }
  progress.set_part(0.45, 1.0);
  const DenoisingReport report =
      denoise(cloud, noise.of_others(), neighbours, options.denoising, progress);
  options.initial_mesh.voxel_size *= 1.0 + kLargerVoxels * units;
  if (is_noisy) options.initial_mesh.voxel_ratio_for_detail = 0.0;
  const double part = std::min(units, 1.0);
  const auto towards = [&](double& value, double at_one) { value += part * (at_one - value); };
  towards(options.parametric_surface.attraction, kAttraction);
  towards(options.parametric_surface.relaxation, kRelaxation);
  return report;
}

CloudReport orient_and_smooth(PointCloud& cloud, ReconstructionOptions& options,
                              Progress& progress) {
  CloudReport report;
  options.samples.neighbours = cloud.neighbour_count;  // more, if they would lie on lines
  const bool may_smooth = options.stop_at_parametric_surface && is_robust(options);
  // Parts of the time of the stage: where a run may smooth, that takes most.
  const double oriented = may_smooth ? 0.15 : (is_robust(options) ? 0.7 : 0.98);
  const double told = may_smooth ? 0.2 : 1.0;
  progress.begin(Stage::orientation);
  progress.set_part(0.0, oriented);
  report.orientation = orient_normals(cloud, options.orientation, progress);
  progress.set_part(oriented, oriented + 0.02);
  report.noise = estimate_noise(cloud, options.noise, progress);
  if (report.noise.median > options.noise.high) {
    options.initial_mesh.dense_spacing = options.initial_mesh.voxel_ratio_for_detail = 0.0;
    if (options.initial_mesh.second_voxel_ratio > 0.0)
      options.initial_mesh.second_voxel_ratio = options.noise.second_voxel_ratio;
  }
  progress.set_part(oriented + 0.02, told);
  if (is_robust(options))
    report.noise.more =
        measure_more_noise(cloud, report.noise.median, options.more_noise, progress);
  if (!may_denoise(options, report.noise.median)) return report;
  if (report.noise.median >= options.denoising.before_initial_mesh_from ||
      report.noise.more.part > options.denoising.before_initial_mesh_part)
    report.denoising = smooth_for_noise(cloud, report.noise, options, report.orientation, progress);
  return report;
}

}  // namespace shrinkwrap
