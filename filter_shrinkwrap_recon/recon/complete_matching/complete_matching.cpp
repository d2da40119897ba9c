#include "complete_matching/complete_matching.h"

#include <string>

#include "complete_matching/retile.h"
#include "complete_matching/snap_and_insert.h"
#include "mesh/bodies.h"

namespace shrinkwrap {
namespace {

// The postconditions, whatever method was used.
void check_matching(const CompleteMatching& matching, Index samples) {
  const SurfaceMesh& mesh = matching.mesh;
  std::vector<char> is_matched(static_cast<std::size_t>(samples), 0);
  Index matched = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const SampleId sample = matching.sample_of_vertex[v];
    if (mesh.is_removed_vertex(v) || sample == SampleId::none) continue;
    if (is_matched[to_index(sample)])
      throw ReconstructionFailed("sample " + std::to_string(to_index(sample)) +
                                 " became two vertices of the mesh: nothing was made.");
    is_matched[to_index(sample)] = 1;
    ++matched;
  }
  if (matched < samples)
    throw ReconstructionFailed(std::to_string(samples - matched) +
                               " samples did not become vertices of the mesh: nothing was made.");
}

}  // namespace

CompleteMatching match_samples(SurfaceMesh parametric, const PointCloud& cloud,
                               const CompleteMatchingOptions& options, Progress& progress) {
  progress.begin(Stage::complete_matching);
  if (parametric.face_count() == 0)
    throw InvalidInput("the parametric surface has no faces: make it again");
  CompleteMatching matching =
      options.method == CompleteMatchingOptions::Method::retile
          ? retile(std::move(parametric), cloud, options, progress)
          : snap_and_insert(std::move(parametric), cloud, options, progress);
  check_matching(matching, cloud.size());
  const bool may_be_open = options.openings != CompleteMatchingOptions::Openings::close;
  turn_outward(matching.mesh, may_be_open ? matching.spanning_faces : std::vector<Index>(),
               progress);
  progress.update(1.0);
  return matching;
}

}  // namespace shrinkwrap
