// A closed, oriented triangle 2-manifold as an index half-edge structure, with the local operations
// of the method, each beside the test that keeps the mesh a closed 2-manifold.
#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "common/progress.h"
#include "common/types.h"

namespace shrinkwrap {

using Triangle = std::array<Index, 3>;

/// A count that several threads may raise at once, and that is copied like a number.
class SharedCount {
 public:
  SharedCount() = default;
  SharedCount(const SharedCount& other) : count_(other.get()) {}
  SharedCount& operator=(const SharedCount& other) {
    count_.store(other.get(), std::memory_order_relaxed);
    return *this;
  }
  Index get() const { return count_.load(std::memory_order_relaxed); }
  void add(Index n) { count_.fetch_add(n, std::memory_order_relaxed); }

 private:
  std::atomic<Index> count_{0};
};

/// Closed triangle mesh. Half-edges 3f, 3f+1, 3f+2 run counter-clockwise around face f (seen from
/// outside), so that `next`, `prev` and `face` are arithmetic; only origin, twin and one outgoing
/// half-edge per vertex are stored: 24 bytes a face and 4 a vertex beside the positions.
///
/// Operations may be run from several threads at once if the vertices they read and write are
/// disjoint and nothing is appended meanwhile. Removed faces and vertices leave free slots
/// (`is_removed`); `compact` drops them.
class SurfaceMesh {
 public:
  std::vector<Vec3> position;  ///< one per vertex slot, in the frame of the stage

  SurfaceMesh() = default;

  /// Builds the connectivity of a list of triangles; the mesh is the same, index for index, whoever
  /// builds it. Throws InvalidInput if the faces do not form a closed, consistently oriented
  /// 2-manifold in which every vertex has exactly one fan (a vertex without faces is refused too).
  /// O(F), parallel.
  static SurfaceMesh from_triangles(std::vector<Vec3> positions,
                                    const std::vector<Triangle>& triangles);
  static SurfaceMesh from_triangles(std::vector<Vec3> positions,
                                    const std::vector<Triangle>& triangles,
                                    Progress& progress);  ///< throws Cancelled
  /// As from_triangles, for faces known to form a closed 2-manifold and whose twins the caller
  /// computed.
  static SurfaceMesh from_halfedges(std::vector<Vec3> positions, std::vector<Index> origins,
                                    std::vector<Index> twins);

  Index vertex_slots() const { return static_cast<Index>(position.size()); }
  Index face_slots() const { return static_cast<Index>(origin_.size() / 3); }
  Index halfedge_slots() const { return static_cast<Index>(origin_.size()); }
  Index vertex_count() const { return vertex_slots() - removed_vertices_.get(); }
  Index face_count() const { return face_slots() - removed_faces_.get(); }
  /// V - E + F of the closed mesh: V - F/2.
  Index euler_characteristic() const { return vertex_count() - face_count() / 2; }

