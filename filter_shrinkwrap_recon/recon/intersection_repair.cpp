#include "intersection_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "exact_predicates.h"
#include "face_meetings.h"
#include "sample_relocation.h"
#include "sort_unique.h"
#include "triangle_geometry.h"

namespace shrinkwrap {
namespace {

// No face is made whose height is a smaller part of its longest edge, unless one was there.
constexpr double kLeastHeight = 1e-3;
// The same where two flips do not help: samples next to each other leave but needles.
constexpr double kLeastHeightAtLast = 1e-8;
// Unfolding by a smaller part is no reason to flip.
constexpr double kLeastUnfolding = 1e-3;
// Pairs that the first of several flips may add.
constexpr Index kMaxDetour = 2;
constexpr std::int64_t kLeastTrials = 50000;
// Tests of pairs of triangles are bounded too: where all faces of a heap meet each other, one trial
// takes thousands, and with coordinates of very different size each is slow.
constexpr std::int64_t kLeastTests = 1000000;
constexpr std::int64_t kTestsPerFace = 20;
constexpr std::int64_t kTrialsOfRelocation = 50;
constexpr Index kPollInterval = 8;

// What is tried in turn, the next where the one before is of no avail.
struct Attempt {
  int look_ahead;     // flips that are tried together; 0: a sample is relocated
  bool folds_freely;  // without the fold guard
  double least_height = kLeastHeight;
};
constexpr Attempt kAttempts[] = {{1, false},
                                 {0, true},
                                 {2, false},
                                 {1, true},
                                 {2, true},
                                 {1, true, kLeastHeightAtLast},
                                 {0, true, kLeastHeightAtLast},
                                 {2, true, kLeastHeightAtLast},
                                 {3, true},
                                 {4, true}};
constexpr std::size_t kAttemptCount = std::size(kAttempts);

// The two triangles at an edge, or the two that a flip would make of them.
using Hinge = std::array<Triangle, 2>;

struct HingeShape {
  double bending = 0.0;       // sum of length x (1 - cosine of the angle of normals), five edges
  double sharpest = 1.0;      // least of these cosines
  double least_height = 1.0;  // of a triangle, as a part of its longest edge
};

class Repair {
 public:
  Repair(SurfaceMesh& mesh, const RepairOptions& options, Progress& progress,
         const std::vector<Index>& fixed_faces)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        fixed_faces_(fixed_faces),
        meetings_(mesh, kLeastTests + kTestsPerFace * mesh.face_slots(), progress) {}

  RepairReport run();

 private:
  using Pair = FaceMeetings::Pair;

  static std::vector<Index> faces_at(Index h, const SurfaceMesh& mesh) {
    return {SurfaceMesh::face(h), SurfaceMesh::face(mesh.twin(h))};
  }
  Hinge hinge_at(Index h) const {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    return {{{a, b, mesh_.opposite(h)}, {b, a, mesh_.opposite(mesh_.twin(h))}}};
  }
  Hinge flipped_hinge_at(Index h) const {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    const Index c = mesh_.opposite(h), d = mesh_.opposite(mesh_.twin(h));
    return {{{d, c, a}, {c, d, b}}};
  }
  std::vector<Pair> pairs_at(Index h) const { return meetings_.pairs_of(faces_at(h, mesh_)); }
  // The pairs of a hinge if it replaces the faces at the edge h. False if they are more than `most`
  // or if that would take too long to find out.
  bool find_pairs(Index h, const Hinge& hinge, std::size_t most, std::vector<Pair>& pairs) const;

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
  bool has_time() const { return trials_left_ > 0 && meetings_.has_tests_left(); }
  void flip_if_better(Index h);
  bool flip_together(Index h, int count, std::ptrdiff_t pairs_lost);
  void relocate(Index v);
  void unfold(const std::vector<Index>& faces);

  // The faces at h have these pairs after the flip.
  void flip(Index h, const std::vector<Pair>& pairs) {
    mesh_.flip(h);
    update(h, pairs);
  }
  void update(Index h, const std::vector<Pair>& pairs) {
    meetings_.update_boxes(faces_at(h, mesh_));
    meetings_.replace(faces_at(h, mesh_), pairs);
  }
  void flip_back(Index h, const std::vector<Pair>& pairs) {
    mesh_.flip_back(h);
    update(h, pairs);
  }
  void keep(Index h) {
    ++flips_;
    touched_.push_back(SurfaceMesh::face(h));
    touched_.push_back(SurfaceMesh::face(mesh_.twin(h)));
  }

  void try_near(const Attempt& attempt, const std::vector<Index>& faces, double done);
  std::vector<Index> vertices_of(const std::vector<Index>& faces) const;
  std::vector<Index> faces_near(std::vector<Index> faces, int rings) const;
  std::vector<Index> edges_of(const std::vector<Index>& faces) const;
  std::vector<Index> affected_faces() const;

