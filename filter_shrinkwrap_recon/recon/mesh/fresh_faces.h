// Faces that a change of a mesh would bring: do they cut any other one?
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mesh/box_tree.h"
#include "mesh/surface_mesh.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {

/// The pairs that fresh faces form with faces of the mesh that they meet, other than those for
/// which `is_gone(face)`, and with each other (not tested if `are_apart`). Counting ends above
/// `most`, and a degenerate fresh face is above it.
///
/// Bounded in tests of two triangles, so that the bound is the same on every machine: `spend(n)` is
/// called for each n of them, a search of the tree being eight, or one for four of its groups where
/// there are more. Where it returns false between searches the answer is above `most`, for safety.
template <class IsGone, class Spend>
Index count_fresh_cuts(const SurfaceMesh& mesh, const BoxTree& boxes, const TrianglePairs& pairs,
                       const std::vector<Triangle>& fresh, bool are_apart, Index most,
                       const IsGone& is_gone, const Spend& spend) {
  constexpr std::int64_t kTestsOfSearch = 8, kGroupsPerTest = 4;
  const auto is_degenerate = [&](const Triangle& t) {
    const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
    return !((b - a).cross(c - a).squaredNorm() > 0.0);
  };
  if (std::any_of(fresh.begin(), fresh.end(), is_degenerate)) return most + 1;
  Index cuts = 0;
  for (const Triangle& t : fresh) {
    if (!spend(kTestsOfSearch)) return most + 1;
    const auto is_enough = [&](Index f) {
      if (is_gone(f)) return false;
      spend(1);
      return pairs.meet(t, mesh.triangle(f)) && ++cuts > most;
    };
    std::int64_t groups = 0;
    boxes.any_near(mesh.position, t, is_enough, &groups);
    spend(std::max(groups / kGroupsPerTest - kTestsOfSearch, std::int64_t{0}));
    if (cuts > most) return cuts;
  }
  if (are_apart) return cuts;
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    if (!spend(static_cast<std::int64_t>(i))) return most + 1;
    for (std::size_t j = 0; j < i; ++j)
      if (pairs.meet(fresh[i], fresh[j]) && ++cuts > most) return cuts;
  }
  return cuts;
}

/// Whether there is any such pair, or a degenerate fresh face.
template <class IsGone, class Spend>
bool fresh_faces_cut(const SurfaceMesh& mesh, const BoxTree& boxes, const TrianglePairs& pairs,
                     const std::vector<Triangle>& fresh, bool are_apart, const IsGone& is_gone,
                     const Spend& spend) {
  return count_fresh_cuts(mesh, boxes, pairs, fresh, are_apart, 0, is_gone, spend) > 0;
}

}  // namespace shrinkwrap