  static Index next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Index prev(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
  static Index face(Index h) { return h / 3; }
  Index origin(Index h) const { return origin_[h]; }
  Index target(Index h) const { return origin_[next(h)]; }
  Index opposite(Index h) const {
    return origin_[prev(h)];
  }  ///< the corner of h's face that is not on h
  Index twin(Index h) const { return twin_[h]; }
  Index outgoing(Index v) const { return outgoing_[v]; }  ///< one half-edge that leaves v
  /// The outgoing half-edge that follows h counter-clockwise around its origin.
  Index rotate(Index h) const { return twin_[prev(h)]; }
  bool is_removed_face(Index f) const { return origin_[3 * f] == kNone; }
  bool is_removed_vertex(Index v) const { return outgoing_[v] == kNone; }
  Triangle triangle(Index f) const {
    return {origin_[3 * f], origin_[3 * f + 1], origin_[3 * f + 2]};
  }

  /// Calls `fn(h)` for each half-edge that leaves v, counter-clockwise.
  template <class Fn>
  void for_each_outgoing(Index v, const Fn& fn) const {
    const Index first = outgoing_[v];
    Index h = first;
    do {
      fn(h);
      h = rotate(h);
    } while (h != first);
  }
  Index valence(Index v) const {
    Index count = 0;
    for_each_outgoing(v, [&](Index) { ++count; });
    return count;
  }
  /// The half-edge from a to b, or kNone.
  Index find_halfedge(Index a, Index b) const;

  /// Twice the area times the unit normal of a face.
  Vec3 area_vector(Index f) const {
    const Vec3 &a = position[origin_[3 * f]], &b = position[origin_[3 * f + 1]],
               &c = position[origin_[3 * f + 2]];
    return (b - a).cross(c - a);
  }
  /// Area-weighted unit normal of a vertex; +z where the faces around it cancel out.
  Vec3 vertex_normal(Index v) const;
  std::vector<Vec3> vertex_normals() const;  ///< all of them, parallel

  /// True if the edge of h may be exchanged for the other diagonal of its two triangles: the
  /// diagonal is not an edge yet. Purely topological.
  bool is_flip_legal(Index h) const;
  /// Exchanges the diagonal. Afterwards h runs from the former opposite(twin(h)) to the former
  /// opposite(h). Pre: is_flip_legal(h).
  void flip(Index h);
  /// Undoes `flip(h)`, but for where the one-rings begin: a quarter turn four times is no turn.
  void flip_back(Index h) {
    for (int turn = 0; turn < 3; ++turn) flip(h);
  }

  /// Link condition (Dey et al. 1999) for merging origin(h) into target(h): the common neighbours
  /// of the two are exactly the two opposite corners, and these keep valence 3 or more. No
  /// allocation.
  bool is_collapse_legal(Index h) const;
  /// Merges origin(h) into target(h), whose position is kept; removes one vertex and two faces.
  /// Pre: is_collapse_legal(h).
  void collapse(Index h);

  /// Inserts a vertex into a face (1-to-3 split) and returns it. The face slot keeps its first
  /// edge.
  Index split_face(Index f, const Vec3& p);
  /// Appends free slots for split_face_into: `vertices` more vertices and `faces` more faces.
  void append_slots(Index vertices, Index faces);
  /// As split_face, using vertex slot v and the face slots g and k that append_slots made (so that
  /// many splits can be laid out beforehand).
  void split_face_into(Index f, Index v, Index g, Index k);

  /// True if the three faces around a vertex may become one: it has valence 3, and the mesh is no
  /// tetrahedron there.
  bool is_move_legal(Index v) const;
  /// Takes a vertex out of its three faces, which become one, and splits face f with it. Returns
  /// the slot of the one face; the first half-edge of f keeps its edge. Pre: is_move_legal(v), f is
  /// none of the three.
  Index move_vertex(Index v, Index f);

  /// How some faces are connected, within and beyond.
  struct Patch {
    std::vector<Index> faces;
    std::vector<Index> origin, twin;  ///< of their half-edges
  };
  Patch copy_patch(const std::vector<Index>& faces) const;
  /// Connects these faces as they were, but for where the one-rings begin. Pre: since `copy_patch`
  /// only edges between them were flipped, and only vertices between them moved to others of them.
  void restore_patch(const Patch& patch);

  /// Drops removed slots, renumbers vertices along a Morton curve and faces by their lowest vertex,
  /// and makes `outgoing` the lowest half-edge of each vertex: the canonical form, in which
  /// from_triangles of the triangles gives the same mesh. Returns, for each old vertex, its new
  /// index or kNone. O(V log V).
  std::vector<Index> compact();
  std::vector<Index> compact(Progress& progress);  ///< throws Cancelled: the mesh is then lost
  /// As compact, with the order of vertices given: `new_index[old]`, kNone for removed vertices; a
  /// bijection of the vertices that are left onto [0, vertex_count()). Returns, for each old face,
  /// its new index or kNone.
  std::vector<Index> renumber(const std::vector<Index>& new_index);
  std::vector<Index> renumber(const std::vector<Index>& new_index,
                              Progress& progress);  ///< as for compact

  /// Every internal link is consistent and every vertex has one fan. O(F); for tests and run-time
  /// postconditions.
  bool is_consistent() const;

  std::vector<Triangle> triangles() const;  ///< of the faces that are left, in order

 private:
  void link(Index a, Index b) {
    twin_[a] = b;
    twin_[b] = a;
  }

  std::vector<Index> origin_;    // per half-edge; kNone in removed faces
  std::vector<Index> twin_;      // per half-edge
  std::vector<Index> outgoing_;  // per vertex; kNone if removed
  SharedCount removed_vertices_, removed_faces_;
};

/// Connected components by edges: the component of each vertex, numbered in order of lowest vertex,
/// and how many.
struct MeshComponents {
  std::vector<Index> of_vertex;
  Index count = 0;
};
MeshComponents connected_components(const SurfaceMesh& mesh);
MeshComponents connected_components(const SurfaceMesh& mesh, Progress& progress);

/// The mesh of the components that are kept (by number), its vertices and faces in their order.
/// `new_index`, if wanted: of each old vertex, kNone for those that go. O(V + F). Pre: no removed
/// slots.
SurfaceMesh kept_components(const SurfaceMesh& mesh, const MeshComponents& components,
                            const std::vector<char>& is_kept, Progress& progress,
                            std::vector<Index>* new_index = nullptr);

/// The corners of a face, which name it whatever becomes of its index.
Triangle ascending_corners(const SurfaceMesh& mesh, Index f);

/// Rounds every vertex as a trip through a host layer of that scalar would (see HostScalar).
void round_to_host(SurfaceMesh& mesh, const Frame& frame, HostScalar scalar);

}  // namespace shrinkwrap
