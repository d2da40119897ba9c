// Surfaces with openings where no samples are.
#pragma once

#include <vector>

#include "complete_matching/surface_openings.h"
#include "oriented_cloud.h"
#include "parametric_surface/parametric_surface.h"
#include "shapes.h"
#include "stop_at_surface/membrane_stretching.h"

namespace shrinkwrap::testing {

// A surface, and samples at those of its vertices where the scan is not open.
struct OpenScan {
  template <class IsOpen>
  OpenScan(const SurfaceMesh& mesh, const IsOpen& is_open) : surface(mesh) {
    std::vector<Vec3> samples;
    for (const Vec3& p : mesh.position)
      if (!is_open(p)) samples.push_back(p);
    cloud = oriented_cloud(samples);
    for (Vec3& p : surface.position) p = cloud.frame.to_unit(p);
    find();
  }
  // As the options say.
  SurfaceOpenings cut(CompleteMatchingOptions::Openings openings, double widest = 30.0) {
    find(openings, widest);
    return cut_surface_openings(surface, membranes, silent);
  }
  void find(CompleteMatchingOptions::Openings openings = CompleteMatchingOptions::Openings::close,
            double widest = 30.0) {
    CompleteMatchingOptions options;
    options.openings = openings;
    options.widest_opening = widest;
    membranes = find_surface_membranes(surface, mark_membranes(surface, cloud, {}, silent), cloud,
                                       options, silent);
  }
  void stretch() { stretch_membranes(surface, membranes, silent); }
  Index openings() const { return static_cast<Index>(membranes.size()); }
  Vec3 at(Index v) const { return cloud.frame.to_input(surface.position[v]); }

  Progress silent;
  SurfaceMesh surface;
  PointCloud cloud;
  std::vector<SurfaceMembrane> membranes;
};

// The unit sphere without samples above a height.
inline OpenScan open_sphere(double z = 0.5) {
  return OpenScan(icosphere(4), [z](const Vec3& p) { return p.z() > z; });
}

}  // namespace shrinkwrap::testing
