// Loops of edges on a closed surface, and cuts along them.
#pragma once

#include <vector>

#include "common/progress.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap {

using Loop = std::vector<Index>;  ///< vertices, each joined to the next, the last to the first

/// Shortest paths, by number of edges, from some vertices to all that are within reach: of their
/// components, or of a ball. 8 bytes per vertex of the mesh, which are used again.
class PathTree {
 public:
  explicit PathTree(const SurfaceMesh& mesh)
      : distance_(mesh.position.size(), kNone), toward_root_(mesh.position.size(), kNone) {}

  /// Starts anew. False if there are more than `most` vertices within the radius (in edges).
  bool grow(const SurfaceMesh& mesh, const std::vector<Index>& roots, Index radius,
            std::size_t most, Progress& progress);

  const std::vector<Index>& reached() const { return reached_; }  ///< the nearest first
  bool has_reached(Index v) const { return distance_[v] != kNone; }
  Index distance(Index v) const { return distance_[v]; }
  bool has_edge(const SurfaceMesh& mesh, Index h) const {
    return toward_root_[mesh.origin(h)] == h || toward_root_[mesh.target(h)] == mesh.twin(h);
  }
  Index loop_length(const SurfaceMesh& mesh, Index h) const {
    return distance_[mesh.origin(h)] + distance_[mesh.target(h)] + 1;
  }
  /// The cycle of an edge and the paths from its ends to where they meet.
  Loop loop(const SurfaceMesh& mesh, Index h) const;
  /// Whether every loop within what was reached bounds a part of it, as in a disc. Pre: one root,
  /// not all of its component reached.
  bool is_disc(const SurfaceMesh& mesh) const;

 private:
  std::vector<Index> distance_;
  std::vector<Index> toward_root_;  // half-edge that leaves the vertex
  std::vector<Index> reached_;
};

/// Loops through the roots, one of each component, each up to where its two ends part, of which
/// none separates the surface, nor do any that have no vertex in common: no two are homologous. The
/// shortest through the roots, by a tree and a cotree (Erickson and Whittlesey 2005); the shortest
/// first. O(V log V).
std::vector<Loop> loops_from(const SurfaceMesh& mesh, const std::vector<Index>& roots,
                             Progress& progress);

/// A shortest loop through a vertex among those within so many edges of it that no disc bounds;
/// whether it separates the surface is not looked into, as that would take all of it. Empty if
/// there is none, or the ball has more than 16,384 vertices.
Loop loop_in_ball(const SurfaceMesh& mesh, PathTree& tree, Index centre, Index radius,
                  Progress& progress);

/// Loops that have no vertex in common, at most so many.
class DisjointLoops {
 public:
  DisjointLoops(const SurfaceMesh& mesh, Index most)
      : most_(static_cast<std::size_t>(most)), is_taken_(mesh.position.size(), 0) {}
  /// Takes the loop, unless it is empty or meets one that was taken.
  void add(const Loop& loop);

  std::vector<Loop> loops;

 private:
  std::size_t most_;
  std::vector<char> is_taken_;  // per vertex
};

/// Puts the shortest first; those of one length stay in order.
void sort_by_length(std::vector<Loop>& loops);

/// Leaves out loops, of those that separate the surface together the last: along the others it can
/// be cut and stays in one piece. Turns the order round. Pre: they have no vertex in common. O(F).
void keep_inseparable(const SurfaceMesh& mesh, std::vector<Loop>& loops, Progress& progress);

/// Leaves out loops, the last first, but for the mouths of cavities: loops around a tunnel, not
/// a rod, where a cut parts the wall of a cavity (what encloses less than nothing) from what bounds
/// a body, and each of the two holds at least `least` samples, as `samples_of` counts them at the
/// vertices. Pre: they have no vertex in common, the mesh has no removed slots. O(V).
void keep_mouths_of_cavities(const SurfaceMesh& mesh, std::vector<Loop>& loops,
                             const std::vector<Index>& samples_of, Index least, Progress& progress);

/// Opens the surface along loops that have no vertex in common, and closes each side with a fan.
/// Post: not compact.
void cut_along(SurfaceMesh& mesh, const std::vector<Loop>& loops, Progress& progress);

}  // namespace shrinkwrap
