#include "complete_matching/close_openings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "common/sort_unique.h"
#include "geometry/triangle_geometry.h"
#include "mesh/box_tree.h"
#include "mesh/collapse_rating.h"
#include "mesh/delaunay_flips.h"
#include "mesh/fresh_faces.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr int kRounds = 60;
constexpr int kTurningRound = 8;  // from here on also by collapses that turn a face
constexpr int kStalls = 3;        // rounds without a removal, edges flipped after each

constexpr std::int64_t kLeastTests = 2000000;
constexpr std::int64_t kTestsPerFace = 200;
constexpr std::int64_t kPollInterval = 1 << 12;

// Where faces have changed, and when: a coarse grid over a box, each cell with the time of its last
// change. Says rather too often that something has changed.
class ChangeMap {
 public:
  using Box = BoxTree::Box;

  ChangeMap() = default;
  explicit ChangeMap(const Box& box) : box_(box), changed_(kCells * kCells * kCells, 0) {}

  std::uint32_t now() const { return now_; }
  void mark(const Box& box) {
    ++now_;
    for_each_cell(box, [&](int place) {
      changed_[place] = now_;
      return false;
    });
  }
  bool has_changed(const Box& box, std::uint32_t since) const {
    return for_each_cell(box, [&](int place) { return changed_[place] > since; });
  }

 private:
  static constexpr int kCells = 32;  // along each axis

  // Rising with the coordinate, so that boxes that overlap have a cell in common.
  int cell(float x, int axis) const {
    const float low = box_[axis], width = box_[axis + 3] - low;
    return width > 0.0f
               ? static_cast<int>(std::clamp((x - low) / width * kCells, 0.0f, kCells - 1.0f))
               : 0;
  }
  // Until `fn` returns true; returns whether it did.
  template <class Fn>
  bool for_each_cell(const Box& box, const Fn& fn) const {
    std::array<int, 3> first, last;
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = cell(box[axis], axis);
      last[axis] = cell(box[axis + 3], axis);
    }
    for (int x = first[0]; x <= last[0]; ++x)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int z = first[2]; z <= last[2]; ++z)
          if (fn((x * kCells + y) * kCells + z)) return true;
    return false;
  }

  Box box_{};
  std::vector<std::uint32_t> changed_;
  std::uint32_t now_ = 0;
};

BoxTree::Box joined(const BoxTree::Box& a, const BoxTree::Box& b) {
  BoxTree::Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box[axis] = std::min(a[axis], b[axis]);
    box[axis + 3] = std::max(a[axis + 3], b[axis + 3]);
  }
  return box;
}

class OpeningCloser {
 public:
  OpeningCloser(SurfaceMesh& mesh, Index first_extra, const std::vector<Index>& opening_faces,
                const ClosingOptions& options, Progress& progress)
      : mesh_(mesh),
        first_extra_(first_extra),
        progress_(progress),
        pairs_(mesh.position),
        is_open_(mesh.face_slots(), 0),
        most_cuts_(options.most_cuts),
        max_tests_(options.max_tests > 0 ? options.max_tests
                                         : kLeastTests + kTestsPerFace * mesh.face_slots()) {
    for (const Index f : opening_faces) is_open_[f] = 1;
    closing_.spans.assign(static_cast<std::size_t>(mesh.face_slots()), 0);
    const Index count = mesh.vertex_slots() - first_extra;
    std::vector<char> is_dropped(static_cast<std::size_t>(count), 1);
    for (Index f = 0; f < mesh.face_slots(); ++f) {
      if (is_open_[f]) continue;
      for (const Index v : mesh.triangle(f)) {
        if (v < first_extra) continue;
        closing_.spans[f] = 1;
        is_dropped[v - first_extra] = 0;
      }
    }
    // Every other one first, then every other one of the rest, and so on; the first of all last.
    const auto add = [&](Index i) {
      if (is_dropped[i] ||
          std::binary_search(options.held.begin(), options.held.end(), first_extra + i))
        return;
      Pending pending;
      pending.vertex = first_extra + i;
      pending_.push_back(pending);
    };
    for (Index step = 1; step <= count; step *= 2)
      for (Index i = step; i < count; i += 2 * step) add(i);
    if (count > 0) add(0);
    given_ = pending_.size();
    if (pending_.empty()) return;
    boxes_ = BoxTree(mesh.position, mesh.triangles(), progress);
    Box all = box_around(pending_.front().vertex);
    for (const Pending& pending : pending_) all = joined(all, box_around(pending.vertex));
    changes_ = ChangeMap(all);
  }

