// Which side of each sample is outside: minimum-spanning-tree propagation, one visibility vote per component.
#pragma once

#include "point_cloud.h"

namespace shrinkwrap {

struct OrientationOptions {
  int propagation_neighbours = 10;  ///< edges per sample of the neighbour graph that carry orientation
  int view_directions = 96;         ///< orthographic depth buffers that vote
  double pixel_size = 1.5;          ///< of a depth buffer, x spacing of the samples that are drawn
  double min_cosine = 0.5;          ///< a view votes on a sample only if |normal . direction| is at least this
};

struct OrientationReport {
  Index components = 0;             ///< of the neighbour graph
  Index undecided_components = 0;   ///< whose votes nearly cancelled (nobody sees them from outside)
};

/// Gives the normals of the cloud a consistent outward sign (Hoppe et al. 1992: propagation over the spanning tree
/// that prefers parallel normals; weights |n.n'| (1 - max |d.n|)), then one sign per connected component of the
/// graph from visibility: the side that more orthographic views see is outside. Then computes the tangent planes.
/// O(N log N) time at most, O(N) memory, deterministic.
OrientationReport orient_normals(PointCloud& cloud, const OrientationOptions& options, Progress& progress);

}  // namespace shrinkwrap
