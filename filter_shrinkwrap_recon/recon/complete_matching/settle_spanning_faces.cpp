#include "complete_matching/settle_spanning_faces.h"

#include <algorithm>

#include "mesh/box_tree.h"
#include "mesh/delaunay_flips.h"
#include "mesh/fresh_faces.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr std::size_t kLooksPerEdge = 32;
constexpr std::size_t kPollInterval = 1 << 8;

// The edges between faces that may change: those that span, neither dropped nor fixed.
class Settling {
 public:
  Settling(CompleteMatching& matching, const std::vector<Index>& fixed_faces)
      : mesh_(matching.mesh),
        opening_faces_(matching.opening_faces),
        may_change_(static_cast<std::size_t>(mesh_.face_slots()), 0) {
    for (const Index f : matching.spanning_faces) may_change_[f] = 1;
    for (const Index f : matching.opening_faces) may_change_[f] = 0;
    for (const Index f : fixed_faces) may_change_[f] = 0;
    for (const Index f : matching.spanning_faces)
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        if (may_change_[f])
          longest_ = std::max(longest_, squared_length(mesh_.origin(h), mesh_.target(h)));
        if (h < mesh_.twin(h) && may_change(h)) edges_.push_back(h);
      }
  }

  Index run(std::int64_t max_tests, Progress& progress) {
    if (edges_.empty()) return 0;
    boxes_ = BoxTree(mesh_.position, mesh_.triangles(), progress);
    tests_left_ = max_tests;
    Index flips = 0;
    for (std::size_t looks = kLooksPerEdge * edges_.size();
         looks > 0 && !edges_.empty() && tests_left_ > 0; --looks) {
      if (looks % kPollInterval == 0) progress.update(0.0);
      const Index h = edges_.back();
      edges_.pop_back();
      if (!try_flip(h)) continue;
      ++flips;
      const Index o = mesh_.twin(h);
      for (const Index side :
           {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)})
        if (may_change(side)) edges_.push_back(side);
    }
    return flips;
  }

 private:
  bool may_change(Index h) const {
    return may_change_[SurfaceMesh::face(h)] && may_change_[SurfaceMesh::face(mesh_.twin(h))];
  }

  double squared_length(Index v, Index w) const {
    return (mesh_.position[w] - mesh_.position[v]).squaredNorm();
  }

  // A flip before may have made h another edge: of its face, but perhaps of one that stays.
  bool try_flip(Index h) {
    if (!may_change(h) || !wants_delaunay_flip(mesh_, h) || !mesh_.is_flip_legal(h)) return false;
    if (squared_length(mesh_.opposite(h), mesh_.opposite(mesh_.twin(h))) > longest_) return false;
    if (flip_cuts(h)) return false;
    mesh_.flip(h);
    for (const Index f : {SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h))})
      boxes_.set_box(f, boxes_.box_of(mesh_.position, mesh_.triangle(f)));
    return true;
  }

  // True too if the tests do not suffice.
  bool flip_cuts(Index h) {
    const Index o = mesh_.twin(h), first = SurfaceMesh::face(h), second = SurfaceMesh::face(o);
    const Index a = mesh_.origin(h), b = mesh_.origin(o), c = mesh_.opposite(h),
                d = mesh_.opposite(o);
    fresh_ = {{d, c, a}, {c, d, b}};
    const auto is_gone = [&](Index f) {
      return f == first || f == second ||
             std::binary_search(opening_faces_.begin(), opening_faces_.end(), f);
    };
    return fresh_faces_cut(mesh_, boxes_, pairs_, fresh_, false, is_gone, [&](std::int64_t tests) {
      tests_left_ -= tests;
      return tests_left_ > 0;
    });
  }

  SurfaceMesh& mesh_;
  const std::vector<Index>& opening_faces_;  // ascending
  BoxTree boxes_;
  TrianglePairs pairs_{mesh_.position};
  std::int64_t tests_left_ = 0;
  std::vector<char> may_change_;  // per face
  std::vector<Index> edges_;      // still to be looked at
  double longest_ = 0.0;          // of the edges of faces that may change, squared
  std::vector<Triangle> fresh_;   // faces that a flip would make
};

}  // namespace

Index settle_spanning_faces(CompleteMatching& matching, const std::vector<Index>& fixed_faces,
                            const SettlingOptions& options, Progress& progress) {
  if (matching.spanning_faces.empty()) return 0;
  const std::int64_t tests = options.max_tests > 0
                                 ? options.max_tests
                                 : 2000000 + 20 * std::int64_t{matching.mesh.face_count()};
  return Settling(matching, fixed_faces).run(tests, progress);
}

}  // namespace shrinkwrap
