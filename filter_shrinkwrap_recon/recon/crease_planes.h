// Normals beside edges, and of faces so narrow that neighbourhoods are of several.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

/// Lengths x local spacing.
struct CreasePlaneOptions {
  double least_deviation = 0.25;  ///< of the neighbours from one plane: less is one face
  int neighbours = 32;            ///< around a sample, itself included, at most 64
  double thickness = 0.05;        ///< of a face
  double least_members = 0.25;    ///< part of the neighbours that must lie on the plane
};

/// The plane that fits the neighbours of a sample beside an edge best is that of no face; where
/// edges are as near to each other as samples, at the ends of thin walls and in narrow slots, it is
/// any plane. So where neighbours deviate from their plane, that of one face is sought
/// (plane_support.h) among those that look to the same side. It replaces the plane of the sample,
/// and its side, if enough neighbours lie on it, and too few on the one that there was. On what is
/// curved, or noisier than a face is thick, too few lie on any.
///
/// Pre: the normals are oriented, most of them right. Returns how many normals were replaced; the
/// tangent planes are not. O(N) expected; the same for any number of threads.
Index fit_crease_planes(PointCloud& cloud, const CreasePlaneOptions& options, Progress& progress);

}  // namespace shrinkwrap