  Closing close() {
    remove_all();
    while (cuts_ < most_cuts_ && !pending_.empty() && has_tests_left()) {
      cuts_ = std::min(std::max(2 * cuts_, Index{1}), most_cuts_);
      for (Pending& pending : pending_) pending.tried = Pending::kNever;
      remove_all();
    }
    return std::move(closing_);
  }

 private:
  using Box = BoxTree::Box;

  // A vertex that has not gone yet, and what is known of the last trials.
  struct Pending {
    static constexpr std::uint32_t kNever = ~std::uint32_t{0};
    Index vertex = kNone;
    Box box{};                       // of the faces around it
    std::uint32_t tried = kNever;    // when a removal failed ...
    std::uint32_t clipped = kNever;  // ... and the last flip
    bool could_turn = false;
  };

  void remove_all() {
    int stalls = 0;
    for (int round = 0; round < kRounds && !pending_.empty() && has_tests_left(); ++round) {
      const bool may_turn = round >= kTurningRound;
      std::size_t kept = 0;
      for (Pending& pending : pending_)
        if (!try_again(pending, may_turn)) pending_[kept++] = pending;
      const bool is_stuck = kept == pending_.size();
      pending_.resize(kept);
      if (!is_stuck) continue;
      if (!may_turn) {
        round = kTurningRound - 1;
        continue;
      }
      if (++stalls > kStalls) break;
      for (Pending& pending : pending_) clip_again(pending);
    }
  }

  bool has_tests_left() const { return closing_.tests < max_tests_; }
  void count_tests(std::int64_t tests) {
    closing_.tests += tests;
    since_poll_ += tests;
    if (since_poll_ < kPollInterval) return;
    since_poll_ = 0;
    progress_.update(1.0 - static_cast<double>(pending_.size()) / static_cast<double>(given_));
  }

  Box box_around(Index v) const {
    Box box = boxes_.box_of(mesh_.position, {v, v, v});
    mesh_.for_each_outgoing(v, [&](Index h) {
      const Index u = mesh_.target(h);
      box = joined(box, boxes_.box_of(mesh_.position, {u, u, u}));
    });
    return box;
  }

  // All that decides on a trial touches a corner of the ring or lies in the box of the ring.
  bool is_as_before(const Pending& pending, std::uint32_t time) {
    return time != Pending::kNever && !changes_.has_changed(pending.box, time);
  }
  bool try_again(Pending& pending, bool may_turn) {
    if (may_turn == pending.could_turn && is_as_before(pending, pending.tried)) return false;
    if (!has_tests_left()) return false;
    ++closing_.trials;
    if (try_remove(pending.vertex, may_turn)) return true;
    pending.box = box_around(pending.vertex);
    pending.tried = changes_.now();
    pending.could_turn = may_turn;
    return false;
  }
  void clip_again(Pending& pending) {
    if (is_as_before(pending, pending.clipped)) return;
    if (!has_tests_left()) return;
    clip_ears(pending.vertex);
    pending.clipped = changes_.now();
  }

