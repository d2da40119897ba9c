// Faces that a change of a mesh would bring: do they cut any other one?
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "box_tree.h"
#include "surface_mesh.h"
#include "triangle_pair.h"

namespace shrinkwrap {

/// Whether fresh faces cut the mesh: one is degenerate, meets a face of the mesh other than those
/// for which `is_gone(face)`, or meets another fresh one (not tested if `are_apart`).
///
/// Bounded in tests of two triangles, so that the bound is the same on every machine: `spend(n)` is
/// called for each n of them, a search of the tree being eight, or one for four of its groups where
/// there are more. Where it returns false between searches the answer is true, for safety.
template <class IsGone, class Spend>
bool fresh_faces_cut(const SurfaceMesh& mesh, const BoxTree& boxes, const TrianglePairs& pairs,
                     const std::vector<Triangle>& fresh, bool are_apart, const IsGone& is_gone,
                     const Spend& spend) {
  constexpr std::int64_t kTestsOfSearch = 8, kGroupsPerTest = 4;
  const auto is_degenerate = [&](const Triangle& t) {
    const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
    return !((b - a).cross(c - a).squaredNorm() > 0.0);
  };
  for (const Triangle& t : fresh)
    if (is_degenerate(t)) return true;
  for (const Triangle& t : fresh) {
    if (!spend(kTestsOfSearch)) return true;
    const auto cuts = [&](Index f) {
      if (is_gone(f)) return false;
      spend(1);
      return pairs.meet(t, mesh.triangle(f));
    };
    std::int64_t groups = 0;
    const bool is_cut = boxes.any_near(mesh.position, t, cuts, &groups);
    spend(std::max(groups / kGroupsPerTest - kTestsOfSearch, std::int64_t{0}));
    if (is_cut) return true;
  }
  if (are_apart) return false;
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    if (!spend(static_cast<std::int64_t>(i))) return true;
    for (std::size_t j = 0; j < i; ++j)
      if (pairs.meet(fresh[i], fresh[j])) return true;
  }
  return false;
}

}  // namespace shrinkwrap
