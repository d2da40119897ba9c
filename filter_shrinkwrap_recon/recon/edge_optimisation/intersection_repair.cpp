#include "edge_optimisation/intersection_repair.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <unordered_map>

#include "common/sort_unique.h"
#include "edge_optimisation/hinge_flips.h"
#include "edge_optimisation/patch_annealing.h"
#include "edge_optimisation/sample_relocation.h"
#include "mesh/face_meetings.h"
#include "mesh/face_patches.h"

namespace shrinkwrap {
namespace {

// No face is made whose height is a smaller part of its longest edge, unless one was there.
constexpr double kLeastHeight = 1e-3;
// The same where two flips do not help: samples next to each other leave but needles.
constexpr double kLeastHeightAtLast = 1e-8;
// Pairs that the first of several flips may add.
constexpr Index kMaxDetour = 2;
constexpr std::int64_t kLeastTrials = 50000;
// Tests of pairs of triangles are bounded too: where all faces of a heap meet each other, one trial
// takes thousands, and with coordinates of very different size each is slow.
constexpr std::int64_t kLeastTests = 1000000, kLeastTestsIfHopeless = 200000;
constexpr double kHopeless = 0.9;  // of all faces: if more meet others at first
constexpr std::int64_t kTestsPerFace = 20;
constexpr std::int64_t kTrialsOfRelocation = 50;
// Beside that there are moves of annealing, so many for each trial that is allowed for a face.
constexpr std::int64_t kMovesPerTrial = 20;
// Where all fails, and so little is left that each of its faces can have so many more moves (of so
// many times as many in all), it is annealed anew, and so often at most.
constexpr std::int64_t kMovesPerFaceLeft = 7000, kSpareMoves = 3, kMostSpareMoves = 500000;
constexpr AnnealingOptions::Seed kMostSeeds = 8;
constexpr Index kPollInterval = 8;

// What is tried in turn, the next where the one before is of no avail.
enum class Move { flips, relocation, annealing };
struct Attempt {
  Move move;
  int reach;          // flips that are tried together, or rings of faces around those annealed
  bool folds_freely;  // without the fold guard
  double least_height = kLeastHeight;
};
constexpr Attempt kAttempts[] = {{Move::flips, 1, false},
                                 {Move::relocation, 1, true},
                                 {Move::flips, 2, false},
                                 {Move::flips, 1, true},
                                 {Move::flips, 2, true},
                                 {Move::flips, 1, true, kLeastHeightAtLast},
                                 {Move::relocation, 1, true, kLeastHeightAtLast},
                                 {Move::flips, 2, true, kLeastHeightAtLast},
                                 {Move::annealing, 1, true},
                                 {Move::annealing, 2, true},
                                 {Move::annealing, 3, true}};
constexpr std::size_t kAttemptCount = std::size(kAttempts);
// Those that annealing insists with, by another seed each time.
constexpr std::size_t kInsistent[] = {kAttemptCount - 2, kAttemptCount - 1};

class Repair {
 public:
  Repair(SurfaceMesh& mesh, const RepairOptions& options, Progress& progress,
         const std::vector<Index>& opening_faces)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        opening_faces_(opening_faces),
        meetings_(mesh, kTestsPerFace * mesh.face_slots(), progress, opening_faces),
        hinges_(mesh, meetings_, opening_faces) {}

  RepairReport run(std::vector<Index>* spanning_faces, const ExtraVertices& extra);

 private:
  using Pair = HingeFlips::Pair;

  bool has_time() const { return trials_left_ > 0 && meetings_.has_tests_left(); }
  bool may_try(const Attempt& attempt) const {
    if (attempt.move == Move::annealing)
      return moves_left_ > 0 && attempt.reach <= options_.max_annealed_rings;
    return has_time() &&
           (attempt.move == Move::relocation || attempt.reach <= options_.max_look_ahead);
  }
  void part_faces(RepairReport& report);
  void flip_if_better(Index h);
  bool flip_together(Index h, int count, std::ptrdiff_t pairs_lost);
  void relocate(Index v);
  void anneal_near(const std::vector<Index>& faces, int rings, double done);
  void unfold(const std::vector<Index>& faces);

  void keep(Index h) {
    ++flips_;
    for (const Index f : {SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h))}) {
      touched_.push_back(f);
      changed_.push_back(f);
    }
  }

  void try_near(const Attempt& attempt, const std::vector<Index>& faces, double done);
  void note_change(const std::vector<Index>& faces);
  bool insist();
  std::vector<std::vector<Index>> changed_sets();
  std::vector<Index> affected_faces(const std::vector<Index>& touched) const;
  std::vector<Index> untried_faces() const;

