#include "report/carried_data.h"

#include <limits>

#include "report/nearest_points.h"

namespace shrinkwrap {

void carry_data(ResultMesh& mesh, const std::vector<Vec3>& points,
                const std::vector<Index>& left_out, Progress& progress) {
  std::vector<Vec3> places;  // of the vertices that are no samples
  for (std::size_t v = 0; v < mesh.position.size(); ++v)
    if (mesh.input_index[v] == kNone) places.push_back(mesh.position[v]);
  if (places.empty()) return;
  std::vector<Vec3> candidates = points;
  for (const Index i : left_out)
    candidates[i] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<NearestPoint> nearest = nearest_points(candidates, places, progress);
  mesh.data_index = mesh.input_index;
  auto next = nearest.begin();
  for (Index& source : mesh.data_index)
    if (source == kNone) source = (next++)->index;
}

}  // namespace shrinkwrap
