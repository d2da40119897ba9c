#include "intersection_annealing.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "sample_relocation.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr int kPollInterval = 256;
constexpr int kMostPasses = 16;  // over the edges of a patch, to settle
// Bending less by a smaller part is no reason to flip.
constexpr double kLeastUnfolding = 1e-3;

class Annealing {
 public:
  Annealing(SurfaceMesh& mesh, FaceMeetings& meetings, HingeFlips& hinges,
            const std::vector<Index>& patch, const std::vector<Index>& fixed_faces,
            const FlipLimits& limits, const AnnealingOptions& options)
      : mesh_(mesh),
        meetings_(meetings),
        hinges_(hinges),
        patch_(patch),
        fixed_faces_(fixed_faces),
        limits_(limits),
        options_(options),
        random_(static_cast<std::mt19937::result_type>(patch.front())) {
    double length = 0.0;
    for (const Index f : patch)
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index v = mesh.origin(h);
        vertices_.push_back(v);
        length += (mesh.position[mesh.target(h)] - mesh.position[v]).norm();
      }
    bending_scale_ =
        options.bending_weight * static_cast<double>(3 * patch.size()) / std::max(length, 1e-300);
    sort_unique(vertices_);
  }

  bool run(std::int64_t& moves_left, Progress& progress, double stage_done) {
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
      if (meetings_.pair_count() >= best.pair_count) continue;
      best = state();
      if (best.pairs.empty()) break;
    }
    moves_left -= move;
    restore(best);
    if (best.pair_count == at_first.pair_count) return false;
    settle();
    return true;
  }

 private:
  // The patch, to come back to.
  struct State {
    Index pair_count;                       // of the mesh
    std::vector<FaceMeetings::Pair> pairs;  // of the patch
    SurfaceMesh::Patch patch;
  };
  State state() const {
    return {meetings_.pair_count(), meetings_.pairs_of(patch_), mesh_.copy_patch(patch_)};
  }
  void restore(const State& state) {
    mesh_.restore_patch(state.patch);
    meetings_.update_boxes(patch_);
    meetings_.replace(patch_, state.pairs);
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
    relocate_sample(mesh_, meetings_, any_of(vertices_), fixed_faces_, limits);
  }

  void flip() {
    const Index h = 3 * any_of(patch_) + static_cast<Index>(3.0 * chance());
    if (!is_inside(SurfaceMesh::face(mesh_.twin(h))) || !hinges_.may_flip(h)) return;
    const Hinge then = hinges_.flipped_hinge_at(h);
    HingeShape shape_now, shape_then;
    if (!hinges_.is_allowed(h, then, limits_, shape_now, shape_then)) return;
    const double most = tolerance() + static_cast<double>(hinges_.pairs_at(h).size()) -
                        bending_scale_ * (shape_then.bending - shape_now.bending);
    if (most >= 0.0 && hinges_.find_pairs(h, then, static_cast<std::size_t>(most), pairs_))
      hinges_.flip(h, pairs_);
  }

  // Flips while that lowers the bending at no more pairs.
  void settle() {
    bool has_flipped = true;
    for (int pass = 0; pass < kMostPasses && has_flipped; ++pass) {
      has_flipped = false;
      for (const Index f : patch_)
        for (Index h = 3 * f; h < 3 * f + 3; ++h) {
          if (!is_inside(SurfaceMesh::face(mesh_.twin(h))) || !hinges_.may_flip(h)) continue;
          const Hinge then = hinges_.flipped_hinge_at(h);
          HingeShape shape_now, shape_then;
          if (!hinges_.is_allowed(h, then, limits_, shape_now, shape_then) ||
              shape_then.bending >= (1.0 - kLeastUnfolding) * shape_now.bending ||
              !hinges_.find_pairs(h, then, hinges_.pairs_at(h).size(), pairs_))
            continue;
          hinges_.flip(h, pairs_);
          has_flipped = true;
        }
    }
  }

  SurfaceMesh& mesh_;
  FaceMeetings& meetings_;
  HingeFlips& hinges_;
  const std::vector<Index>& patch_;
  const std::vector<Index>& fixed_faces_;
  const FlipLimits& limits_;
  const AnnealingOptions& options_;
  std::mt19937 random_;
  std::vector<Index> vertices_;  // of the patch, ascending
  double bending_scale_ = 0.0, temperature_ = 0.0;
  std::vector<FaceMeetings::Pair> pairs_;  // of a flip; kept for its memory
};

}  // namespace

bool anneal_patch(SurfaceMesh& mesh, FaceMeetings& meetings, HingeFlips& hinges,
                  const std::vector<Index>& patch, const std::vector<Index>& fixed_faces,
                  const FlipLimits& limits, const AnnealingOptions& options,
                  std::int64_t& moves_left, Progress& progress, double stage_done) {
  if (patch.empty()) return false;
  return Annealing(mesh, meetings, hinges, patch, fixed_faces, limits, options)
      .run(moves_left, progress, stage_done);
}

}  // namespace shrinkwrap
