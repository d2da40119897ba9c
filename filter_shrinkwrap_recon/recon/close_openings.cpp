#include "close_openings.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "box_tree.h"
#include "collapse_rating.h"
#include "delaunay_flips.h"
#include "sort_unique.h"
#include "triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr int kRounds = 60;
constexpr int kTurningRound = 8;  // from here on also by collapses that turn a face
constexpr int kStalls = 3;        // rounds without a removal, edges flipped after each

class OpeningCloser {
 public:
  OpeningCloser(SurfaceMesh& mesh, Index first_extra, const std::vector<Index>& opening_faces,
                Progress& progress)
      : mesh_(mesh),
        first_extra_(first_extra),
        pairs_(mesh.position),
        is_open_(mesh.face_slots(), 0),
        spans_(mesh.face_slots(), 0) {
    for (const Index f : opening_faces) is_open_[f] = 1;
    const Index count = mesh.vertex_slots() - first_extra;
    std::vector<char> is_dropped(static_cast<std::size_t>(count), 1);
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      if (is_open_[f]) continue;
      for (const Index v : mesh.triangle(f)) {
        if (v < first_extra) continue;
        spans_[f] = 1;
        is_dropped[v - first_extra] = 0;
      }
    }
    // Every other one first, then every other one of the rest, and so on; the first of all last.
    for (Index step = 1; step <= count; step *= 2)
      for (Index i = step; i < count; i += 2 * step)
        if (!is_dropped[i]) pending_.push_back(first_extra + i);
    if (count > 0 && !is_dropped[0]) pending_.push_back(first_extra);
    if (!pending_.empty()) boxes_ = BoxTree(mesh.position, mesh.triangles(), progress);
  }

  std::vector<char> close(Progress& progress) {
    const std::size_t given = pending_.size();
    int stalls = 0;
    for (int round = 0; round < kRounds && !pending_.empty(); ++round) {
      std::size_t kept = 0;
      for (const Index v : pending_) {
        if (!try_remove(v, round >= kTurningRound)) pending_[kept++] = v;
        progress.update(1.0 - static_cast<double>(pending_.size()) / static_cast<double>(given));
      }
      const bool is_stuck = kept == pending_.size();
      pending_.resize(kept);
      if (!is_stuck) continue;
      if (round < kTurningRound) {
        round = kTurningRound - 1;
        continue;
      }
      if (++stalls > kStalls) break;
      for (const Index v : pending_) {
        clip_ears(v);
        progress.update(1.0 - static_cast<double>(pending_.size()) / static_cast<double>(given));
      }
    }
    return std::move(spans_);
  }

 private:
  bool try_remove(Index v, bool may_turn) {
    rating_.gather(mesh_, v);
    if (is_at_border()) return try_remove_at_border(v, may_turn);
    rating_.rate(mesh_, v);
    while (true) {
      CollapseRating::Candidate& best = rating_.cheapest();
      if (best.cost == CollapseRating::kRefused) return false;
      if (best.cost >= CollapseRating::kTurnedCost && !may_turn) return false;
      if (mesh_.is_collapse_legal(best.halfedge) && !fan_cuts(best.halfedge)) {
        collapse(best.halfedge);
        return true;
      }
      best.cost = CollapseRating::kRefused;
    }
  }

  bool is_at_border() const {
    return std::any_of(rating_.halfedges().begin(), rating_.halfedges().end(),
                       [&](Index h) { return is_open_[SurfaceMesh::face(h)] != 0; });
  }

  // Into the nearest neighbour that leaves the borders simple loops; true too if the vertex has no
  // face left that stays.
  bool try_remove_at_border(Index v, bool may_turn) {
    targets_.clear();
    Vec3 normal = Vec3::Zero();
    for (const Index h : rating_.halfedges())
      if (!is_open_[SurfaceMesh::face(h)]) normal += mesh_.area_vector(SurfaceMesh::face(h));
    for (const Index h : rating_.halfedges())
      if (!is_open_[SurfaceMesh::face(h)] || !is_open_[SurfaceMesh::face(mesh_.twin(h))])
        targets_.emplace_back((mesh_.position[mesh_.target(h)] - mesh_.position[v]).squaredNorm(),
                              h);
    std::sort(targets_.begin(), targets_.end());
    for (const auto& [length, h] : targets_) {
      if (!mesh_.is_collapse_legal(h) || !keeps_borders(h) || fan_cuts(h)) continue;
      if (!may_turn && fresh_turns_from(normal)) continue;
      collapse(h);
      return true;
    }
    return targets_.empty();
  }

  bool fresh_turns_from(const Vec3& normal) const {
    return std::any_of(fresh_.begin(), fresh_.end(), [&](const Triangle& t) {
      const Vec3 &a = mesh_.position[t[0]], &b = mesh_.position[t[1]], &c = mesh_.position[t[2]];
      const Vec3 area = (b - a).cross(c - a);
      return area.dot(normal) < CollapseRating::kLeastCosine * area.norm() * normal.norm();
    });
  }

  // Whether after a collapse each vertex concerned has one fan of faces that stay, and each sample
  // at least one such face.
  bool keeps_borders(Index halfedge) {
    const Index opposite = mesh_.twin(halfedge);
    const Index first = SurfaceMesh::face(halfedge), second = SurfaceMesh::face(opposite);
    const auto add_fans = [&](Index h) {
      const Index begin = h;
      do {
        const Index f = SurfaceMesh::face(h);
        if (f != first && f != second) ring_.push_back(is_open_[f]);
        h = mesh_.rotate(h);
      } while (h != begin);
    };
    const auto is_one_fan = [&](Index v) {
      Index begins = 0, stay = 0;
      for (std::size_t i = 0; i < ring_.size(); ++i) {
        begins += !ring_[i] && ring_[i > 0 ? i - 1 : ring_.size() - 1];
        stay += !ring_[i];
      }
      return begins <= 1 && (stay > 0 || v >= first_extra_);
    };
    // Around the vertex that stays, the faces of the other come between its own.
    ring_.clear();
    add_fans(halfedge);
    add_fans(opposite);
    if (!is_one_fan(mesh_.target(halfedge))) return false;
    for (const Index h : {SurfaceMesh::prev(halfedge), SurfaceMesh::prev(opposite)}) {
      ring_.clear();
      add_fans(h);
      if (!is_one_fan(mesh_.origin(h))) return false;
    }
    return true;
  }

  // Whether the faces that a collapse makes cut anything but those that it removes.
  bool fan_cuts(Index halfedge) {
    const Index apex = mesh_.target(halfedge);
    fresh_.clear();
    replaced_.clear();
    for (const Index h : rating_.halfedges()) {
      replaced_.push_back(SurfaceMesh::face(h));
      const Index p = mesh_.target(h), q = mesh_.opposite(h);
      if (p != apex && q != apex && !is_open_[SurfaceMesh::face(h)]) fresh_.push_back({apex, p, q});
    }
    return fresh_cuts();
  }

  bool flip_cuts(Index h) {
    const Index o = mesh_.twin(h);
    const Index a = mesh_.origin(h), b = mesh_.origin(o), c = mesh_.opposite(h),
                d = mesh_.opposite(o);
    fresh_ = {{d, c, a}, {c, d, b}};
    replaced_ = {SurfaceMesh::face(h), SurfaceMesh::face(o)};
    return fresh_cuts();
  }

  // Whether the fresh faces meet each other, or any that stays but those that they replace.
  bool fresh_cuts() {
    for (std::size_t i = 0; i < fresh_.size(); ++i) {
      if (is_degenerate(fresh_[i])) return true;
      for (std::size_t j = 0; j < i; ++j)
        if (pairs_.meet(fresh_[i], fresh_[j])) return true;
    }
    const auto is_replaced = [&](Index f) {
      return mesh_.is_removed_face(f) || is_open_[f] ||
             std::find(replaced_.begin(), replaced_.end(), f) != replaced_.end();
    };
    for (const Triangle& t : fresh_)
      if (boxes_.any_near(mesh_.position, t, [&](Index f) {
            return !is_replaced(f) && pairs_.meet(t, mesh_.triangle(f));
          }))
        return true;
    return false;
  }

  bool is_degenerate(const Triangle& t) const {
    const Vec3 &a = mesh_.position[t[0]], &b = mesh_.position[t[1]], &c = mesh_.position[t[2]];
    return !((b - a).cross(c - a).squaredNorm() > 0.0);
  }

  void collapse(Index halfedge) {
    mesh_.collapse(halfedge);
    stack_.clear();
    for (const Index h : rating_.halfedges()) {
      const Index f = SurfaceMesh::face(h);
      if (mesh_.is_removed_face(f)) continue;
      boxes_.set_box(f, boxes_.box_of(mesh_.position, mesh_.triangle(f)));
      stack_.push_back(h);
      stack_.push_back(SurfaceMesh::next(h));
    }
    for (std::size_t looks = 8 * rating_.halfedges().size(); looks > 0 && !stack_.empty();
         --looks) {
      const Index h = stack_.back(), o = mesh_.twin(h);
      stack_.pop_back();
      if (!wants_delaunay_flip(mesh_, h) || !try_flip(h)) continue;
      for (const Index side :
           {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)})
        stack_.push_back(side);
    }
  }

  bool try_flip(Index h) {
    const Index first = SurfaceMesh::face(h), second = SurfaceMesh::face(mesh_.twin(h));
    if (!spans_[first] || !spans_[second] || !mesh_.is_flip_legal(h) || flip_cuts(h)) return false;
    mesh_.flip(h);
    for (const Index f : {first, second})
      boxes_.set_box(f, boxes_.box_of(mesh_.position, mesh_.triangle(f)));
    return true;
  }

  // Takes edges from a vertex that no collapse removes: its ring may be no fan from any corner.
  // Each flip cuts an ear off the ring; those of the shortest diagonals come first.
  void clip_ears(Index v) {
    for (bool has_clipped = true; has_clipped;) {
      has_clipped = false;
      rating_.gather(mesh_, v);
      ears_.clear();
      for (const Index h : rating_.halfedges()) {
        const Vec3 diagonal =
            mesh_.position[mesh_.opposite(h)] - mesh_.position[mesh_.opposite(mesh_.twin(h))];
        ears_.push_back({diagonal.squaredNorm(), h, mesh_.target(h)});
      }
      std::sort(ears_.begin(), ears_.end());
      for (const auto& [length, h, corner] : ears_)
        if (mesh_.origin(h) == v && mesh_.target(h) == corner && mesh_.valence(v) > 3)
          has_clipped = try_flip(h) || has_clipped;
    }
  }

  SurfaceMesh& mesh_;
  Index first_extra_;
  TrianglePairs pairs_;
  BoxTree boxes_;               // of the faces as they are
  std::vector<char> is_open_;   // per face slot: it is dropped at the end, and in nobody's way
  std::vector<char> spans_;     // per face slot
  std::vector<Index> pending_;  // extra vertices
  CollapseRating rating_;
  std::vector<Triangle> fresh_;  // faces that an operation would make ...
  std::vector<Index> replaced_;  // ... in place of these
  std::vector<Index> stack_;
  std::vector<char> ring_;                              // is_open_ of the faces around a vertex
  std::vector<std::pair<double, Index>> targets_;       // length of a half-edge
  std::vector<std::tuple<double, Index, Index>> ears_;  // length of the diagonal, half-edge, corner
};

