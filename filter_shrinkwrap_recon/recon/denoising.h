// Noisy samples moved onto the surface that they scatter about.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

struct DenoisingOptions {
  /// Clouds with less noise are left as they are (x local spacing): clean ones, for example, whose
  /// finest detail looks like noise of up to 0.06.
  double from = 0.08;
  /// Radius of the smallest neighbourhood, x local spacing: `first_radius`, and so many times the
  /// noise. 13 samples at a noise of 0.1, 50 at 0.7.
  double first_radius = 1.7, radius_per_noise = 3.3;
  /// Samples whose normals differ more lie beyond an edge: the cosine must exceed `least_cosine`,
  /// less so many times the noise, which turns the normals.
  double least_cosine = 0.8, cosine_per_noise = 0.35;
  double growth = 1.25;  ///< of the radius from one neighbourhood to the next
  int sizes = 6;         ///< of neighbourhoods, at most 8
  /// Intervals around the height and the slopes of a quadric, of this many standard errors to
  /// either side, must have a point in common with those of all smaller neighbourhoods ...
  double confidence = 2.0;
  /// ... and the mean squared residual may exceed what the noise leaves by so many of its own
  /// standard deviations: else there is detail that the neighbourhood is too wide for.
  double misfit = 1.0;
};

/// Moves every sample along its normal onto the quadratic height field that fits the samples around
/// it best, which unlike a plane does not shrink what is curved (Levin 2003; Cazals and Pouget
/// 2005), over the widest neighbourhood that the data allow: of those of growing size the last
/// before the fit contradicts a smaller one by more than the noise explains (Goldenshluger and
/// Nemirovski 1997, intersection of confidence intervals). The noise is measured around each
/// sample. Flat parts are smoothed over hundreds of samples, detail and edges over few.
///
/// `noise`: of `estimate_noise`. `neighbours`: per sample, from then on. Pre: `orient_normals` was
/// called on the cloud. Post: `is_denoised()`; positions, their order, neighbours, spacing, normals
/// and planes are new, the planes those of the quadrics; `input_index` tells whose they are. O(N),
/// about 30 us a sample; the same for any number of threads. Throws Cancelled.
void denoise(PointCloud& cloud, double noise, int neighbours, const DenoisingOptions& options,
             Progress& progress);

/// Moves the samples of a denoised cloud back to where the caller had them (`points`), in their
/// order of before. The normals stay those of the surface that the samples scatter about, which
/// tell one side of a thin limb from the other where those of noisy samples do not; planes there
/// are none. Neighbours and spacing are those of so many `neighbours` again. Pre:
/// `is_denoised()`. O(N). Throws Cancelled.
void undo_denoising(PointCloud& cloud, const std::vector<Vec3>& points, int neighbours,
                    Progress& progress);

}  // namespace shrinkwrap
