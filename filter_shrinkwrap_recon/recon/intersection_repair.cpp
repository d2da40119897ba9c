#include "intersection_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "box_tree.h"
#include "exact_predicates.h"
#include "self_intersection.h"
#include "triangle_pair.h"

namespace shrinkwrap {
namespace {

// No face is made whose height is a smaller part of its longest edge, unless one was there.
constexpr double kLeastHeight = 1e-3;
// The same where two flips do not help: samples a thousandth of an edge apart leave but needles.
constexpr double kLeastHeightAtLast = 1e-5;
// Unfolding by a smaller part is no reason to flip.
constexpr double kLeastUnfolding = 1e-3;
// Pairs that the first of several flips may add.
constexpr Index kMaxDetour = 2;
constexpr std::int64_t kLeastTrials = 50000;
// Tests of pairs of triangles are bounded too: where all faces of a heap meet each other, one trial
// takes thousands, and with coordinates of very different size each is slow.
constexpr std::int64_t kLeastTests = 1000000;
constexpr std::int64_t kTestsPerFace = 20;
constexpr Index kPollInterval = 8;

// What is tried in turn, the next where the one before is of no avail.
struct Attempt {
  int look_ahead;     // flips that are tried together
  bool folds_freely;  // without the fold guard
  double least_height = kLeastHeight;
};
constexpr Attempt kAttempts[] = {{1, false},
                                 {2, false},
                                 {1, true},
                                 {2, true},
                                 {1, true, kLeastHeightAtLast},
                                 {2, true, kLeastHeightAtLast},
                                 {3, true},
                                 {4, true}};

// By face slot: removed faces have no valid index, so that trees and tests leave them out.
std::vector<Triangle> slot_triangles(const SurfaceMesh& mesh) {
  std::vector<Triangle> triangles(mesh.face_slots());
  for (Index f = 0; f < mesh.face_slots(); ++f) triangles[f] = mesh.triangle(f);
  return triangles;
}

// The two triangles at an edge, or the two that a flip would make of them.
using Hinge = std::array<Triangle, 2>;

struct HingeShape {
  double bending = 0.0;       // sum of length x (1 - cosine of the angle of normals), five edges
  double sharpest = 1.0;      // least of these cosines
  double least_height = 1.0;  // of a triangle, as a part of its longest edge
};

// Unit normal; zero for a degenerate triangle.
Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double length = normal.norm();
  return length > 0.0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

double relative_height(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest > 0.0 ? (b - a).cross(c - a).norm() / longest : 0.0;
}

class Repair {
 public:
  Repair(SurfaceMesh& mesh, const RepairOptions& options, Progress& progress,
         const std::vector<Index>& fixed_faces)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        fixed_faces_(fixed_faces),
        test_(mesh.position) {}

  RepairReport run();

 private:
  using Pair = std::pair<Index, Index>;

  Hinge hinge_at(Index h) const {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    return {{{a, b, mesh_.opposite(h)}, {b, a, mesh_.opposite(mesh_.twin(h))}}};
  }
  Hinge flipped_hinge_at(Index h) const {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    const Index c = mesh_.opposite(h), d = mesh_.opposite(mesh_.twin(h));
    return {{{d, c, a}, {c, d, b}}};
  }

  // Calls `fn(g)` for each face but two that a triangle meets.
  template <class Fn>
  void for_each_met(const Triangle& t, Index skip_f, Index skip_g, const Fn& fn) const {
    tree_.for_each_overlap(tree_.box_of(mesh_.position, t), [&](Index g) {
      --tests_left_;
      if (g != skip_f && g != skip_g && test_.meet(t, mesh_.triangle(g))) fn(g);
    });
  }

  // Pairs that one or both triangles of a hinge are in, if they replace the faces at the edge h.
  Index count_pairs(Index h, const Hinge& hinge) const {
    Index count = test_.meet(hinge[0], hinge[1]) ? 1 : 0;
    for (const Triangle& t : hinge)
      for_each_met(t, SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h)),
                   [&](Index) { ++count; });
    return count;
  }

  HingeShape shape_of(Index h, const Hinge& hinge) const;
  bool is_allowed(Index h, const Hinge& then, HingeShape& shape_now, HingeShape& shape_then) const;
  // The flip keeps the mesh a manifold and touches no fixed face.
  bool may_flip(Index h) const {
    const auto is_fixed = [&](Index f) {
      return std::binary_search(fixed_faces_.begin(), fixed_faces_.end(), f);
    };
    return mesh_.is_flip_legal(h) && !is_fixed(SurfaceMesh::face(h)) &&
           !is_fixed(SurfaceMesh::face(mesh_.twin(h)));
  }
  bool has_time() const { return trials_left_ > 0 && tests_left_ > 0; }
  bool flip_if_better(Index h);
  void unfold(const std::vector<Index>& faces);
  bool flip_together(Index h, int count, Index pairs_lost);

