// Normals beside edges, and of faces so narrow that neighbourhoods are of several.
#pragma once

#include "samples/point_cloud.h"

namespace shrinkwrap {

/// Lengths x local spacing.
struct CreasePlaneOptions {
  double least_deviation = 0.25;  ///< of the neighbours from one plane: less is one face
  int neighbours = 32;            ///< around a sample, itself included, at most 64
  double thickness = 0.05;        ///< of a face
  double least_members = 0.25;    ///< of so many neighbours, the part that must lie on the plane
  double least_agreement = 0.3;   ///< mean cosine of their normals with its own
};

/// The plane that fits the neighbours of a sample beside an edge best is that of no face; where
/// edges are as near to each other as samples, at the ends of thin walls and in narrow slots, it is
/// any plane. So where neighbours deviate from their plane, that of one face is sought
/// (plane_support.h) among those that look to the same side. It replaces the plane of the sample,
/// and its side, if enough neighbours lie on it, too few on the one that there was, and their
/// normals agree with it on the whole: they do not with the plane of a slice, which holds all
/// samples of one scan line. What is curved deviates less, or, if it is a thin rod, few lie on any
/// plane.
///
/// Pre: the normals are oriented, most of them right; samples neither noisy, as they lie on planes
/// by chance then, nor on lines (OrientationOptions::most_noise_at_creases,
/// ConditioningReport::on_lines). Returns how many normals were replaced; the tangent planes are
/// not, and deviations stay those from one plane. O(N) expected; the same for any number of
/// threads.
Index fit_crease_planes(PointCloud& cloud, const CreasePlaneOptions& options, Progress& progress);

}  // namespace shrinkwrap
