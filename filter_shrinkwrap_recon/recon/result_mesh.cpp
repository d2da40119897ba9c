#include "result_mesh.h"

#include <algorithm>
#include <numeric>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;

}  // namespace

ResultMesh to_result(const SurfaceMesh& mesh, const Frame& frame) {
  ResultMesh result;
  result.position.resize(mesh.position.size());
  result.input_index.assign(mesh.position.size(), kNone);
  Progress silent;
  parallel_for_each(mesh.vertex_slots(), kGrain, silent,
                    [&](Index v) { result.position[v] = frame.to_input(mesh.position[v]); });
  result.triangles = mesh.triangles();
  return result;
}

ResultMesh to_result(const CompleteMatching& matching, const PointCloud& cloud,
                     const std::vector<Vec3>& points) {
  const SurfaceMesh& mesh = matching.mesh;
  const Index samples = cloud.size();

  // The caller's order: rank of each sample by its input index.
  std::vector<Index> sample_at(points.size(), kNone);
  for (Index sample = 0; sample < samples; ++sample) sample_at[cloud.input_index[sample]] = sample;
  std::vector<Index> rank(samples);
  Index next_rank = 0;
  for (const Index sample : sample_at)
    if (sample != kNone) rank[sample] = next_rank++;

  ResultMesh result;
  result.position.resize(mesh.position.size());
  result.input_index.assign(mesh.position.size(), kNone);
  std::vector<Index> output(mesh.position.size());
  Index next_extra = samples;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const SampleId sample = matching.sample_of_vertex[v];
    if (sample == SampleId::none) {
      output[v] = next_extra++;
      result.position[output[v]] = cloud.frame.to_input(mesh.position[v]);
    } else {
      output[v] = rank[to_index(sample)];
      result.input_index[output[v]] = cloud.input_index[to_index(sample)];
      result.position[output[v]] = points[cloud.input_index[to_index(sample)]];
    }
  }
  result.triangles = mesh.triangles();
  for (Triangle& triangle : result.triangles)
    for (Index& v : triangle) v = output[v];
  return result;
}

void drop_faces(ResultMesh& mesh, const std::vector<Index>& faces) {
  std::size_t kept = 0, dropped = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (dropped < faces.size() && static_cast<Index>(f) == faces[dropped]) {
      ++dropped;
      continue;
    }
    mesh.triangles[kept++] = mesh.triangles[f];
  }
  mesh.triangles.resize(kept);

  std::vector<char> used(mesh.position.size(), 0);
  for (const Triangle& triangle : mesh.triangles)
    for (const Index v : triangle) used[v] = 1;
  std::vector<Index> new_index(mesh.position.size(), kNone);
  Index vertices = 0;
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    if (!used[v] && mesh.input_index[v] == kNone) continue;
    new_index[v] = vertices;
    mesh.position[vertices] = mesh.position[v];
    mesh.input_index[vertices] = mesh.input_index[v];
    ++vertices;
  }
  mesh.position.resize(vertices);
  mesh.input_index.resize(vertices);
  for (Triangle& triangle : mesh.triangles)
    for (Index& v : triangle) v = new_index[v];
}

std::vector<Index> indices_after_drop(const std::vector<Index>& faces,
                                      const std::vector<Index>& dropped) {
  std::vector<Index> left;
  auto next = dropped.begin();
  for (const Index f : faces) {
    while (next != dropped.end() && *next < f) ++next;
    if (next == dropped.end() || *next != f)
      left.push_back(f - static_cast<Index>(next - dropped.begin()));
  }
  return left;
}

SurfaceMesh to_surface(const ResultMesh& mesh, const Frame& frame) {
  std::vector<Vec3> position(mesh.position.size());
  for (std::size_t v = 0; v < position.size(); ++v) position[v] = frame.to_unit(mesh.position[v]);
  return SurfaceMesh::from_triangles(std::move(position), mesh.triangles);
}

}  // namespace shrinkwrap
