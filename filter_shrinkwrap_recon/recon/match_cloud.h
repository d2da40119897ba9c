// From the parametric surface to a mesh through every sample.
#pragma once

#include <vector>

#include "reconstruct.h"

namespace shrinkwrap {

/// `match_samples`, without samples that stand alone off the surface (outliers_off_surface.h). If
/// some of the outliers lie on the mesh, they become samples of the cloud, and the surface is
/// matched once more (outliers_on_surface.h). `points`: those that the cloud is of;
/// `noise`: of others than are noisier (NoiseEstimate).
CompleteMatching match_cloud(SurfaceMesh parametric, PointCloud& cloud, OutlierReport& outliers,
                             const std::vector<Vec3>& points, double noise,
                             const ReconstructionOptions& options, Progress& progress);

/// Of another attempt, which is to be of as many samples as the first: that no outlier becomes a
/// sample, and no sample an outlier.
void keep_samples(ReconstructionOptions& options);

struct OptimisedMesh {
  ResultMesh mesh;  ///< in the caller's frame, with face qualities as Reconstruction::mesh has them
  OpeningsReport openings;
  EdgeOptimisationReport edge_optimisation;
  RepairReport intersection_repair;  ///< `faces_after` and `remaining_faces` are of `mesh`
  Index removed_extra = 0;           ///< vertices that are no sample, removed by the repair
  Index extra_vertices = 0;          ///< that stay
};

/// From the complete matching to the mesh: decides on the openings, chooses the edges, parts faces
/// that meet others if `options` say so, and leaves out the faces of what stays open. `matching` is
/// brought up to date, but for the faces left out. `points` are those that the cloud is of.
OptimisedMesh optimise_matching(CompleteMatching& matching, const PointCloud& cloud,
                                const std::vector<Vec3>& points,
                                const ReconstructionOptions& options, Progress& progress);

}  // namespace shrinkwrap
