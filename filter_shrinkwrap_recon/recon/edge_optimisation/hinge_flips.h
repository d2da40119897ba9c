// Edge flips, with account of which faces meet and how the mesh bends.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "mesh/face_meetings.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// The two triangles at an edge, or the two that its flip would make of them.
using Hinge = std::array<Triangle, 2>;

struct HingeShape {
  double bending = 0.0;       ///< sum of length x (1 - cosine of the angle of normals), five edges
  double sharpest = 1.0;      ///< least of these cosines
  double least_height = 1.0;  ///< of a triangle, as a part of its longest edge
};

/// `then` bends less, by more than a thousandth: smaller gains are no reason to flip.
inline bool bends_less(const HingeShape& then, const HingeShape& now) {
  return then.bending < 0.999 * now.bending;
}

/// What a flip may do to the shape, unless it was as bad before.
struct FlipLimits {
  double fold_guard = -1.0;   ///< least cosine of the angle between the normals of neighbours
  double least_height = 0.0;  ///< of a triangle, as a part of its longest edge
};

/// Flips of a mesh whose `FaceMeetings` stay up to date with them.
class HingeFlips {
 public:
  using Pair = FaceMeetings::Pair;

  /// Faces in `fixed_faces` (ascending) stay. All three must outlive the object.
  HingeFlips(SurfaceMesh& mesh, FaceMeetings& meetings, const std::vector<Index>& fixed_faces)
      : mesh_(mesh), meetings_(meetings), fixed_faces_(fixed_faces) {}

  SurfaceMesh& mesh() const { return mesh_; }
  FaceMeetings& meetings() const { return meetings_; }
  const std::vector<Index>& fixed_faces() const { return fixed_faces_; }

  std::vector<Index> faces_at(Index h) const {
    return {SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h))};
  }
  Hinge hinge_at(Index h) const;
  Hinge flipped_hinge_at(Index h) const;
  HingeShape shape_of(Index h, const Hinge& hinge) const;
  /// The flip keeps the mesh a manifold and touches no fixed face.
  bool may_flip(Index h) const;
  /// `then` instead of the faces at h stays within the limits and has no degenerate face. Also
  /// tells both shapes.
  bool is_allowed(Index h, const Hinge& then, const FlipLimits& limits, HingeShape& shape_now,
                  HingeShape& shape_then) const;

  /// Of the faces at h, as they are.
  std::vector<Pair> pairs_at(Index h) const { return meetings_.pairs_of(faces_at(h)); }
  std::ptrdiff_t pair_count_at(Index h) const {
    return static_cast<std::ptrdiff_t>(pairs_at(h).size());
  }
  /// The pairs of a hinge if it replaces the faces at the edge h. False if they are more than
  /// `most` or if that would take too long to find out.
  bool find_pairs(Index h, const Hinge& hinge, std::size_t most, std::vector<Pair>& pairs) const;

  /// Flips h if it may be, within the limits, and if its faces have at most so many pairs then as
  /// `most_pairs(shape_now, shape_then)` says (std::ptrdiff_t; negative: not at all). Returns
  /// whether it did.
  template <class MostPairs>
  bool try_flip(Index h, const FlipLimits& limits, const MostPairs& most_pairs) {
    if (!may_flip(h)) return false;
    const Hinge then = flipped_hinge_at(h);
    HingeShape shape_now, shape_then;
    if (!is_allowed(h, then, limits, shape_now, shape_then)) return false;
    const std::ptrdiff_t most = most_pairs(shape_now, shape_then);
    if (most < 0 || !find_pairs(h, then, static_cast<std::size_t>(most), pairs_)) return false;
    flip(h, pairs_);
    return true;
  }
  /// Flips h, after which its faces have these pairs.
  void flip(Index h, const std::vector<Pair>& pairs) {
    mesh_.flip(h);
    update(h, pairs);
  }
  /// Undoes it; before, the faces had these pairs.
  void flip_back(Index h, const std::vector<Pair>& pairs) {
    mesh_.flip_back(h);
    update(h, pairs);
  }

 private:
  void update(Index h, const std::vector<Pair>& pairs) {
    meetings_.update_boxes(faces_at(h));
    meetings_.replace(faces_at(h), pairs);
  }

  SurfaceMesh& mesh_;
  FaceMeetings& meetings_;
  const std::vector<Index>& fixed_faces_;
  std::vector<Pair> pairs_;  // of a flip that is tried; kept for its memory
};

}  // namespace shrinkwrap
