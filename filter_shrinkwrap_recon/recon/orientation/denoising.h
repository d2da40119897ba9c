// Noisy samples moved onto the surface that they scatter about.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct DenoisingOptions {
  /// Clouds with less noise are left as they are (x local spacing). 0: none; a surface fitted to
  /// the planes of quadrics is nearer to clean samples too.
  double from = 0.0;
  /// The initial mesh of cleaner clouds is made of their samples where they are, whose planes tell
  /// the sides of thin blades better, and they are moved after that.
  double before_initial_mesh_from = 0.04;
  /// They are moved before where more than this part of the samples have more noise than the
  /// others: that gives the initial mesh handles.
  double before_initial_mesh_part = 0.1;
  /// Radius of the smallest neighbourhood, x local spacing: `first_radius`, and so many times the
  /// noise. 13 samples at a noise of 0.1, 45 at 0.7.
  double first_radius = 1.7, radius_per_noise = 3.0;
  /// Samples whose normals differ more lie beyond an edge: the cosine must exceed `least_cosine`,
  /// less so many times the noise, which turns the normals.
  double least_cosine = 0.88, cosine_per_noise = 0.35;
  double growth = 1.25;  ///< of the radius from one neighbourhood to the next
  int sizes = 7;         ///< of neighbourhoods, at most 8
  /// Neighbourhoods end where the mean squared residual exceeds what the noise leaves by so many of
  /// its own standard deviations: there is detail that no wider one can tell of.
  double misfit = 3.0;
  /// What the noise around a sample differs from the typical noise of the cloud, up to this factor,
  /// is taken for detail or chance.
  double alike = 1.4;
  /// Noise along the surface, x that across it: 1 where it is alike in all directions. 0: none, as
  /// where samples were moved along their normals.
  double tangential_noise = 1.0;
  double most_blur = 0.5;  ///< that is made up for, x that noise
};

struct DenoisingReport {
  Index moved = 0;                 ///< samples
  double mean_displacement = 0.0;  ///< over all samples, x spacing before
  double max_displacement = 0.0;   ///< x spacing before
};

/// Moves every sample along its normal onto the surface that quadratic height fields over the
/// samples around it suggest, which unlike planes do not shrink what is curved (Levin 2003; Cazals
/// and Pouget 2005). Neighbourhoods of growing size are nested, so that the steps between their
/// quadrics are uncorrelated, and the noise tells how large they would be without any detail
/// (Hausman 1978). The widest quadric is taken, and of every step towards smaller ones that part
/// which exceeds noise in the mean over the samples around: the empirical Wiener filter of image
/// denoising (Mihcak, Kozintsev, Ramchandran and Moulin 1999). The last step is that to the sample
/// itself: where there is little noise it stays, whatever the quadrics make of an edge. Height and
/// slopes are filtered each on its own. The noise is measured around each sample. Flat parts are
/// smoothed over hundreds of samples, detail and edges over few. What is curved lies farther out
/// than quadrics pass, by the square of the noise along the surface (of what is typical, or of that
/// around it if that is less) times its mean curvature: that noise blurs it, as heat spreads, and a
/// height field is an average over it. Where there is more noise (`more_noise`, if that was
/// measured), neighbourhoods are as large as in one that has so much.
///
/// `noise`: `NoiseEstimate::of_others`. `neighbours`: per sample, from then on. Pre:
/// `orient_normals` was called on the cloud. Post: `is_denoised()`; positions, their order,
/// neighbours, spacing, normals and planes are new, the planes those of the surface; `input_index`
/// tells whose they are. O(N), about 40 us and 220 bytes a sample; the same for any number of
/// threads. Throws Cancelled, and the cloud is then as it was.
DenoisingReport denoise(PointCloud& cloud, double noise, int neighbours,
                        const DenoisingOptions& options, Progress& progress);

/// Moves the samples of a denoised cloud back to where the caller had them (`points`), in their
/// order of before. The normals stay those of the surface that the samples scatter about, which
/// tell one side of a thin limb from the other where those of noisy samples do not. Neighbours and
/// spacing are those of so many `neighbours` again, tangent planes means over so many
/// `plane_neighbours`. Pre: `is_denoised()`. O(N). Throws Cancelled; the cloud is of no use then.
void undo_denoising(PointCloud& cloud, const std::vector<Vec3>& points, int neighbours,
                    int plane_neighbours, Progress& progress);

}  // namespace shrinkwrap
