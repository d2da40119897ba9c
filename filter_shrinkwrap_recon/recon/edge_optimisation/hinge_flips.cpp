#include "edge_optimisation/hinge_flips.h"

#include <Eigen/Geometry>

#include "geometry/exact_predicates.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {

Hinge HingeFlips::hinge_at(Index h) const {
  const Index a = mesh_.origin(h), b = mesh_.target(h);
  return {{{a, b, mesh_.opposite(h)}, {b, a, mesh_.opposite(mesh_.twin(h))}}};
}

Hinge HingeFlips::flipped_hinge_at(Index h) const {
  const Index a = mesh_.origin(h), b = mesh_.target(h);
  const Index c = mesh_.opposite(h), d = mesh_.opposite(mesh_.twin(h));
  return {{{d, c, a}, {c, d, b}}};
}

HingeShape HingeFlips::shape_of(Index h, const Hinge& hinge) const {
  const auto& p = mesh_.position;
  const auto normal_of = [&](const Triangle& t) {
    return unit_or_zero((p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]));
  };
  HingeShape shape;
  Vec3 normal[2];
  for (int side = 0; side < 2; ++side) {
    const Triangle& t = hinge[side];
    normal[side] = normal_of(t);
    shape.least_height = std::min(shape.least_height, relative_height(p[t[0]], p[t[1]], p[t[2]]));
  }
  const auto bend = [&](Index a, Index b, double cosine) {
    shape.bending += (p[b] - p[a]).norm() * (1.0 - cosine);
    shape.sharpest = std::min(shape.sharpest, cosine);
  };
  bend(hinge[0][0], hinge[0][1], normal[0].dot(normal[1]));
  const Index o = mesh_.twin(h);
  for (Index outer :
       {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)}) {
    const Index a = mesh_.origin(outer), b = mesh_.target(outer), across = mesh_.twin(outer);
    // The triangle of the hinge that has this edge.
    const Triangle& first = hinge[0];
    const int side = (first[0] == a || first[1] == a || first[2] == a) &&
                             (first[0] == b || first[1] == b || first[2] == b)
                         ? 0
                         : 1;
    bend(a, b, normal[side].dot(normal_of({b, a, mesh_.opposite(across)})));
  }
  return shape;
}

bool HingeFlips::may_flip(Index h) const {
  const auto is_fixed = [&](Index f) {
    return std::binary_search(fixed_faces_.begin(), fixed_faces_.end(), f);
  };
  return mesh_.is_flip_legal(h) && !is_fixed(SurfaceMesh::face(h)) &&
         !is_fixed(SurfaceMesh::face(mesh_.twin(h)));
}

bool HingeFlips::is_allowed(Index h, const Hinge& then, const FlipLimits& limits,
                            HingeShape& shape_now, HingeShape& shape_then) const {
  shape_now = shape_of(h, hinge_at(h));
  shape_then = shape_of(h, then);
  if (shape_then.sharpest < std::min(limits.fold_guard, shape_now.sharpest)) return false;
  if (shape_then.least_height < std::min(limits.least_height, shape_now.least_height)) return false;
  const auto& p = mesh_.position;
  return std::all_of(then.begin(), then.end(), [&](const Triangle& t) {
    return projection_axis(p[t[0]], p[t[1]], p[t[2]]) != kNone;
  });
}

bool HingeFlips::find_pairs(Index h, const Hinge& hinge, std::size_t most,
                            std::vector<Pair>& pairs) const {
  const std::vector<Index> faces = faces_at(h);
  const auto skip = [&](Index g) { return g == faces[0] || g == faces[1]; };
  pairs.clear();
  if (meetings_.meet(hinge[0], hinge[1])) pairs.emplace_back(faces[0], faces[1]);
  for (std::size_t side = 0; side < 2; ++side)
    if (pairs.size() > most ||
        !meetings_.find(hinge[side], faces[side], most - pairs.size(), skip, pairs))
      return false;
  return true;
}

}  // namespace shrinkwrap
