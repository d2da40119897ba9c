#include "edge_optimisation/patch_annealing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "edge_optimisation/sample_relocation.h"
#include "geometry/triangle_geometry.h"
#include "mesh/face_patches.h"

namespace shrinkwrap {
namespace {

constexpr int kPollInterval = 256;
constexpr std::mt19937::result_type kSeedStride = 0x9e3779b9;  // far from any index of a face
constexpr int kMostPasses = 16;          // over the edges of a patch, to settle
constexpr std::size_t kMostAtOnce = 64;  // patches, annealed at the same time or waiting for it

class Annealing {
 public:
  Annealing(HingeFlips& hinges, const std::vector<Index>& patch, const FlipLimits& limits,
            const AnnealingOptions& options)
      : hinges_(hinges),
        mesh_(hinges.mesh()),
        meetings_(hinges.meetings()),
        patch_(patch),
        limits_(limits),
        options_(options),
        random_(static_cast<std::mt19937::result_type>(patch.front()) +
                kSeedStride * options.seed) {
    double length = 0.0;
    for (const Index f : patch)
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index v = mesh_.origin(h);
        vertices_.push_back(v);
        length += (mesh_.position[mesh_.target(h)] - mesh_.position[v]).norm();
      }
    bending_scale_ =
        options.bending_weight * static_cast<double>(3 * patch.size()) / std::max(length, 1e-300);
    sort_unique(vertices_);
  }

  bool run(std::int64_t& moves_left, Progress& progress, double stage_done) {
    if (is_bending_the_goal()) bending_ = bending_of_patch();
    const State at_first = state();
    State best = at_first;
    const std::int64_t moves = std::min<std::int64_t>(
        moves_left, static_cast<std::int64_t>(patch_.size()) * options_.moves_per_face);
    std::int64_t move = 0;
    for (; move < moves && meetings_.has_tests_left(); ++move) {
      if (move % kPollInterval == 0) progress.update(stage_done);
      const double done = static_cast<double>(move) / static_cast<double>(moves);
      temperature_ = options_.first_temperature +
                     done * (options_.last_temperature - options_.first_temperature);
      if (chance() < options_.relocations)
        relocate();
      else
        flip();
      if (!is_better_than(best, at_first.pair_count)) continue;
      best = state();
      if (!is_bending_the_goal() && best.pairs.empty()) break;
    }
    moves_left -= move;
    restore(best);
    if (!is_better_than(at_first, at_first.pair_count)) return false;
    settle();
    return true;
  }

 private:
  // The patch, to come back to.
  struct State {
    Index pair_count;                       // of the mesh
    double bending;                         // of the patch, if that is the goal
    std::vector<FaceMeetings::Pair> pairs;  // of the patch
    SurfaceMesh::Patch patch;
  };
  State state() const {
    return {meetings_.pair_count(), bending_, meetings_.pairs_of(patch_), mesh_.copy_patch(patch_)};
  }
  void restore(const State& state) {
    mesh_.restore_patch(state.patch);
    meetings_.update_boxes(patch_);
    meetings_.replace(patch_, state.pairs);
    bending_ = state.bending;
  }
  bool is_bending_the_goal() const {
    return options_.goal == AnnealingOptions::Goal::least_bending;
  }
  bool is_better_than(const State& best, Index most_pairs) const {
    if (!is_bending_the_goal()) return meetings_.pair_count() < best.pair_count;
    return meetings_.pair_count() <= most_pairs &&
           bending_ < (1.0 - options_.least_gain) * best.bending;
  }
  // As HingeShape has it, over all edges of the patch.
  double bending_of_patch() const {
    double sum = 0.0;
    for (const Index f : patch_) {
      const Vec3 normal = unit_or_zero(mesh_.area_vector(f));
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index across = SurfaceMesh::face(mesh_.twin(h));
        if (across < f && is_inside(across)) continue;  // counted there
        sum += (mesh_.position[mesh_.target(h)] - mesh_.position[mesh_.origin(h)]).norm() *
               (1.0 - normal.dot(unit_or_zero(mesh_.area_vector(across))));
      }
    }
    return sum;
  }

