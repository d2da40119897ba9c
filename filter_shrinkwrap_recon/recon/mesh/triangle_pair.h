// Two triangles of a mesh: do they meet away from what they share?
#pragma once

#include <vector>

#include "common/types.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// Tells whether two faces of a mesh meet: whether the closed triangles have a point in common that
/// lies on no corner or edge they share. Corners are shared if their indices are equal; two faces
/// of the same three corners meet; a degenerate face (collinear corners) meets nothing.
///
/// Exact (Guigue and Devillers 2003 where no corner is shared). Behind a filter whose error bound
/// holds for the whole mesh: some 20 ns for neighbours that do not meet.
class TrianglePairs {
 public:
  /// The positions must outlive the object and stay within their bounding box; those that are not
  /// finite must not be used by faces that are tested. O(V).
  explicit TrianglePairs(const std::vector<Vec3>& positions);

  /// Pre: no face uses an index twice.
  bool meet(const Triangle& f, const Triangle& g) const;

 private:
  const std::vector<Vec3>* positions_;
  double error_bound_;  // of any orientation determinant of four positions
};

}  // namespace shrinkwrap