// Edges that tell faces apart whatever becomes of their indices: the first two corners.
class FaceNames {
 public:
  FaceNames(const SurfaceMesh& mesh, const std::vector<Index>& new_index)
      : mesh_(mesh), new_index_(new_index) {}
  void add(Index f) {
    if (mesh_.is_removed_face(f)) return;
    const Triangle t = mesh_.triangle(f);
    edges_.emplace_back(new_index_[t[0]], new_index_[t[1]]);
  }
  // Once the mesh was renumbered: the faces, ascending, each once.
  std::vector<Index> faces() const {
    std::vector<Index> faces;
    for (const auto& [from, to] : edges_)
      faces.push_back(SurfaceMesh::face(mesh_.find_halfedge(from, to)));
    sort_unique(faces);
    return faces;
  }

 private:
  const SurfaceMesh& mesh_;
  const std::vector<Index>& new_index_;
  std::vector<std::pair<Index, Index>> edges_;
};

}  // namespace

std::vector<char> close_openings(SurfaceMesh& mesh, Index first_extra, Progress& progress,
                                 const std::vector<Index>& opening_faces) {
  return OpeningCloser(mesh, first_extra, opening_faces, progress).close(progress);
}

Index close_openings(CompleteMatching& matching, Index samples, Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  const Index before = mesh.vertex_count();
  const std::vector<char> spans = close_openings(mesh, samples, progress, matching.opening_faces);
  // Samples keep their index. Of the extra vertices only those that go change places.
  std::vector<Index> new_index(mesh.position.size(), kNone);
  Index count = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    if (!mesh.is_removed_vertex(v)) new_index[v] = count++;
  FaceNames spanning(mesh, new_index), open(mesh, new_index);
  for (const Index f : matching.spanning_faces) spanning.add(f);
  for (const Index f : matching.opening_faces) open.add(f);
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (spans[f]) spanning.add(f);
  mesh.renumber(new_index, progress);
  matching.spanning_faces = spanning.faces();
  matching.opening_faces = open.faces();
  matching.sample_of_vertex.resize(mesh.position.size());
  return before - mesh.vertex_count();
}

}  // namespace shrinkwrap