  void flip(Index h) {
    mesh_.flip(h);
    update_boxes(h);
  }
  void flip_back(Index h) {
    // A quarter turn four times is no turn.
    for (int i = 0; i < 3; ++i) mesh_.flip(h);
    update_boxes(h);
  }
  void update_boxes(Index h) {
    for (Index f : {SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h))})
      tree_.set_box(f, tree_.box_of(mesh_.position, mesh_.triangle(f)));
  }
  void keep(Index h) {
    ++flips_;
    touched_.push_back(SurfaceMesh::face(h));
    touched_.push_back(SurfaceMesh::face(mesh_.twin(h)));
  }

  std::vector<Pair> pairs_of(std::vector<Index> faces) const;
  std::vector<Index> edges_near(std::vector<Index> faces, int rings) const;

  SurfaceMesh& mesh_;
  const RepairOptions& options_;
  Progress& progress_;
  const std::vector<Index>& fixed_faces_;  // ascending
  TrianglePairs test_;
  BoxTree tree_;
  double fold_guard_ = 0.0;
  double least_height_ = kLeastHeight;
  std::vector<Index> touched_;  // faces that flips changed in this round
  Index flips_ = 0;
  std::int64_t trials_left_ = 0;
  mutable std::int64_t tests_left_ = 0;  // of pairs of triangles
};

HingeShape Repair::shape_of(Index h, const Hinge& hinge) const {
  const auto& p = mesh_.position;
  HingeShape shape;
  Vec3 normal[2];
  for (int side = 0; side < 2; ++side) {
    const Triangle& t = hinge[side];
    normal[side] = unit_normal(p[t[0]], p[t[1]], p[t[2]]);
    shape.least_height = std::min(shape.least_height, relative_height(p[t[0]], p[t[1]], p[t[2]]));
  }
  const auto bend = [&](Index a, Index b, double cosine) {
    shape.bending += (p[b] - p[a]).norm() * (1.0 - cosine);
    shape.sharpest = std::min(shape.sharpest, cosine);
  };
  bend(hinge[0][0], hinge[0][1], normal[0].dot(normal[1]));
  const Index o = mesh_.twin(h);
  for (Index outer :
       {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)}) {
    const Index a = mesh_.origin(outer), b = mesh_.target(outer), across = mesh_.twin(outer);
    // The triangle of the hinge that has this edge.
    const Triangle& first = hinge[0];
    const int side = (first[0] == a || first[1] == a || first[2] == a) &&
                             (first[0] == b || first[1] == b || first[2] == b)
                         ? 0
                         : 1;
    bend(a, b, normal[side].dot(unit_normal(p[b], p[a], p[mesh_.opposite(across)])));
  }
  return shape;
}

// Also fills in both shapes.
bool Repair::is_allowed(Index h, const Hinge& then, HingeShape& shape_now,
                        HingeShape& shape_then) const {
  shape_now = shape_of(h, hinge_at(h));
  shape_then = shape_of(h, then);
  if (shape_then.sharpest < std::min(fold_guard_, shape_now.sharpest)) return false;
  if (shape_then.least_height < std::min(least_height_, shape_now.least_height)) return false;
  const auto& p = mesh_.position;
  return std::all_of(then.begin(), then.end(), [&](const Triangle& t) {
    return projection_axis(p[t[0]], p[t[1]], p[t[2]]) != kNone;
  });
}

bool Repair::flip_if_better(Index h) {
  --trials_left_;
  const Index pairs_now = count_pairs(h, hinge_at(h));
  if (pairs_now == 0 || !may_flip(h)) return false;
  const Hinge then = flipped_hinge_at(h);
  HingeShape shape_now, shape_then;
  if (!is_allowed(h, then, shape_now, shape_then)) return false;
  const Index pairs_then = count_pairs(h, then);
  const bool unfolds = shape_then.bending < (1.0 - kLeastUnfolding) * shape_now.bending;
  if (pairs_then > pairs_now || (pairs_then == pairs_now && !unfolds)) return false;
  flip(h);
  keep(h);
  return true;
}

// Flips h and at most `count - 1` edges near it if that loses more pairs than it adds, counting
// `pairs_lost` by flips before. Otherwise leaves the mesh as it was.
bool Repair::flip_together(Index h, int count, Index pairs_lost) {
  --trials_left_;
  if (!has_time() || !may_flip(h)) return false;
  const Hinge then = flipped_hinge_at(h);
  HingeShape shape_now, shape_then;
  if (!is_allowed(h, then, shape_now, shape_then)) return false;
  pairs_lost += count_pairs(h, hinge_at(h)) - count_pairs(h, then);
  if (pairs_lost <= 0 && (count == 1 || pairs_lost < -kMaxDetour)) return false;
  flip(h);
  bool gains = pairs_lost > 0;
  if (!gains) {
    const Index o = mesh_.twin(h);
    std::array<Index, 12> near;
    std::size_t n = 0;
    for (Index outer :
         {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)}) {
      const Index across = mesh_.twin(outer);
      for (Index e : {outer, SurfaceMesh::next(across), SurfaceMesh::prev(across)}) near[n++] = e;
    }
    for (std::size_t i = 0; i < n && !gains; ++i)
      gains = flip_together(near[i], count - 1, pairs_lost);
  }
  if (gains)
    keep(h);
  else
    flip_back(h);
  return gains;
}

