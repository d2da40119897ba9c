// Normals of thin parts, and where samples are farther apart one way than the other.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct PoleNormalOptions {
  double least_deviation = 0.25;  ///< of the neighbours from one plane, x local spacing ...
  double least_over_noise = 4.0;  ///< ... and x the noise: less is one plane ...
  double thin_part = 0.25;   ///< ... unless so many of all samples have another pole: thin parts
                             ///< look noisy, but to noise poles come by chance only
  int neighbours = 24;       ///< around a sample, itself included, at most 64
  double most_cosine = 0.7;  ///< between pole and normal: more, and the normal stays
  double least_ratio = 2.0;  ///< of the empty balls towards the pole and along the normal ...
  double least_ratio_to_face = 4.0;  ///< ... and along one that is of a face: on whose plane
  double least_members = 0.25;       ///< this part of the neighbours lies,
  double thickness = 0.15;           ///< if planes are so thick, x local spacing
  double most_diameter = 20.0;       ///< x local spacing: larger balls count as no larger
};

/// Neighbours of a sample that are all around a limb, or on several rings of it, fit a plane across
/// it as well as any along its skin. Of a surface without noise the largest ball that touches it at
/// a sample, and holds no other, does better: its centre, the pole of the sample (Amenta and Bern
/// 1999), lies along the normal, however thin the part is and however uneven the sampling. Where
/// neighbours deviate from their plane, the largest ball is sought that is empty of them. The way
/// to its centre becomes the normal if it is far from the one that there was and the balls along
/// that are much smaller, the more so if it is that of a face. So normals at edges stay, which are
/// of either face or lie between them, and those of sheets on top of each other
/// (parallel_sheets.h), where the largest ball may well lie askew.
///
/// Pre: samples do not lie on lines (ConditioningReport::on_lines), of which balls touch one alone.
/// `noise`: of the cloud, x local spacing (scatter_of_samples); that of a cloud of thin parts alone
/// is great, as it is told along the normals that there were. Signs of new normals are arbitrary.
/// Returns how many were replaced; the deviations stay those from one plane. O(N) expected; the
/// same for any number of threads.
Index fit_pole_normals(PointCloud& cloud, double noise, const PoleNormalOptions& options,
                       Progress& progress);

}  // namespace shrinkwrap
