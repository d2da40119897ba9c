#include "stage_qualities.h"

#include <algorithm>
#include <cmath>

#include "face_tree.h"
#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;

}  // namespace

std::vector<float> distances_from_surface(const ResultMesh& mesh, const SurfaceMesh& surface,
                                          const Frame& frame, Progress& progress) {
  const FaceTree tree(surface, progress);
  const auto any = [](Index) { return true; };
  std::vector<float> distance(mesh.position.size(), 0.0f);
  parallel_for_each(static_cast<Index>(distance.size()), kGrain, progress, [&](Index v) {
    const FaceTree::Hit hit = tree.nearest(frame.to_unit(mesh.position[v]),
                                           std::numeric_limits<double>::infinity(), kNone, any);
    distance[v] = static_cast<float>(frame.to_input_length(std::sqrt(hit.squared_distance)));
  });
  return distance;
}

std::vector<float> spanning_lengths(const ResultMesh& mesh, const std::vector<Index>& spanning,
                                    double spacing) {
  if (spanning.empty()) return {};
  std::vector<float> length(mesh.triangles.size(), 0.0f);
  for (const Index f : spanning) {
    const Triangle& t = mesh.triangles[f];
    double longest = 0.0;
    for (int corner = 0; corner < 3; ++corner)
      longest =
          std::max(longest, (mesh.position[t[corner]] - mesh.position[t[(corner + 1) % 3]]).norm());
    length[f] = static_cast<float>(longest / spacing);
  }
  return length;
}

}  // namespace shrinkwrap