  bool try_remove(Index v, bool may_turn) {
    rating_.gather(mesh_, v);
    count_tests(static_cast<std::int64_t>(rating_.halfedges().size()));
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
      count_tests(static_cast<std::int64_t>(rating_.halfedges().size()));
      if (!has_tests_left()) return false;
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
    std::size_t first = 0;  // the one after the apex
    bool is_whole = true;
    for (const Index h : rating_.halfedges()) {
      replaced_.push_back(SurfaceMesh::face(h));
      const Index p = mesh_.target(h), q = mesh_.opposite(h);
      if (p == apex) first = fresh_.size();
      if (p == apex || q == apex) continue;
      if (is_open_[SurfaceMesh::face(h)])
        is_whole = false;
      else
        fresh_.push_back({apex, p, q});
    }
    std::rotate(fresh_.begin(), fresh_.begin() + static_cast<std::ptrdiff_t>(first), fresh_.end());
    return fresh_cuts(is_whole && is_surely_flat_fan(), cuts_);
  }

  bool flip_cuts(Index h) {
    const Index o = mesh_.twin(h);
    const Index a = mesh_.origin(h), b = mesh_.origin(o), c = mesh_.opposite(h),
                d = mesh_.opposite(o);
    fresh_ = {{d, c, a}, {c, d, b}};
    replaced_ = {SurfaceMesh::face(h), SurfaceMesh::face(o)};
    return fresh_cuts(false, 0);
  }

  // Whether there is a plane in which the fresh faces, each sharing an edge with the next, lie side
  // by side around their first corner: then none of them meets another. The margin is above what
  // rounding can do to the products.
  bool is_surely_flat_fan() const {
    constexpr double kMargin = 1e-13;
    if (fresh_.size() < 2) return true;
    const Vec3& apex = mesh_.position[fresh_.front()[0]];
    Vec3 normal = Vec3::Zero();
    for (const Triangle& t : fresh_)
      normal += (mesh_.position[t[1]] - apex).cross(mesh_.position[t[2]] - apex);
    normal = unit_or_zero(normal);
    if (!(normal.squaredNorm() > 0.5)) return false;
    const Vec3 across = normal.unitOrthogonal(), up = normal.cross(across);
    struct Ray {
      double x, y, length;
    };
    const auto ray_to = [&](Index v) {
      const Vec3 d = mesh_.position[v] - apex;
      return Ray{d.dot(across), d.dot(up), d.norm()};
    };
    const auto side = [&](const Ray& a, const Ray& b) {  // 1: b is left of a; 0: not sure
      const double cross = a.x * b.y - a.y * b.x, margin = kMargin * a.length * b.length;
      return cross > margin ? 1 : cross < -margin ? -1 : 0;
    };
    const Ray first = ray_to(fresh_.front()[1]);
    Ray last = first;
    bool is_past_half = false;
    for (const Triangle& t : fresh_) {
      const Ray next = ray_to(t[2]);
      const int from_first = side(first, next);
      if (side(last, next) != 1 || from_first == 0) return false;
      if (from_first > 0 && is_past_half) return false;  // once around
      is_past_half = from_first < 0;
      last = next;
    }
    return true;
  }

  // Whether the fresh faces form more pairs than are allowed with each other, unless it is known
  // that they form none, or with any that stays but those that they replace. True also if the tests
  // do not suffice to find out.
  bool fresh_cuts(bool are_apart, Index most) {
    std::sort(replaced_.begin(), replaced_.end());
    const auto is_gone = [&](Index f) {
      return mesh_.is_removed_face(f) || is_open_[f] ||
             std::binary_search(replaced_.begin(), replaced_.end(), f);
    };
    const auto spend = [&](std::int64_t tests) {
      count_tests(tests);
      return has_tests_left();
    };
    return count_fresh_cuts(mesh_, boxes_, pairs_, fresh_, are_apart, most, is_gone, spend) > most;
  }

  void collapse(Index halfedge) {
    changes_.mark(box_around(mesh_.origin(halfedge)));
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
    const std::vector<char>& spans = closing_.spans;
    if (!spans[first] || !spans[second] || !mesh_.is_flip_legal(h) || flip_cuts(h)) return false;
    mesh_.flip(h);
    const Box first_box = boxes_.box_of(mesh_.position, mesh_.triangle(first)),
              second_box = boxes_.box_of(mesh_.position, mesh_.triangle(second));
    boxes_.set_box(first, first_box);
    boxes_.set_box(second, second_box);
    changes_.mark(joined(first_box, second_box));
    return true;
  }

