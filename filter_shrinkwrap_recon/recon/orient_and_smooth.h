// Sides and noise of the samples, and what noise changes in the stages that follow.
#pragma once

#include "reconstruct.h"

namespace shrinkwrap {

struct CloudReport {
  OrientationReport orientation;
  NoiseEstimate noise;
  DenoisingReport denoising;  ///< none moved if they are left as they are
};

/// Whether the surface is fitted to samples that are moved onto the one that they suggest, if they
/// have so much noise (NoiseEstimate::median).
bool may_denoise(const ReconstructionOptions& options, double noise);

/// Measures and orients the normals of a noisy cloud anew over wider neighbourhoods, moves its
/// samples onto the surface that they scatter about, and changes `options` of the later stages to
/// suit (larger voxels, none smaller for detail, a surface that follows the samples less closely),
/// the more so the noisier the samples are; where most are hardly noisy (0.04), only moves them.
/// `orientation` becomes that of the new normals, if there are any. Pre: `progress` is in
/// Stage::orientation.
DenoisingReport smooth_for_noise(PointCloud& cloud, const NoiseEstimate& noise,
                                 ReconstructionOptions& options, OrientationReport& orientation,
                                 Progress& progress);

/// Orients the normals and estimates the noise. Above `options.noise.high` handles are to be
/// refuted by larger voxels, and no voxels are smaller. If the run stops at the parametric surface,
/// and there is enough noise in the cloud or in a part of it (DenoisingOptions), then the samples
/// are moved onto the surface that they scatter about, with normals of neighbourhoods that are the
/// wider the noisier the samples are, and `options` of the later stages are changed to suit (larger
/// voxels; see NoiseOptions). A chain of stages gives the same as `reconstruct` if each that needs
/// normals begins with this; if the smoothed surface is taken (see SecondAttempt), with
/// `stop_at_parametric_surface` set and `before_initial_mesh_from` 0, and the matching then goes on
/// with `undo_denoising`; if the run stops at the surface of a cloud that is clean but for a tenth
/// of it (before_initial_mesh_part), so from the parametric surface on; if backs are openings, with
/// `backs_are_openings`; if the surface was made anew, with `target_vertices` of the control mesh
/// that stayed; unless `stop_at` turned a body outwards that was fitted inside out, and is matched
/// so by `reconstruct`. Pre: the cloud was prepared with `options.samples`.
CloudReport orient_and_smooth(PointCloud& cloud, ReconstructionOptions& options,
                              Progress& progress);

}  // namespace shrinkwrap
