// What the half-edge collapses that remove a vertex would make of its neighbourhood.
#pragma once

#include <limits>
#include <vector>

#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// The one-ring of a vertex, and the collapses of the vertex into its neighbours by cost
/// 3 (1 - min n.n_v) - min angle, over the new faces of unit normal n; n_v is the normal at the
/// vertex. Kept from vertex to vertex, so that nothing is allocated in a loop.
class CollapseRating {
 public:
  /// Refused: not to be considered (any more).
  static constexpr double kRefused = std::numeric_limits<double>::infinity();
  /// Below this n.n_v a face counts as turned away; costs of such collapses are from kTurnedCost
  /// on.
  static constexpr double kLeastCosine = 0.2;
  static constexpr double kTurnedCost = 10.0;
  struct Candidate {
    double cost;
    Index halfedge;  ///< from the vertex
  };

  void gather(const SurfaceMesh& mesh, Index v);
  /// Half-edges that leave the vertex, counter-clockwise, and their targets.
  const std::vector<Index>& halfedges() const { return halfedge_; }
  const std::vector<Index>& neighbours() const { return neighbour_; }

  /// Rates the collapses into all neighbours, or into evenly spread ones where there are more
  /// than 32. O(valence) for many neighbours, O(valence^2) for few.
  void rate(const SurfaceMesh& mesh, Index v);
  /// Cheapest first; ties in the order of the ring.
  Candidate& cheapest();

 private:
  double cost_of(Index apex, const Vec3& normal) const;

  std::vector<Index> halfedge_, neighbour_;
  std::vector<Vec3> point_;
  std::vector<Candidate> candidate_;
};

}  // namespace shrinkwrap