  SurfaceMesh& mesh_;
  const RepairOptions& options_;
  Progress& progress_;
  const std::vector<Index>& opening_faces_;  // ascending
  FaceMeetings meetings_;
  HingeFlips hinges_;
  FlipLimits limits_{0.0, kLeastHeight};
  std::vector<Index> touched_;  // faces near which something changed in this round
  std::vector<Index> changed_;  // faces that did, in all rounds
  std::unordered_map<Index, std::vector<Index>> changed_with_;  // links of those that did at once
  Index flips_ = 0, relocated_ = 0, annealed_ = 0;
  std::int64_t trials_left_ = 0, moves_left_ = 0, spare_moves_ = 0;
  AnnealingOptions::Seed seed_ = 0;  // of annealing: another one each time that it insists
  Index faces_before_annealing_ = kNone;
  bool has_granted_ = false;  // tests for annealing
  bool ran_short_ = false;    // before
};

void Repair::flip_if_better(Index h) {
  --trials_left_;
  const std::ptrdiff_t pairs_now = hinges_.pair_count_at(h);
  if (pairs_now == 0) return;
  const auto most_pairs = [&](const HingeShape& now, const HingeShape& then) {
    return bends_less(then, now) ? pairs_now : pairs_now - 1;
  };
  if (hinges_.try_flip(h, limits_, most_pairs)) keep(h);
}

// Flips h and at most `count - 1` edges near it if that loses more pairs than it adds, counting
// `pairs_lost` by flips before. Otherwise leaves the mesh as it was.
bool Repair::flip_together(Index h, int count, std::ptrdiff_t pairs_lost) {
  --trials_left_;
  if (!has_time() || !hinges_.may_flip(h)) return false;
  const Hinge then = hinges_.flipped_hinge_at(h);
  HingeShape shape_now, shape_then;
  if (!hinges_.is_allowed(h, then, limits_, shape_now, shape_then)) return false;
  const std::vector<Pair> pairs_now = hinges_.pairs_at(h);
  const std::ptrdiff_t most =
      pairs_lost + static_cast<std::ptrdiff_t>(pairs_now.size()) + (count > 1 ? kMaxDetour : -1);
  std::vector<Pair> pairs_then;
  if (most < 0 || !hinges_.find_pairs(h, then, static_cast<std::size_t>(most), pairs_then))
    return false;
  pairs_lost += static_cast<std::ptrdiff_t>(pairs_now.size()) -
                static_cast<std::ptrdiff_t>(pairs_then.size());
  hinges_.flip(h, pairs_then);
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
    hinges_.flip_back(h, pairs_now);
  return gains;
}

void Repair::relocate(Index v) {
  trials_left_ -= kTrialsOfRelocation;
  const std::vector<Index> changed =
      relocate_sample(mesh_, meetings_, v, opening_faces_, {limits_.least_height});
  if (changed.empty()) return;
  ++relocated_;
  note_change(changed);
  touched_.insert(touched_.end(), changed.begin(), changed.end());
}

// The smallest patches first.
void Repair::anneal_near(const std::vector<Index>& faces, int rings, double done) {
  if (faces_before_annealing_ == kNone)
    faces_before_annealing_ = static_cast<Index>(meetings_.faces().size());
  if (faces_before_annealing_ > kMostMeeting * mesh_.face_count()) return;
  AnnealingOptions options = options_.annealing;
  options.moves_per_face *= rings;
  options.seed = seed_;
  if (seed_ > 0) options.moves_per_set_face = kMovesPerFaceLeft;
  const auto met_by = [&](Index f) -> const std::vector<Index>& {
    return meetings_.faces_met_by(f);
  };
  const std::vector<std::vector<Index>> clusters = clusters_of(mesh_, faces, met_by);
  if (!has_granted_) {
    const auto can_be_annealed = [&](const std::vector<Index>& cluster) {
      return !patch_around(hinges_, cluster, rings, options).empty();
    };
    if (std::none_of(clusters.begin(), clusters.end(), can_be_annealed)) return;
    has_granted_ = true;
    ran_short_ = !has_time();
    meetings_.grant(kTestsPerMove * moves_left_);
  }
  for (const AnnealedPatch& patch :
       anneal_around(hinges_, clusters, rings, limits_, options, moves_left_, progress_, done)) {
    ++annealed_;
    note_change(patch.changed);
    touched_.insert(touched_.end(), patch.faces.begin(), patch.faces.end());
  }
}