  // Even over [0, 1).
  double chance() { return static_cast<double>(random_()) / 4294967296.0; }
  template <class Item>
  const Item& any_of(const std::vector<Item>& items) {
    return items[static_cast<std::size_t>(chance() * static_cast<double>(items.size()))];
  }
  // By how much a change may raise the energy this time.
  double tolerance() { return -temperature_ * std::log(1.0 - chance()); }
  bool is_inside(Index f) const { return std::binary_search(patch_.begin(), patch_.end(), f); }

  void relocate() {
    const RelocationLimits limits = {limits_.least_height, static_cast<int>(tolerance()), &patch_};
    const std::vector<Index> changed =
        relocate_sample(mesh_, meetings_, any_of(vertices_), hinges_.fixed_faces(), limits);
    if (is_bending_the_goal() && !changed.empty()) bending_ = bending_of_patch();
  }

  template <class MostPairs>
  bool try_flip(Index h, const MostPairs& most_pairs) {
    return is_inside(SurfaceMesh::face(mesh_.twin(h))) && hinges_.try_flip(h, limits_, most_pairs);
  }

  void flip() {
    const Index face = any_of(patch_);  // by itself: the order of draws decides
    const Index h = 3 * face + static_cast<Index>(3.0 * chance());
    double added = 0.0;
    const auto most_pairs = [&](const HingeShape& now, const HingeShape& then) {
      added = then.bending - now.bending;
      return hinges_.pair_count_at(h) +
             static_cast<std::ptrdiff_t>(std::floor(tolerance() - bending_scale_ * added));
    };
    if (try_flip(h, most_pairs)) bending_ += added;
  }

  // Flips while that lowers the bending at no more pairs.
  void settle() {
    bool has_flipped = true;
    for (int pass = 0; pass < kMostPasses && has_flipped; ++pass) {
      has_flipped = false;
      for (const Index f : patch_)
        for (Index h = 3 * f; h < 3 * f + 3; ++h)
          has_flipped |= try_flip(h, [&](const HingeShape& now, const HingeShape& then) {
            return bends_less(then, now) ? hinges_.pair_count_at(h) : -1;
          });
    }
  }

  HingeFlips& hinges_;
  SurfaceMesh& mesh_;
  FaceMeetings& meetings_;
  const std::vector<Index>& patch_;
  const FlipLimits& limits_;
  const AnnealingOptions& options_;
  std::mt19937 random_;
  std::vector<Index> vertices_;  // of the patch, ascending
  double bending_scale_ = 0.0, temperature_ = 0.0;
  double bending_ = 0.0;  // of the patch, if that is the goal
};

}  // namespace

bool anneal_patch(HingeFlips& hinges, const std::vector<Index>& patch, const FlipLimits& limits,
                  const AnnealingOptions& options, std::int64_t& moves_left, Progress& progress,
                  double stage_done) {
  if (patch.empty()) return false;
  return Annealing(hinges, patch, limits, options).run(moves_left, progress, stage_done);
}

