#include "mesh/delaunay_flips.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

// Sine of the excess over a half turn below which an edge is as good as its flip, so that four
// vertices on a circle do not flip for ever.
constexpr double kLeastExcess = 1e-7;
constexpr std::size_t kLooksPerEdge = 32;
constexpr Index kProgressStride = 1 << 12;

}  // namespace

bool wants_delaunay_flip(const SurfaceMesh& mesh, Index h) {
  const Index o = mesh.twin(h);
  const Index corner_c = mesh.opposite(h), corner_d = mesh.opposite(o);
  if (corner_c == corner_d) return false;
  const Vec3 &a = mesh.position[mesh.origin(h)], &b = mesh.position[mesh.origin(o)];
  const Vec3 &c = mesh.position[corner_c], &d = mesh.position[corner_d];
  const Vec3 ca = a - c, cb = b - c, da = a - d, db = b - d;
  const double cos_c = ca.dot(cb), cos_d = da.dot(db);
  if (cos_c >= 0.0 && cos_d >= 0.0) return false;
  // cot(c) + cot(d) < 0, multiplied by both sines.
  Vec3 old_first = ca.cross(cb), old_second = db.cross(da);
  const double sin_c = old_first.norm(), sin_d = old_second.norm();
  const double excess = -(cos_c * sin_d + cos_d * sin_c);
  if (!(excess > kLeastExcess * (sin_c * sin_d + std::abs(cos_c * cos_d)))) return false;

  const Vec3 dc = c - d;
  const Vec3 new_first = unit_or_zero(dc.cross(da)), new_second = unit_or_zero(db.cross(dc));
  if (sin_c > 0.0) old_first /= sin_c;
  if (sin_d > 0.0) old_second /= sin_d;
  return keeps_side(old_first, old_second, new_first, new_second, Vec3(old_first + old_second));
}

void flip_to_delaunay(SurfaceMesh& mesh, const BlockOwner& owner, std::vector<Index>& stack,
                      std::vector<Index>* deferred, Index& budget) {
  const auto defer = [&](Index h) {
    if (deferred) deferred->push_back(h);
  };
  while (!stack.empty()) {
    const Index h = stack.back();
    stack.pop_back();
    if (budget <= 0) continue;
    --budget;
    if (!owner.owns(mesh.origin(h)) || !owner.owns(mesh.target(h))) {
      defer(h);
      continue;
    }
    if (!wants_delaunay_flip(mesh, h)) continue;
    const Index o = mesh.twin(h);
    if (!owner.owns(mesh.opposite(h)) || !owner.owns(mesh.opposite(o))) {
      defer(h);
      continue;
    }
    if (!mesh.is_flip_legal(h)) continue;
    mesh.flip(h);
    for (const Index side :
         {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)})
      stack.push_back(side);
  }
}

void make_delaunay(SurfaceMesh& mesh, const VertexBlocks& blocks, Progress& progress) {
  const auto seed = [&](Index v, std::vector<Index>& edges) {
    if (mesh.is_removed_vertex(v)) return;
    mesh.for_each_outgoing(v, [&](Index h) {
      if (h < mesh.twin(h)) edges.push_back(h);
    });
  };
  const auto anchor = [&](Index h) { return mesh.origin(h); };
  const auto work = [&](const BlockOwner& owner, std::vector<Index>& edges) {
    std::vector<Index> stack, deferred;
    Index budget = static_cast<Index>(
        std::min<std::size_t>(kLooksPerEdge * edges.size(), std::numeric_limits<Index>::max()));
    for (std::size_t i = 0; i < edges.size(); ++i) {
      stack.assign(1, edges[i]);
      flip_to_delaunay(mesh, owner, stack, owner.is_last() ? nullptr : &deferred, budget);
      if (owner.is_last() && i % kProgressStride == 0)
        progress.update(static_cast<double>(i) / static_cast<double>(edges.size()));
    }
    edges.swap(deferred);
  };
  run_in_blocks(blocks, progress, seed, anchor, work);
}

}  // namespace shrinkwrap
