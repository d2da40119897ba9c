#include "intersection_relaxation.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "box_tree.h"
#include "one_ring.h"
#include "parallel.h"
#include "self_intersection.h"
#include "triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8;

void sort_unique(std::vector<Index>& indices) {
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

std::vector<Index> vertices_of(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  std::vector<Index> vertices;
  for (const Index f : faces)
    for (const Index v : mesh.triangle(f)) vertices.push_back(v);
  sort_unique(vertices);
  return vertices;
}

std::vector<Index> faces_around(const SurfaceMesh& mesh, const std::vector<Index>& vertices) {
  std::vector<Index> faces;
  for (const Index v : vertices)
    mesh.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
  sort_unique(faces);
  return faces;
}

// The faces that meet one of those given, and these of which that is true; ascending. Near-linear
// in heaps too: a pair of which both are known is not tested. Which faces are found does not depend
// on who comes first.
std::vector<Index> faces_that_meet(const SurfaceMesh& mesh, const BoxTree& tree,
                                   const TrianglePairs& test, const std::vector<Index>& faces,
                                   Progress& progress) {
  const auto is_found =
      std::make_unique<std::atomic<bool>[]>(static_cast<std::size_t>(mesh.face_slots()));
  std::vector<Index> found = parallel_collect<Index>(
      static_cast<Index>(faces.size()), kGrain, progress,
      [&](Index begin, Index end, std::vector<Index>& some) {
        const auto add = [&](Index f) {
          if (!is_found[f].exchange(true, std::memory_order_relaxed)) some.push_back(f);
        };
        for (Index i = begin; i < end; ++i) {
          const Index f = faces[i];
          const Triangle t = mesh.triangle(f);
          tree.for_each_overlap(tree.box_of(mesh.position, t), [&](Index g) {
            if (g == f || (is_found[f].load(std::memory_order_relaxed) &&
                           is_found[g].load(std::memory_order_relaxed)))
              return;
            if (!test.meet(t, mesh.triangle(g))) return;
            add(f);
            add(g);
          });
        }
      });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

RelaxationReport relax_self_intersections(SurfaceMesh& mesh, const RelaxationOptions& options,
                                          Progress& progress) {
  RelaxationReport report;
  const std::vector<Triangle> triangles = mesh.triangles();
  BoxTree tree(mesh.position, triangles, progress);
  const TrianglePairs test(mesh.position);
  const std::vector<Index> at_first = self_intersecting_faces(tree, test, triangles, progress);
  report.faces_before = static_cast<Index>(at_first.size());

  std::vector<Index> meeting = at_first;
  std::vector<std::pair<Index, Vec3>> original;  // of the vertices that moved, several of one
  std::vector<Vec3> moved;
  for (; report.rounds < options.max_rounds && !meeting.empty(); ++report.rounds) {
    progress.update(static_cast<double>(report.rounds) / options.max_rounds);
    std::vector<Index> region = vertices_of(mesh, meeting);
    for (int ring = report.rounds / options.rounds_a_ring; ring > 0; --ring)
      region = vertices_of(mesh, faces_around(mesh, region));
    for (const Index v : region) original.emplace_back(v, mesh.position[v]);
    const Index count = static_cast<Index>(region.size());
    moved.resize(region.size());
    for (int step = 0; step < options.steps; ++step) {
      parallel_for_each(count, kGrain, progress, [&](Index i) {
        moved[i] = mesh.position[region[i]] +
                   options.weight * gather_one_ring(mesh, region[i]).laplacian();
      });
      for (Index i = 0; i < count; ++i) mesh.position[region[i]] = moved[i];
    }
    std::vector<Index> changed = faces_around(mesh, region);
    for (const Index f : changed) tree.set_box(f, tree.box_of(mesh.position, mesh.triangle(f)));
    meeting = faces_that_meet(mesh, tree, test, changed, progress);
  }
  std::stable_sort(original.begin(), original.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto end = std::unique(original.begin(), original.end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; });
  original.erase(end, original.end());
  if (meeting.size() < at_first.size()) {
    report.moved = static_cast<Index>(original.size());
  } else {
    for (const auto& [v, position] : original) mesh.position[v] = position;
    meeting = at_first;
  }
  report.faces_after = static_cast<Index>(meeting.size());
  report.remaining_faces = std::move(meeting);
  return report;
}

}  // namespace shrinkwrap
