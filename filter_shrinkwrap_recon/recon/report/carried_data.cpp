#include "report/carried_data.h"

#include <algorithm>

#include "geometry/coordinate_matches.h"
#include "report/nearest_points.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

void carry_data(const std::vector<ResultMesh*>& meshes, const std::vector<Vec3>& points,
                const std::vector<Index>& left_out, Progress& progress) {
  std::vector<Vec3> places;  // of the vertices that are no samples
  for (const ResultMesh* mesh : meshes)
    for (std::size_t v = 0; v < mesh->position.size(); ++v)
      if (mesh->input_index[v] == kNone) places.push_back(mesh->position[v]);
  if (places.empty()) return;
  // Nor are copies of what was left out.
  std::vector<Vec3> stray = points_at(points, left_out);
  std::sort(stray.begin(), stray.end(), coordinates_less);
  std::vector<Vec3> candidates;
  std::vector<Index> candidate_index;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite() ||
        std::binary_search(stray.begin(), stray.end(), points[i], coordinates_less))
      continue;
    candidates.push_back(points[i]);
    candidate_index.push_back(static_cast<Index>(i));
  }
  const std::vector<NearestPoint> nearest = nearest_points(candidates, places, progress);
  auto next = nearest.begin();
  for (ResultMesh* mesh : meshes) {
    const std::vector<Index>& sample_of = mesh->input_index;
    if (std::find(sample_of.begin(), sample_of.end(), kNone) == sample_of.end()) continue;
    mesh->data_index = sample_of;
    for (Index& source : mesh->data_index) {
      if (source != kNone) continue;
      if (next->index != kNone) source = candidate_index[next->index];
      ++next;
    }
  }
}

}  // namespace shrinkwrap
