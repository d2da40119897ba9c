#include "mesh/removed_vertices.h"

#include <algorithm>
#include <utility>

#include "common/sort_unique.h"
#include "geometry/voxel_search.h"

namespace shrinkwrap {

std::vector<Triangle> without_vertices(std::vector<Triangle> faces,
                                       const std::vector<Index>& removed) {
  const auto has_gone = [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](Index v) {
      return std::binary_search(removed.begin(), removed.end(), v);
    });
  };
  faces.erase(std::remove_if(faces.begin(), faces.end(), has_gone), faces.end());
  for (Triangle& t : faces)
    for (Index& v : t)
      v -=
          static_cast<Index>(std::lower_bound(removed.begin(), removed.end(), v) - removed.begin());
  return faces;
}

std::vector<Index> removed_nearest_to(const SurfaceMesh& before,
                                      const std::vector<Index>& faces_before,
                                      const std::vector<Index>& removed, const SurfaceMesh& after,
                                      const std::vector<Index>& faces_after, Progress& progress) {
  std::vector<Triangle> known;
  for (const Index f : faces_before) known.push_back(ascending_corners(before, f));
  known = without_vertices(std::move(known), removed);
  std::sort(known.begin(), known.end());
  std::vector<Vec3> position;
  for (const Index v : removed) position.push_back(before.position[v]);
  const VoxelSearch search(std::move(position), progress);
  std::vector<Index> nearest;
  for (const Index f : faces_after) {
    const Triangle t = ascending_corners(after, f);
    if (std::binary_search(known.begin(), known.end(), t)) continue;
    const std::vector<Vec3>& p = after.position;
    nearest.push_back(removed[search.nearest((p[t[0]] + p[t[1]] + p[t[2]]) / 3.0).index]);
  }
  sort_unique(nearest);
  return nearest;
}

}  // namespace shrinkwrap