// Flips the edges of these faces at which the mesh folds beyond the guard if that makes the fold
// less sharp and adds no pair.
void Repair::unfold(const std::vector<Index>& faces) {
  for (Index h : edges_near(faces, 0)) {
    if (!may_flip(h)) continue;
    const Hinge now = hinge_at(h), then = flipped_hinge_at(h);
    HingeShape shape_now, shape_then;
    if (!is_allowed(h, then, shape_now, shape_then)) continue;
    if (shape_now.sharpest >= options_.fold_guard || shape_then.sharpest <= shape_now.sharpest ||
        count_pairs(h, then) > count_pairs(h, now))
      continue;
    flip(h);
    keep(h);
  }
}

// All pairs with one of these faces, ascending.
std::vector<Repair::Pair> Repair::pairs_of(std::vector<Index> faces) const {
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i % (1 << 12) == 0) progress_.update(0.0);
    const Index f = faces[i];
    for_each_met(mesh_.triangle(f), f, f, [&](Index g) { pairs.push_back(std::minmax(f, g)); });
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// Edges of these faces and of the rings of faces around them, one half-edge each, ascending.
std::vector<Index> Repair::edges_near(std::vector<Index> faces, int rings) const {
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<Index> vertices;
    for (Index f : faces)
      for (Index v : mesh_.triangle(f)) vertices.push_back(v);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    faces.clear();
    for (Index v : vertices)
      mesh_.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  }
  std::vector<Index> edges;
  for (Index f : faces)
    for (Index h = 3 * f; h < 3 * f + 3; ++h) edges.push_back(std::min(h, mesh_.twin(h)));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

RepairReport Repair::run() {
  progress_.set_range(0.0, 0.8);
  std::vector<Pair> pairs;
  {
    const std::vector<Triangle> triangles = slot_triangles(mesh_);
    tree_ = BoxTree(mesh_.position, triangles, progress_);
    pairs = self_intersections(tree_, test_, triangles, progress_);
  }
  std::vector<Index> faces = intersecting_faces(pairs);
  RepairReport report;
  report.before = static_cast<Index>(pairs.size());
  report.faces_before = static_cast<Index>(faces.size());
  if (pairs.empty()) return report;
  const std::int64_t max_trials =
      options_.max_trials > 0 ? options_.max_trials : kLeastTrials + mesh_.face_slots();
  trials_left_ = std::min(max_trials, options_.max_trials_per_face * report.faces_before);
  const std::int64_t max_tests = kLeastTests + kTestsPerFace * mesh_.face_slots();
  tests_left_ = max_tests;

  progress_.set_range(0.8, 1.0);
  std::vector<Index> changed;
  std::size_t attempt = 0;
  while (!pairs.empty() && report.rounds < options_.max_rounds && has_time()) {
    const double done = static_cast<double>(report.rounds) / options_.max_rounds;
    ++report.rounds;
    fold_guard_ = kAttempts[attempt].folds_freely ? -1.0 : options_.fold_guard;
    least_height_ = kAttempts[attempt].least_height;
    const int look_ahead = kAttempts[attempt].look_ahead;
    const std::vector<Index> edges = edges_near(faces, look_ahead > 1 ? 1 : 0);
    touched_.clear();
    for (std::size_t i = 0; i < edges.size() && has_time(); ++i) {
      if (i % kPollInterval == 0) progress_.update(done);
      if (look_ahead == 1)
        flip_if_better(edges[i]);
      else
        flip_together(edges[i], look_ahead, 0);
    }
    if (touched_.empty()) {
      do {
        ++attempt;
      } while (attempt < std::size(kAttempts) &&
               kAttempts[attempt].look_ahead > options_.max_look_ahead);
      if (attempt == std::size(kAttempts)) break;
      continue;
    }
    attempt = 0;
    changed.insert(changed.end(), touched_.begin(), touched_.end());
    faces.insert(faces.end(), touched_.begin(), touched_.end());
    pairs = pairs_of(faces);
    faces = intersecting_faces(pairs);
  }
  touched_.clear();
  least_height_ = kLeastHeight;
  unfold(changed);
  faces.insert(faces.end(), touched_.begin(), touched_.end());
  pairs = pairs_of(faces);
  faces = intersecting_faces(pairs);
  turn_outward(mesh_);
  progress_.set_range(0.0, 1.0);
  report.after = static_cast<Index>(pairs.size());
  report.faces_after = static_cast<Index>(faces.size());
  report.remaining_faces = std::move(faces);
  report.flips = flips_;
  report.tests = max_tests - tests_left_;
  return report;
}

}  // namespace

RepairReport repair_self_intersections(SurfaceMesh& mesh, const RepairOptions& options,
                                       Progress& progress, const std::vector<Index>& fixed_faces) {
  return Repair(mesh, options, progress, fixed_faces).run();
}

}  // namespace shrinkwrap