// Flips the edges of these faces at which the mesh folds beyond the guard if that makes the fold
// less sharp and adds no pair.
void Repair::unfold(const std::vector<Index>& faces) {
  for (Index h : edges_of(mesh_, faces)) {
    const auto most_pairs = [&](const HingeShape& now, const HingeShape& then) {
      const bool unfolds = now.sharpest < options_.fold_guard && then.sharpest > now.sharpest;
      return unfolds ? hinges_.pair_count_at(h) : -1;
    };
    if (hinges_.try_flip(h, limits_, most_pairs)) keep(h);
  }
}

// That these faces took each other's slots, wherever they are.
void Repair::note_change(const std::vector<Index>& faces) {
  for (const Index f : faces) {
    changed_.push_back(f);
    if (f == faces.front()) continue;
    changed_with_[f].push_back(faces.front());
    changed_with_[faces.front()].push_back(f);
  }
}

// The faces that changed, in sets that hang together, also over what changed at once.
std::vector<std::vector<Index>> Repair::changed_sets() {
  sort_unique(changed_);
  const std::vector<Index> none;
  return clusters_of(mesh_, changed_, [&](Index f) -> const std::vector<Index>& {
    const auto found = changed_with_.find(f);
    return found == changed_with_.end() ? none : found->second;
  });
}

// The faces around those that were touched, and those that they meet, ascending.
std::vector<Index> Repair::affected_faces(const std::vector<Index>& touched) const {
  std::vector<Index> faces = faces_near(mesh_, touched, 1);
  const std::size_t near = faces.size();
  for (std::size_t i = 0; i < near; ++i) {
    const std::vector<Index>& met = meetings_.faces_met_by(faces[i]);
    faces.insert(faces.end(), met.begin(), met.end());
  }
  sort_unique(faces);
  return faces;
}

// The faces that meet others but for those that were tried before and that nothing has changed
// near.
std::vector<Index> Repair::untried_faces() const {
  std::vector<Index> faces = meetings_.faces();
  if (options_.tried.empty()) return faces;
  const auto is_new = [&](Index f) {
    return !std::binary_search(options_.tried.begin(), options_.tried.end(),
                               ascending_corners(mesh_, f));
  };
  // Each star is looked at once, however large it is.
  std::vector<Index> changed = corners_of(mesh_, faces);
  const auto is_as_before = [&](Index v) {
    bool has_new = false;
    mesh_.for_each_outgoing(v, [&](Index h) { has_new |= is_new(SurfaceMesh::face(h)); });
    return !has_new;
  };
  changed.erase(std::remove_if(changed.begin(), changed.end(), is_as_before), changed.end());
  const auto was_tried = [&](Index f) {
    const Triangle t = mesh_.triangle(f);
    return std::none_of(t.begin(), t.end(), [&](Index v) {
      return std::binary_search(changed.begin(), changed.end(), v);
    });
  };
  faces.erase(std::remove_if(faces.begin(), faces.end(), was_tried), faces.end());
  return affected_faces(faces);
}

// One pass of an attempt over the edges or corners of these faces.
void Repair::try_near(const Attempt& attempt, const std::vector<Index>& faces, double done) {
  limits_ = {attempt.folds_freely ? -1.0 : options_.fold_guard, attempt.least_height};
  if (attempt.move == Move::annealing) {
    anneal_near(faces, attempt.reach, done);
    return;
  }
  const bool relocates = attempt.move == Move::relocation;
  const std::vector<Index> items =
      relocates ? corners_of(mesh_, faces)
                : edges_of(mesh_, faces_near(mesh_, faces, attempt.reach > 1 ? 1 : 0));
  for (std::size_t i = 0; i < items.size() && has_time(); ++i) {
    if (i % kPollInterval == 0) progress_.update(done);
    if (relocates)
      relocate(items[i]);
    else if (attempt.reach == 1)
      flip_if_better(items[i]);
    else
      flip_together(items[i], attempt.reach, 0);
  }
}

// Allows for annealing what is left by another seed. False if that is too much, or none is.
bool Repair::insist() {
  const std::int64_t moves =
      kMovesPerFaceLeft * static_cast<std::int64_t>(meetings_.faces().size());
  if (moves == 0 || moves > spare_moves_ || seed_ == kMostSeeds) return false;
  if (!has_granted_) ran_short_ = !has_time();
  has_granted_ = true;
  moves_left_ = moves;
  spare_moves_ -= moves;
  meetings_.grant(kTestsPerMove * moves);
  ++seed_;
  return true;
}

