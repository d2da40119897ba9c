// The parametric surface of a run, and the mesh of a run that stops at it.
#pragma once

#include <vector>

#include "complete_matching/surface_openings.h"
#include "reconstruct.h"

namespace shrinkwrap {

struct FittedSurface {
  ParametricSurface surface;
  std::vector<SurfaceMembrane> membranes;  ///< where the run stops at the surface
  RelaxationReport relaxation;
  OpeningsReport openings;  ///< that `stop_at` made
  SurfaceDetail detail;     ///< that `stop_at` kept, or measured
};

/// Makes the parametric surface, closed, and rounds it to `options.host_scalar`. One at which the
/// run stops is yet to be finished, and is rounded then.
FittedSurface fit_surface(SurfaceMesh control, const PointCloud& cloud,
                          const ReconstructionOptions& options, Progress& progress);

/// Where the run stops at the surface: stretches the membranes that are to stay and smooths faces
/// that meet others apart; both reports are of that. Otherwise does nothing.
void finish_surface(FittedSurface& fitted, const PointCloud& cloud,
                    const ReconstructionOptions& options, Progress& progress);

/// Such a surface as a result, with its openings as the options said: face quality as in
/// Reconstruction. Bodies face outwards if the run stops there; else as they were fitted. Fills in
/// `openings`, and counts anew which faces meet if some were dropped. Of a denoised cloud without
/// openings, or if all are left open, that is farther from the surface than noise explains
/// (SamplesOnSurfaceOptions), the result is instead the complete matching of the samples, which
/// have moved onto it but for the detail; not if that had more faces that meet others or vertices
/// that are no samples, nor without `intersection_repair`, which counts them. Fills in `detail`
/// too; the cloud then has the samples where they have moved, in the same order. `points`: those
/// that the cloud is of. `noise`: `NoiseEstimate::of_others`. Throws ReconstructionFailed if all
/// faces would be dropped.
ResultMesh stop_at(FittedSurface& fitted, PointCloud& cloud, const std::vector<Vec3>& points,
                   double noise, const ReconstructionOptions& options, Progress& progress);

}  // namespace shrinkwrap
