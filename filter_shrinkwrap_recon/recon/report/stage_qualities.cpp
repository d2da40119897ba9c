#include "report/stage_qualities.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/parallel.h"
#include "geometry/triangle_geometry.h"
#include "mesh/face_tree.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kRelativeError = 1e-3;

double longest_edge(const ResultMesh& mesh, const Triangle& t) {
  return shrinkwrap::longest_edge(mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]]);
}

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
  for (const Index f : spanning)
    length[f] = static_cast<float>(longest_edge(mesh, mesh.triangles[f]) / spacing);
  return length;
}

std::vector<Index> spanning_faces(const ResultMesh& mesh, double spacing) {
  std::vector<Index> spanning;
  for (std::size_t f = 0; f < mesh.face_quality.size(); ++f) {
    const double quality = mesh.face_quality[f];
    if (!(quality > 0.0 && std::isfinite(quality))) continue;
    const Triangle& t = mesh.triangles[f];
    // Vertices that are no samples were rounded to the coordinates of a layer.
    double coordinate = 0.0;
    for (const Index v : t)
      coordinate = std::max(coordinate, mesh.position[v].cwiseAbs().maxCoeff());
    const double tolerance = kRelativeError * quality +
                             4.0 * std::numeric_limits<float>::epsilon() * (coordinate / spacing);
    if (std::abs(longest_edge(mesh, t) / spacing - quality) <= tolerance)
      spanning.push_back(static_cast<Index>(f));
  }
  return spanning;
}

}  // namespace shrinkwrap