namespace {

// A patch that is annealed beside others.
struct Job {
  std::vector<Index> patch;
  std::int64_t moves;                    // that it may make; later, that are left of them
  std::vector<Triangle> before;          // its faces
  std::optional<FaceMeetings> meetings;  // of its own
  bool is_better = false;
};

// The next patches that can be annealed at the same time, and their moves, which are taken from
// `moves_left`. Those that have to wait, for others before them or for moves, stay in `sets`.
std::vector<Job> next_jobs(const HingeFlips& hinges, std::vector<const std::vector<Index>*>& sets,
                           int rings, const AnnealingOptions& options, std::int64_t& moves_left) {
  std::vector<Job> jobs;
  if (options.moves_per_face <= 0) return jobs;
  std::vector<BoxTree::Box> boxes;  // of the jobs, and of those that wait
  std::vector<const std::vector<Index>*> waiting;
  std::size_t i = 0;
  for (; i < sets.size() && boxes.size() < kMostAtOnce; ++i) {
    const std::vector<Index>& set = *sets[i];
    std::vector<Index> patch = patch_around(hinges, set, rings, options);
    if (patch.empty()) continue;
    std::int64_t moves = static_cast<std::int64_t>(patch.size()) * options.moves_per_face;
    if (options.moves_per_set_face > 0)
      moves = std::min(moves, options.moves_per_set_face * static_cast<std::int64_t>(set.size()));
    if (moves > moves_left && !jobs.empty()) break;  // the others may leave some of theirs
    const BoxTree::Box box = hinges.meetings().box_around(patch);
    const bool has_to_wait = std::any_of(boxes.begin(), boxes.end(), [&](const BoxTree::Box& b) {
      return BoxTree::overlap(b, box);
    });
    boxes.push_back(box);
    if (has_to_wait) {
      waiting.push_back(sets[i]);
      continue;
    }
    moves = std::min(moves, moves_left);
    moves_left -= moves;
    jobs.push_back({std::move(patch), moves, {}, std::nullopt});
  }
  waiting.insert(waiting.end(), sets.begin() + static_cast<std::ptrdiff_t>(i), sets.end());
  sets = std::move(waiting);
  return jobs;
}

}  // namespace

std::vector<Index> patch_around(const HingeFlips& hinges, const std::vector<Index>& set, int rings,
                                const AnnealingOptions& options) {
  const bool needs_pairs = options.goal == AnnealingOptions::Goal::fewest_pairs;
  if (set.size() > kLargestPatch || (needs_pairs && hinges.meetings().pairs_of(set).empty()))
    return {};
  std::vector<Index> patch = faces_near(hinges.mesh(), set, rings);
  if (patch.size() > kLargestPatch) patch.clear();
  return patch;
}

std::vector<AnnealedPatch> anneal_around(HingeFlips& hinges,
                                         const std::vector<std::vector<Index>>& sets, int rings,
                                         const FlipLimits& limits, const AnnealingOptions& options,
                                         std::int64_t& moves_left, Progress& progress,
                                         double stage_done) {
  SurfaceMesh& mesh = hinges.mesh();
  FaceMeetings& meetings = hinges.meetings();
  std::vector<const std::vector<Index>*> left;
  for (const std::vector<Index>& set : sets) left.push_back(&set);
  std::vector<AnnealedPatch> better;
  while (moves_left > 0 && meetings.has_tests_left()) {
    progress.update(stage_done);
    std::vector<Job> jobs = next_jobs(hinges, left, rings, options, moves_left);
    if (jobs.empty()) break;
    std::int64_t moves = 0;
    for (const Job& job : jobs) moves += job.moves;
    const std::int64_t tests = meetings.tests_left();
    Progress silent;  // what is done of the stage is told by the patches
    parallel_for_each(static_cast<Index>(jobs.size()), 1, silent, [&](Index i) {
      Job& job = jobs[static_cast<std::size_t>(i)];
      for (const Index f : job.patch) job.before.push_back(mesh.triangle(f));
      job.meetings.emplace(meetings, job.patch, tests * job.moves / moves);
      HingeFlips flips(mesh, *job.meetings, hinges.fixed_faces());
      job.is_better =
          anneal_patch(flips, job.patch, limits, options, job.moves, progress, stage_done);
    });
    for (Job& job : jobs) {
      moves_left += job.moves;
      meetings.take_over(job.patch, *job.meetings);
      if (!job.is_better) continue;
      std::vector<Index> changed;
      for (std::size_t i = 0; i < job.patch.size(); ++i)
        if (mesh.triangle(job.patch[i]) != job.before[i]) changed.push_back(job.patch[i]);
      better.push_back({std::move(job.patch), std::move(changed)});
    }
  }
  return better;
}

}  // namespace shrinkwrap