  SurfaceMesh& mesh_;
  const RepairOptions& options_;
  Progress& progress_;
  const std::vector<Index>& fixed_faces_;  // ascending
  FaceMeetings meetings_;
  double fold_guard_ = 0.0;
  double least_height_ = kLeastHeight;
  std::vector<Index> touched_;  // faces that changed in this round
  Index flips_ = 0, relocated_ = 0;
  std::int64_t trials_left_ = 0;
};

bool Repair::find_pairs(Index h, const Hinge& hinge, std::size_t most,
                        std::vector<Pair>& pairs) const {
  const std::vector<Index> faces = faces_at(h, mesh_);
  const auto skip = [&](Index g) { return g == faces[0] || g == faces[1]; };
  pairs.clear();
  if (meetings_.meet(hinge[0], hinge[1])) pairs.emplace_back(faces[0], faces[1]);
  for (std::size_t side = 0; side < 2; ++side)
    if (pairs.size() > most ||
        !meetings_.find(hinge[side], faces[side], most - pairs.size(), skip, pairs))
      return false;
  return true;
}

HingeShape Repair::shape_of(Index h, const Hinge& hinge) const {
  const auto& p = mesh_.position;
  const auto normal_of = [&](const Triangle& t) {
    return unit_or_zero((p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]));
  };
  HingeShape shape;
  Vec3 normal[2];
  for (int side = 0; side < 2; ++side) {
    const Triangle& t = hinge[side];
    normal[side] = normal_of(t);
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
    bend(a, b, normal[side].dot(normal_of({b, a, mesh_.opposite(across)})));
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

void Repair::flip_if_better(Index h) {
  --trials_left_;
  const std::size_t pairs_now = pairs_at(h).size();
  if (pairs_now == 0 || !may_flip(h)) return;
  const Hinge then = flipped_hinge_at(h);
  HingeShape shape_now, shape_then;
  if (!is_allowed(h, then, shape_now, shape_then)) return;
  const bool unfolds = shape_then.bending < (1.0 - kLeastUnfolding) * shape_now.bending;
  std::vector<Pair> pairs;
  if (!find_pairs(h, then, unfolds ? pairs_now : pairs_now - 1, pairs)) return;
  flip(h, pairs);
  keep(h);
}

// Flips h and at most `count - 1` edges near it if that loses more pairs than it adds, counting
// `pairs_lost` by flips before. Otherwise leaves the mesh as it was.
bool Repair::flip_together(Index h, int count, std::ptrdiff_t pairs_lost) {
  --trials_left_;
  if (!has_time() || !may_flip(h)) return false;
  const Hinge then = flipped_hinge_at(h);
  HingeShape shape_now, shape_then;
  if (!is_allowed(h, then, shape_now, shape_then)) return false;
  const std::vector<Pair> pairs_now = pairs_at(h);
  const std::ptrdiff_t most =
      pairs_lost + static_cast<std::ptrdiff_t>(pairs_now.size()) + (count > 1 ? kMaxDetour : -1);
  std::vector<Pair> pairs_then;
  if (most < 0 || !find_pairs(h, then, static_cast<std::size_t>(most), pairs_then)) return false;
  pairs_lost += static_cast<std::ptrdiff_t>(pairs_now.size()) -
                static_cast<std::ptrdiff_t>(pairs_then.size());
  flip(h, pairs_then);
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
    flip_back(h, pairs_now);
  return gains;
}

void Repair::relocate(Index v) {
  trials_left_ -= kTrialsOfRelocation;
  const std::vector<Index> changed =
      relocate_sample(mesh_, meetings_, v, fixed_faces_, least_height_);
  if (changed.empty()) return;
  ++relocated_;
  touched_.insert(touched_.end(), changed.begin(), changed.end());
}

// Flips the edges of these faces at which the mesh folds beyond the guard if that makes the fold
// less sharp and adds no pair.
void Repair::unfold(const std::vector<Index>& faces) {
  for (Index h : edges_of(faces)) {
    if (!may_flip(h)) continue;
    const Hinge then = flipped_hinge_at(h);
    HingeShape shape_now, shape_then;
    if (!is_allowed(h, then, shape_now, shape_then)) continue;
    if (shape_now.sharpest >= options_.fold_guard || shape_then.sharpest <= shape_now.sharpest)
      continue;
    std::vector<Pair> pairs;
    if (!find_pairs(h, then, pairs_at(h).size(), pairs)) continue;
    flip(h, pairs);
    keep(h);
  }
}

// The corners of these faces, ascending.
std::vector<Index> Repair::vertices_of(const std::vector<Index>& faces) const {
  std::vector<Index> vertices;
  for (Index f : faces)
    for (Index v : mesh_.triangle(f)) vertices.push_back(v);
  sort_unique(vertices);
  return vertices;
}

// These faces and the rings of faces around them, ascending.
std::vector<Index> Repair::faces_near(std::vector<Index> faces, int rings) const {
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<Index> vertices = vertices_of(faces);
    faces.clear();
    for (Index v : vertices)
      mesh_.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
    sort_unique(faces);
  }
  return faces;
}

// One half-edge each, ascending.
std::vector<Index> Repair::edges_of(const std::vector<Index>& faces) const {
  std::vector<Index> edges;
  for (Index f : faces)
    for (Index h = 3 * f; h < 3 * f + 3; ++h) edges.push_back(std::min(h, mesh_.twin(h)));
  sort_unique(edges);
  return edges;
}

// The faces around those that changed, and those that they meet, ascending.
std::vector<Index> Repair::affected_faces() const {
  std::vector<Index> faces = faces_near(touched_, 1);
  const std::size_t near = faces.size();
  for (std::size_t i = 0; i < near; ++i) {
    const std::vector<Index>& met = meetings_.faces_met_by(faces[i]);
    faces.insert(faces.end(), met.begin(), met.end());
  }
  sort_unique(faces);
  return faces;
}

// One pass of an attempt over the edges or corners of these faces.
void Repair::try_near(const Attempt& attempt, const std::vector<Index>& faces, double done) {
  fold_guard_ = attempt.folds_freely ? -1.0 : options_.fold_guard;
  least_height_ = attempt.least_height;
  const bool relocates = attempt.look_ahead == 0;
  const std::vector<Index> items =
      relocates ? vertices_of(faces) : edges_of(faces_near(faces, attempt.look_ahead > 1 ? 1 : 0));
  for (std::size_t i = 0; i < items.size() && has_time(); ++i) {
    if (i % kPollInterval == 0) progress_.update(done);
    if (relocates)
      relocate(items[i]);
    else if (attempt.look_ahead == 1)
      flip_if_better(items[i]);
    else
      flip_together(items[i], attempt.look_ahead, 0);
  }
}

RepairReport Repair::run() {
  std::vector<Index> faces = meetings_.faces();
  RepairReport report;
  report.before = meetings_.pair_count();
  report.faces_before = meetings_.faces_at_first();
  if (faces.empty()) return report;
  const std::int64_t max_trials =
      options_.max_trials > 0 ? options_.max_trials : kLeastTrials + mesh_.face_slots();
  trials_left_ = std::min(max_trials, options_.max_trials_per_face * report.faces_before);

  progress_.set_range(0.8, 1.0);
  std::vector<Index> changed;
  // Faces near which each attempt has not failed since something changed there.
  std::array<std::vector<Index>, kAttemptCount> pending;
  pending.fill(faces);
  while (report.rounds < options_.max_rounds && has_time()) {
    std::vector<Index> active;
    std::size_t attempt = 0;
    for (; attempt < kAttemptCount && active.empty(); ++attempt) {
      if (kAttempts[attempt].look_ahead > options_.max_look_ahead) continue;
      std::set_intersection(pending[attempt].begin(), pending[attempt].end(), faces.begin(),
                            faces.end(), std::back_inserter(active));
      pending[attempt].clear();
    }
    if (active.empty()) break;
    touched_.clear();
    try_near(kAttempts[attempt - 1], active,
             static_cast<double>(report.rounds) / options_.max_rounds);
    ++report.rounds;
    if (touched_.empty()) continue;
    changed.insert(changed.end(), touched_.begin(), touched_.end());
    faces = meetings_.faces();
    const std::vector<Index> affected = affected_faces();
    for (std::vector<Index>& waiting : pending) {
      std::vector<Index> both;
      std::set_union(waiting.begin(), waiting.end(), affected.begin(), affected.end(),
                     std::back_inserter(both));
      waiting = std::move(both);
    }
  }
  least_height_ = kLeastHeight;
  unfold(changed);
  turn_outward(mesh_);
  report.remaining_faces = meetings_.all_faces(progress_);
  report.after = meetings_.pair_count();
  report.faces_after = static_cast<Index>(report.remaining_faces.size());
  report.flips = flips_;
  report.relocated = relocated_;
  report.tests = meetings_.tests();
  progress_.set_range(0.0, 1.0);
  return report;
}

}  // namespace

RepairReport repair_self_intersections(SurfaceMesh& mesh, const RepairOptions& options,
                                       Progress& progress, const std::vector<Index>& fixed_faces) {
  progress.set_range(0.0, 0.8);
  return Repair(mesh, options, progress, fixed_faces).run();
}

}  // namespace shrinkwrap