  // Takes edges from a vertex that no collapse removes: its ring may be no fan from any corner.
  // Each flip cuts an ear off the ring; those of the shortest diagonals come first.
  void clip_ears(Index v) {
    for (bool has_clipped = true; has_clipped;) {
      has_clipped = false;
      rating_.gather(mesh_, v);
      count_tests(static_cast<std::int64_t>(rating_.halfedges().size()));
      ears_.clear();
      for (const Index h : rating_.halfedges()) {
        const Vec3 diagonal =
            mesh_.position[mesh_.opposite(h)] - mesh_.position[mesh_.opposite(mesh_.twin(h))];
        ears_.push_back({diagonal.squaredNorm(), h, mesh_.target(h)});
      }
      std::sort(ears_.begin(), ears_.end());
      std::size_t valence = ears_.size();
      for (const auto& [length, h, corner] : ears_)
        if (valence > 3 && mesh_.origin(h) == v && mesh_.target(h) == corner && try_flip(h)) {
          has_clipped = true;
          --valence;
        }
    }
  }

  SurfaceMesh& mesh_;
  Index first_extra_;
  Progress& progress_;
  TrianglePairs pairs_;
  BoxTree boxes_;               // of the faces as they are
  std::vector<char> is_open_;   // per face slot: it is dropped at the end, and in nobody's way
  Index most_cuts_, cuts_ = 0;  // allowed for a removal, at last and at present
  std::vector<Pending> pending_;
  std::size_t given_ = 0;  // of these, at first
  ChangeMap changes_;
  std::int64_t max_tests_, since_poll_ = 0;
  Closing closing_;
  CollapseRating rating_;
  std::vector<Triangle> fresh_;  // faces that an operation would make ...
  std::vector<Index> replaced_;  // ... in place of these
  std::vector<Index> stack_;
  std::vector<char> ring_;                              // is_open_ of the faces around a vertex
  std::vector<std::pair<double, Index>> targets_;       // length of a half-edge
  std::vector<std::tuple<double, Index, Index>> ears_;  // length of the diagonal, half-edge, corner
};

// The same faces once a mesh was renumbered, ascending, but for those that are gone.
std::vector<Index> renumbered(const std::vector<Index>& faces, const std::vector<Index>& new_face) {
  std::vector<Index> found;
  for (const Index f : faces)
    if (new_face[f] != kNone) found.push_back(new_face[f]);
  sort_unique(found);
  return found;
}

}  // namespace

Closing close_openings(SurfaceMesh& mesh, Index first_extra, Progress& progress,
                       const std::vector<Index>& opening_faces, const ClosingOptions& options) {
  return OpeningCloser(mesh, first_extra, opening_faces, options, progress).close();
}

ClosingOfMatching close_openings(CompleteMatching& matching, Index samples, Progress& progress,
                                 const ClosingOptions& options) {
  SurfaceMesh& mesh = matching.mesh;
  const Closing closing = close_openings(mesh, samples, progress, matching.opening_faces, options);
  // Samples keep their index. Of the extra vertices only those that go change places.
  std::vector<Index> new_index(mesh.position.size(), kNone), removed;
  Index count = 0;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.is_removed_vertex(v))
      removed.push_back(v);
    else
      new_index[v] = count++;
  }
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (closing.spans[f]) matching.spanning_faces.push_back(f);
  const std::vector<Index> new_face = mesh.renumber(new_index, progress);
  matching.spanning_faces = renumbered(matching.spanning_faces, new_face);
  matching.opening_faces = renumbered(matching.opening_faces, new_face);
  matching.sample_of_vertex.resize(mesh.position.size(), SampleId::none);
  return {std::move(removed), closing.tests};
}

}  // namespace shrinkwrap
