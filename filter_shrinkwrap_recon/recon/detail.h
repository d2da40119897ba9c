// Detail that the control mesh has lost: the parametric surface is made anew of finer ones.
#pragma once

#include "fit_surface.h"
#include "reconstruct.h"
#include "stage_log.h"

namespace shrinkwrap {

/// Whether a run with these options looks at what the surface shows of the samples.
bool may_keep_detail(const ReconstructionOptions& options);

/// Parts that are sampled far more closely than the rest may be lost in the control mesh. If more
/// samples than `options.most_samples_far` are far from the surface, makes it anew of finer control
/// meshes, and keeps in `fitted` the one that is near most samples; brings `result.detail`, its
/// `control_mesh` and the last row of `log`, which is the control mesh's, up to date. There is a
/// surface already: that another cannot be made is no failure of the run. Pre: `fitted` was made
/// from `initial`, by way of `result.control_mesh`, and is not finished; see may_keep_detail.
void keep_detail(const SurfaceMesh& initial, const PointCloud& cloud,
                 const ReconstructionOptions& options, FittedSurface& fitted,
                 Reconstruction& result, StageLog& log, Progress& progress);

}  // namespace shrinkwrap
