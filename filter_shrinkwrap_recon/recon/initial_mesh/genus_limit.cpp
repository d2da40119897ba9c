#include "initial_mesh/genus_limit.h"

#include <algorithm>

#include "mesh/surface_loops.h"

namespace shrinkwrap {
namespace {

constexpr int kMostSearches = 12;    // for one loop, each from a place on the loop before
constexpr std::size_t kLongest = 2;  // of the loops of a round, x the shortest

// Searches from where a loop passes, for one of at most `longest` edges. Empty if there is none.
Loop shortened_nearby(const SurfaceMesh& mesh, PathTree& tree, Loop loop, std::size_t longest,
                      Progress& progress) {
  // Where the loop closes, and from then on opposite to where the search began.
  Index centre = loop.front();
  for (int search = 0; search < kMostSearches; ++search) {
    const Index radius = static_cast<Index>(std::min(loop.size(), longest) / 2);
    Loop shorter = loop_in_ball(mesh, tree, centre, radius, progress);
    if (shorter.empty() || shorter.size() >= loop.size()) break;
    loop = std::move(shorter);
    centre = loop[loop.size() / 2];
  }
  return loop.size() <= longest ? loop : Loop();
}

// The same by searches of the whole mesh: what comes out separates nothing.
Loop shortened(const SurfaceMesh& mesh, Loop loop, int& searches, Progress& progress) {
  for (int search = 1; search < kMostSearches; ++search) {
    ++searches;
    std::vector<Loop> through = loops_from(mesh, {loop[loop.size() / 2]}, progress);
    if (through.front().size() >= loop.size()) break;
    loop = std::move(through.front());
  }
  return loop;
}

// Up to `most` loops to be cut at once; none if there is no handle.
std::vector<Loop> loops_of_round(const SurfaceMesh& mesh, Index most, int& searches,
                                 Progress& progress) {
  const MeshComponents components = connected_components(mesh, progress);
  std::vector<Index> roots(static_cast<std::size_t>(components.count), kNone);
  for (Index v = mesh.vertex_slots(); v-- > 0;) roots[components.of_vertex[v]] = v;
  ++searches;
  std::vector<Loop> found = loops_from(mesh, roots, progress);
  if (found.empty()) return {};

  const std::size_t longest = kLongest * found.front().size();
  PathTree tree(mesh);
  DisjointLoops as_found(mesh, most), shorter(mesh, most);
  for (const Loop& loop : found) {
    if (loop.size() <= longest) as_found.add(loop);
    if (most > 1) shorter.add(shortened_nearby(mesh, tree, loop, longest, progress));
  }
  sort_by_length(shorter.loops);
  // Loops found nearby may separate the surface; those found from afar do not.
  keep_inseparable(mesh, shorter.loops, progress);
  std::vector<Loop>& chosen =
      2 * shorter.loops.size() > as_found.loops.size() ? shorter.loops : as_found.loops;
  if (chosen.size() > 1) return std::move(chosen);
  return {shortened(mesh, std::move(found.front()), searches, progress)};
}

}  // namespace

Index genus_of(const SurfaceMesh& mesh, Progress& progress) {
  return connected_components(mesh, progress).count - mesh.euler_characteristic() / 2;
}

GenusLimitReport limit_genus(SurfaceMesh& mesh, Index maximum, Progress& progress) {
  GenusLimitReport report;
  for (Index genus = genus_of(mesh, progress); genus > maximum; genus = genus_of(mesh, progress)) {
    const std::vector<Loop> loops =
        loops_of_round(mesh, genus - maximum, report.searches, progress);
    if (loops.empty()) break;
    cut_along(mesh, loops, progress);
    report.cut += static_cast<Index>(loops.size());
    ++report.rounds;
  }
  if (report.cut > 0) mesh.compact(progress);
  return report;
}

}  // namespace shrinkwrap
