// What a reconstruction is, judged from points and triangles by nothing of the library.
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

#include "common/types.h"
#include "report/result_mesh.h"

namespace shrinkwrap::robustness {

struct Judgement {
  Index samples = 0;       ///< distinct finite points that were not left out
  Index vertices = 0;      ///< of the mesh, used or not
  Index unused = 0;        ///< vertices without a face
  Index border_edges = 0;  ///< of one face
  bool manifold = false;   ///< every edge one face or two that agree, every vertex one fan
  Index components = 0;
  Index genus = -1;  ///< summed; -1 unless closed and manifold
  bool outward = false;
  Index missing = 0;        ///< samples that are no vertex
  Index repeated = 0;       ///< vertices at the place of another
  Index extra = 0;          ///< vertices that are no sample
  Index moved = 0;          ///< vertices not at the point that they are said to be
  Index intersecting = -1;  ///< faces that cut others; -1: not counted
  Index degenerate = -1;    ///< faces with collinear corners, which are not among them

  bool closed() const { return border_edges == 0; }
};

/// How many of `a` are not in `b`. Pre: both ascending.
template <class T>
Index count_difference(const std::vector<T>& a, const std::vector<T>& b) {
  std::vector<T> difference;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(difference));
  return static_cast<Index>(difference.size());
}

/// `left_out` are points that the reconstruction says it left out, ascending.
Judgement judge(const std::vector<Vec3>& points, const std::vector<Index>& left_out,
                const ResultMesh& mesh, bool count_intersections);

struct IntersectingFaces {
  Index intersecting = 0, degenerate = 0;
};
/// By CGAL, exact. Pre: manifold, no unused vertices.
IntersectingFaces count_intersecting_faces(const ResultMesh& mesh);
/// Whether every component has its solid on the inner side of its faces, cavities and what is in
/// them too. By CGAL. Those as thin as the rounding of coordinates, of samples in one plane, have
/// no side. Pre: closed, manifold, no face cuts another.
bool bounds_a_volume(const ResultMesh& mesh);

}  // namespace shrinkwrap::robustness
