// Strays among the samples that the surface through the rest of them shows.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"
#include "samples/outliers.h"

namespace shrinkwrap {

/// Leaves samples out of a cloud that stand alone off the parametric surface: farther from it than
/// `OutlierOptions::off_surface` allows, while nearly all samples around are on it. A smooth
/// surface follows many samples and no single one, so that it tells strays beside edges and between
/// close parts, where planes tell nothing. What it fails to show, such as a thin post, has more
/// samples than one, and no fewer for its size than what is around; and the corner of a sheet,
/// which it rounds off, lies in the planes of the others. Spacings around are no less than the
/// median: in parts that are denser, strays are not looked for. Those that are left out are
/// reported with the others, and so are near copies of them. Returns how many there are, copies not
/// counted; none of a cloud of fewer than 64, none if all that seemed stray would be more than
/// `OutlierOptions::most`, and none if the rest would lie in a plane. `noise`: of the samples, x
/// local spacing, but for `PointCloud::more_noise`. Pre: `orient_normals` was called on the cloud,
/// which is not denoised; `surface` is in its frame. Post: the cloud has the rest of the samples
/// along a Morton curve, with neighbours, spacing, normals and planes, in the same frame. O(N)
/// searches for the nearest face, parallel; the same for any number of threads. Throws Cancelled,
/// and cloud and report are then as they were.
Index leave_out_samples_off_surface(PointCloud& cloud, OutlierReport& report,
                                    const SurfaceMesh& surface, double noise,
                                    const OutlierOptions& options, Progress& progress);

/// Leaves samples out of a cloud that a mesh was made without, for one that is judged by itself:
/// those that no vertex lies at, with vertices around most of whose planes they are not in, and no
/// face as near as it would be to what lies on the mesh (`OutlierOptions::foot`). Others that are
/// missing stay, such as those that a hole in a face lacks, or many beside each other. The mesh is
/// in the frame of `points`, and may have any faces. Pre: the cloud is not denoised; its normals
/// may face any side. Post, limits and Throws: as above. O(N + V), and O(V log V) and 50 tests for
/// each face if any is missing.
Index leave_out_samples_off_mesh(PointCloud& cloud, OutlierReport& report,
                                 const std::vector<Vec3>& points, const std::vector<Vec3>& vertices,
                                 const std::vector<Triangle>& triangles,
                                 const OutlierOptions& options, Progress& progress);

}  // namespace shrinkwrap