void Repair::part_faces(RepairReport& report) {
  std::vector<Index> faces = meetings_.faces();
  if (faces.empty()) return;
  meetings_.grant(report.faces_before > kHopeless * mesh_.face_count() ? kLeastTestsIfHopeless
                                                                       : kLeastTests);
  const std::int64_t max_trials =
      options_.max_trials > 0 ? options_.max_trials : kLeastTrials + mesh_.face_slots();
  trials_left_ = std::min(max_trials, options_.max_trials_per_face * report.faces_before);
  moves_left_ = std::min(most_moves(mesh_),
                         kMovesPerTrial * options_.max_trials_per_face * report.faces_before);
  const bool may_insist =
      options_.insists && may_try(kAttempts[kInsistent[0]]) && may_try(kAttempts[kInsistent[1]]);
  spare_moves_ = may_insist ? std::min(kSpareMoves * moves_left_, kMostSpareMoves) : 0;
  progress_.set_range(0.8, 1.0);
  std::vector<Index> changed;
  // Faces near which each attempt has not failed since something changed there.
  std::array<std::vector<Index>, kAttemptCount> pending;
  pending.fill(untried_faces());
  while (report.rounds < options_.max_rounds) {
    std::vector<Index> active;
    std::size_t attempt = 0;
    for (; attempt < kAttemptCount && active.empty(); ++attempt) {
      if (!may_try(kAttempts[attempt])) continue;
      std::set_intersection(pending[attempt].begin(), pending[attempt].end(), faces.begin(),
                            faces.end(), std::back_inserter(active));
      pending[attempt].clear();
    }
    if (active.empty()) {
      if (!insist()) break;
      pending[kInsistent[seed_ % 2]] = faces;
      continue;
    }
    touched_.clear();
    try_near(kAttempts[attempt - 1], active,
             static_cast<double>(report.rounds) / options_.max_rounds);
    ++report.rounds;
    if (touched_.empty()) continue;
    changed.insert(changed.end(), touched_.begin(), touched_.end());
    faces = meetings_.faces();
    const std::vector<Index> affected = affected_faces(touched_);
    for (std::vector<Index>& waiting : pending) {
      std::vector<Index> both;
      std::set_union(waiting.begin(), waiting.end(), affected.begin(), affected.end(),
                     std::back_inserter(both));
      waiting = std::move(both);
    }
  }
  limits_.least_height = kLeastHeight;
  unfold(changed);
}

RepairReport Repair::run(std::vector<Index>* spanning_faces, const ExtraVertices& extra) {
  RepairReport report;
  report.before = meetings_.pair_count();
  report.faces_before = meetings_.faces_at_first();
  part_faces(report);
  progress_.set_range(1.0, 1.0);
  const bool may_span = spanning_faces != nullptr && !spanning_faces->empty();
  if (may_span) restore_spanning_faces(mesh_, changed_sets(), extra, *spanning_faces);
  HingeFlips hinges_of_surface(mesh_, meetings_, may_span ? *spanning_faces : opening_faces_);
  report.folds = remove_folds(hinges_of_surface, options_.folds, progress_);
  report.remaining_faces = meetings_.all_faces(progress_);
  report.after = meetings_.pair_count();
  report.faces_after = static_cast<Index>(report.remaining_faces.size());
  report.faces_before_annealing = std::max(faces_before_annealing_, report.faces_after);
  report.flips = flips_;
  report.relocated = relocated_;
  report.annealed = annealed_;
  const bool was_cut_off =
      seed_ == 0 && (report.rounds == options_.max_rounds || (!has_granted_ && !has_time()));
  report.ran_short = ran_short_ || (report.faces_after > 0 && was_cut_off);
  report.tests = meetings_.tests();
  progress_.set_range(0.0, 1.0);
  return report;
}

}  // namespace

std::vector<Triangle> surroundings(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  std::vector<Triangle> around;
  for (const Index f : faces_near(mesh, faces, 1)) around.push_back(ascending_corners(mesh, f));
  std::sort(around.begin(), around.end());
  return around;
}

RepairReport repair_self_intersections(SurfaceMesh& mesh, const RepairOptions& options,
                                       Progress& progress, const std::vector<Index>& opening_faces,
                                       std::vector<Index>* spanning_faces,
                                       const ExtraVertices& extra) {
  progress.set_range(0.0, 0.8);
  return Repair(mesh, options, progress, opening_faces).run(spanning_faces, extra);
}

}  // namespace shrinkwrap
