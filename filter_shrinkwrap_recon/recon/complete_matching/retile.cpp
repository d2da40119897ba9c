#include "complete_matching/retile.h"

#include <algorithm>

#include "common/parallel.h"
#include "complete_matching/close_openings.h"
#include "complete_matching/insert_feet.h"
#include "complete_matching/membranes.h"
#include "complete_matching/openings.h"
#include "complete_matching/vertex_removal.h"
#include "mesh/delaunay_flips.h"
#include "parametric_surface/sample_feet.h"

namespace shrinkwrap {
namespace {

using Openings = CompleteMatchingOptions::Openings;

constexpr Index kGrain = 1 << 14;

// Removes the vertices of the surface, [0, surface_vertices), that are no membrane.
VertexRemovalReport remove_surface_vertices(SurfaceMesh& mesh, Index surface_vertices,
                                            const Membranes& membranes, Progress& progress) {
  const VertexBlocks blocks(mesh.position, progress);
  progress.set_range(0.55, 0.65);
  make_delaunay(mesh, blocks, progress);
  progress.set_range(0.65, 0.9);
  std::vector<char> is_marked(static_cast<std::size_t>(surface_vertices), 1);
  for (std::size_t v = 0; v < membranes.is_membrane.size(); ++v)
    if (membranes.is_membrane[v]) is_marked[v] = 0;
  return remove_vertices(mesh, blocks, is_marked, progress);
}

// Samples, which are the last vertex slots, first; then what is left of the others.
void number_by_samples(SurfaceMesh& mesh, Index samples, Progress& progress) {
  const Index first_sample = mesh.vertex_slots() - samples;
  std::vector<Index> new_index(mesh.position.size(), kNone);
  Index extra = samples;
  for (Index v = 0; v < first_sample; ++v)
    if (!mesh.is_removed_vertex(v)) new_index[v] = extra++;
  for (Index i = 0; i < samples; ++i) new_index[first_sample + i] = i;
  mesh.renumber(new_index, progress);
}

// Components that hold no sample are debris of the start: no sample is lost with them.
void drop_components_without_samples(SurfaceMesh& mesh, Index samples, Progress& progress) {
  const MeshComponents components = connected_components(mesh, progress);
  std::vector<char> has_sample(static_cast<std::size_t>(components.count), 0);
  for (Index v = 0; v < samples; ++v) has_sample[components.of_vertex[v]] = 1;
  if (std::count(has_sample.begin(), has_sample.end(), 0) > 0)
    mesh = kept_components(mesh, components, has_sample, progress);
}

}  // namespace

CompleteMatching retile(SurfaceMesh parametric, const PointCloud& cloud,
                        const CompleteMatchingOptions& options, Progress& progress) {
  if (parametric.vertex_count() < parametric.vertex_slots()) parametric.compact(progress);
  const Index samples = cloud.size(), surface_vertices = parametric.vertex_slots();
  const Index euler_characteristic = parametric.euler_characteristic();
  CompleteMatching result;

  progress.set_range(0.0, 0.4);
  SampleFeet feet = find_sample_feet(parametric, cloud, progress);
  result.report.mean_foot_distance = feet.mean_distance;
  result.report.max_foot_distance = feet.max_distance;
  progress.set_range(0.4, 0.45);
  const Membranes membranes = find_membranes(parametric, feet, cloud, options, progress);
  result.report.membranes = membranes.count;
  result.report.backs = membranes.backs;

  progress.set_range(0.45, 0.55);
  SurfaceMesh& mesh = result.mesh;
  mesh = insert_feet(std::move(parametric), feet, progress);
  feet = SampleFeet();
  const VertexRemovalReport removal =
      remove_surface_vertices(mesh, surface_vertices, membranes, progress);
  result.report.forced_removals = removal.forced;
  if (mesh.euler_characteristic() != euler_characteristic)
    throw ReconstructionFailed("re-tiling changed the topology of the surface: nothing was made.");

  progress.set_range(0.9, 0.95);
  number_by_samples(mesh, samples, progress);
  parallel_for_each(samples, kGrain, progress,
                    [&](Index i) { mesh.position[i] = cloud.position[i]; });

  progress.set_range(0.95, 1.0);
  if (mesh.vertex_count() > samples) drop_components_without_samples(mesh, samples, progress);
  if (mesh.vertex_count() > samples && membranes.count > 0) {
    if (options.openings == Openings::leave_open) {
      leave_openings(result, cloud, progress);
    } else {
      close_openings(result, samples, progress);
    }
  }
  result.sample_of_vertex.assign(mesh.position.size(), SampleId::none);
  for (Index i = 0; i < samples; ++i) result.sample_of_vertex[i] = to_sample(i);
  result.report.extra_vertices = extra_vertices_kept(mesh, samples, result.opening_faces);
  return result;
}

}  // namespace shrinkwrap
