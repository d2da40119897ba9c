#include "report/result_mesh.h"

#include <algorithm>
#include <atomic>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;

}  // namespace

ResultMesh to_result(const SurfaceMesh& mesh, const Frame& frame, Progress& progress) {
  ResultMesh result;
  result.position.resize(mesh.position.size());
  result.input_index.assign(mesh.position.size(), kNone);
  parallel_for_each(mesh.vertex_slots(), kGrain, progress,
                    [&](Index v) { result.position[v] = frame.to_input(mesh.position[v]); });
  result.triangles = mesh.triangles();
  return result;
}

ResultMesh to_result(const CompleteMatching& matching, const PointCloud& cloud,
                     const std::vector<Vec3>& points, Progress& progress) {
  const SurfaceMesh& mesh = matching.mesh;

  // The caller's order: rank of each sample by its input index.
  std::vector<char> is_sample(points.size(), 0);
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    const SampleId sample = matching.sample_of_vertex[v];
    if (sample != SampleId::none) is_sample[cloud.input_index_of(sample)] = 1;
  });
  std::vector<Index> rank;  // of each point of the input
  const Index samples = parallel_number(
      static_cast<Index>(points.size()), kGrain, progress,
      [&](Index i) { return is_sample[i] != 0; }, rank);
  std::vector<Index> extra;  // rank of each vertex that is none
  parallel_number(
      mesh.vertex_slots(), kGrain, progress,
      [&](Index v) { return matching.sample_of_vertex[v] == SampleId::none; }, extra);

  ResultMesh result;
  result.position.resize(mesh.position.size());
  result.input_index.assign(mesh.position.size(), kNone);
  std::vector<Index> output(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    const SampleId sample = matching.sample_of_vertex[v];
    if (sample == SampleId::none) {
      output[v] = samples + extra[v];
      result.position[output[v]] = cloud.frame.to_input(mesh.position[v]);
    } else {
      const Index input = cloud.input_index_of(sample);
      output[v] = rank[input];
      result.input_index[output[v]] = input;
      result.position[output[v]] = points[input];
    }
  });
  result.triangles = mesh.triangles();
  parallel_for_each(static_cast<Index>(result.triangles.size()), kGrain, progress, [&](Index f) {
    for (Index& v : result.triangles[f]) v = output[v];
  });
  return result;
}

void drop_faces(ResultMesh& mesh, const std::vector<Index>& faces, Progress& progress) {
  std::size_t kept = 0, dropped = 0;
  for (std::size_t f = 0; f < mesh.triangles.size() && !faces.empty(); ++f) {
    if (dropped < faces.size() && static_cast<Index>(f) == faces[dropped]) {
      ++dropped;
      continue;
    }
    mesh.triangles[kept++] = mesh.triangles[f];
  }
  if (!faces.empty()) mesh.triangles.resize(kept);

  const Index face_count = static_cast<Index>(mesh.triangles.size());
  std::vector<std::atomic<bool>> used(mesh.position.size());
  parallel_for_each(face_count, kGrain, progress, [&](Index f) {
    for (const Index v : mesh.triangles[f]) used[v].store(true, std::memory_order_relaxed);
  });
  std::vector<Index> new_index;
  const Index slots = static_cast<Index>(mesh.position.size());
  const Index vertices = parallel_number(
      slots, kGrain, progress,
      [&](Index v) {
        return used[v].load(std::memory_order_relaxed) || mesh.input_index[v] != kNone;
      },
      new_index);
  if (vertices == slots) return;
  for (Index v = 0; v < slots; ++v) {
    if (new_index[v] == kNone) continue;
    mesh.position[new_index[v]] = mesh.position[v];
    mesh.input_index[new_index[v]] = mesh.input_index[v];
  }
  mesh.position.resize(vertices);
  mesh.input_index.resize(vertices);
  parallel_for_each(face_count, kGrain, progress, [&](Index f) {
    for (Index& v : mesh.triangles[f]) v = new_index[v];
  });
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
  if (std::any_of(mesh.position.begin(), mesh.position.end(),
                  [](const Vec3& p) { return !p.allFinite(); }))
    throw InvalidInput("the mesh has vertices whose coordinates are not finite");
  std::vector<Vec3> position(mesh.position.size());
  Progress silent;
  parallel_for_each(static_cast<Index>(position.size()), kGrain, silent,
                    [&](Index v) { position[v] = frame.to_unit(mesh.position[v]); });
  return SurfaceMesh::from_triangles(std::move(position), mesh.triangles);
}

}  // namespace shrinkwrap
