#include "complete_matching/vertex_removal.h"

#include "geometry/triangle_geometry.h"
#include "mesh/collapse_rating.h"
#include "mesh/delaunay_flips.h"

namespace shrinkwrap {
namespace {

constexpr int kRoundsPerBlock = 4;
constexpr int kLastRounds = 40;
constexpr Index kProgressStride = 1 << 10;
constexpr Index kFewFaces = 32;  // around a vertex: from there on, edges are taken one by one

enum class Outcome { removed, postponed, not_owned };

// Removes vertices of one block.
class VertexRemover {
 public:
  VertexRemover(SurfaceMesh& mesh, const BlockOwner& owner) : mesh_(mesh), owner_(owner) {}

  VertexRemovalReport report;

  // Collapses the vertex into a neighbour; `may_turn`: even if that turns a face away.
  Outcome try_remove(Index v, bool may_turn) {
    if (!owner_.owns(v)) return Outcome::not_owned;
    rating_.gather(mesh_, v);
    for (const Index u : rating_.neighbours())
      if (!owner_.owns(u)) return Outcome::not_owned;
    rating_.rate(mesh_, v);
    while (true) {
      CollapseRating::Candidate& best = rating_.cheapest();
      const bool turns = best.cost >= CollapseRating::kTurnedCost;
      if (best.cost == CollapseRating::kRefused || (turns && !may_turn)) return Outcome::postponed;
      if (mesh_.is_collapse_legal(best.halfedge)) {
        collapse(best.halfedge);
        ++report.removed;
        if (turns) ++report.forced;
        return Outcome::removed;
      }
      best.cost = CollapseRating::kRefused;
    }
  }

  // For a vertex that no collapse removes: takes edges from it until one does.
  bool remove_after_flips(Index v, Progress& progress) {
    for (const bool may_turn : {false, true}) {
      for (Index valence = mesh_.valence(v); valence > kFewFaces;) {
        progress.update(1.0);
        const Index left = flip_edges_away(v, std::max(valence / 2, kFewFaces), may_turn);
        if (left == valence) break;
        if (try_remove(v, false) == Outcome::removed) return true;
        valence = left;
      }
      while (mesh_.valence(v) > 3) {
        if (!flip_one_edge_away(v, may_turn)) break;
        if (try_remove(v, false) == Outcome::removed) return true;
      }
      if (try_remove(v, may_turn) == Outcome::removed) return true;
    }
    return false;
  }

 private:
  void collapse(Index halfedge) {
    mesh_.collapse(halfedge);
    stack_.clear();
    for (const Index h : rating_.halfedges()) {
      if (mesh_.is_removed_face(SurfaceMesh::face(h))) continue;
      stack_.push_back(h);
      stack_.push_back(SurfaceMesh::next(h));
    }
    Index budget = 8 * static_cast<Index>(rating_.halfedges().size()) + 16;
    flip_to_delaunay(mesh_, owner_, stack_, nullptr, budget);
  }

  // In one walk around the vertex, until it has so few edges. Returns how many it has then.
  Index flip_edges_away(Index v, Index few, bool may_turn) {
    rating_.gather(mesh_, v);
    Index valence = static_cast<Index>(rating_.halfedges().size());
    for (const Index h : rating_.halfedges()) {
      if (valence <= few) break;
      if (mesh_.origin(h) != v || !mesh_.is_flip_legal(h) || (!may_turn && turns_a_face(h)))
        continue;
      mesh_.flip(h);
      --valence;
    }
    return valence;
  }

  bool flip_one_edge_away(Index v, bool may_turn) {
    rating_.gather(mesh_, v);
    for (const Index h : rating_.halfedges()) {
      if (!mesh_.is_flip_legal(h) || (!may_turn && turns_a_face(h))) continue;
      mesh_.flip(h);
      return true;
    }
    return false;
  }

  bool turns_a_face(Index h) const {
    const Index o = mesh_.twin(h);
    const Vec3 &a = mesh_.position[mesh_.origin(h)], &b = mesh_.position[mesh_.origin(o)];
    const Vec3 &c = mesh_.position[mesh_.opposite(h)], &d = mesh_.position[mesh_.opposite(o)];
    const Vec3 old_first = unit_or_zero((b - a).cross(c - a)),
               old_second = unit_or_zero((a - b).cross(d - b)),
               new_first = unit_or_zero((c - d).cross(a - d)),
               new_second = unit_or_zero((d - c).cross(b - c));
    return !keeps_side(old_first, old_second, new_first, new_second, Vec3(old_first + old_second));
  }

  SurfaceMesh& mesh_;
  const BlockOwner& owner_;
  CollapseRating rating_;
  std::vector<Index> stack_;
};

}  // namespace

VertexRemovalReport remove_vertices(SurfaceMesh& mesh, const VertexBlocks& blocks,
                                    const std::vector<char>& is_marked, Progress& progress) {
  const auto seed = [&](Index v, std::vector<Index>& vertices) {
    if (static_cast<std::size_t>(v) < is_marked.size() && is_marked[v]) vertices.push_back(v);
  };
  const auto anchor = [](Index v) { return v; };
  SharedCount removed, forced;
  VertexRemovalReport total;

  const auto work = [&](const BlockOwner& owner, std::vector<Index>& vertices) {
    VertexRemover remover(mesh, owner);
    std::vector<Index> not_owned;
    const std::size_t given = vertices.size();
    const int rounds = owner.is_last() ? kLastRounds : kRoundsPerBlock;
    for (int round = 0; round < rounds && !vertices.empty(); ++round) {
      std::size_t kept = 0, done = 0;
      for (const Index v : vertices) {
        const Outcome outcome = remover.try_remove(v, false);
        if (outcome == Outcome::postponed) vertices[kept++] = v;
        if (outcome == Outcome::not_owned) not_owned.push_back(v);
        if (owner.is_last() && ++done % kProgressStride == 0)
          progress.update(1.0 - static_cast<double>(vertices.size() - done) / given);
      }
      const bool is_stuck = kept == vertices.size();
      vertices.resize(kept);
      if (is_stuck) break;
    }
    if (owner.is_last()) {
      // A removal may free another that could not be done before it.
      for (std::size_t before = vertices.size() + 1; vertices.size() < before;) {
        before = vertices.size();
        std::size_t kept = 0;
        for (const Index v : vertices) {
          if (!remover.remove_after_flips(v, progress)) vertices[kept++] = v;
          progress.update(1.0);
        }
        vertices.resize(kept);
      }
      total.left = static_cast<Index>(vertices.size());
      vertices.clear();
    } else {
      vertices.insert(vertices.end(), not_owned.begin(), not_owned.end());
    }
    removed.add(remover.report.removed);
    forced.add(remover.report.forced);
  };
  run_in_blocks(blocks, progress, seed, anchor, work);
  total.removed = removed.get();
  total.forced = forced.get();
  return total;
}

}  // namespace shrinkwrap
