#include "inverted_patches.h"

#include <algorithm>
#include <cmath>

#include "parallel.h"
#include "sort_unique.h"
#include "winding_number.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr std::size_t kPollInterval = 1 << 12;
constexpr int kMostSweeps = 8;  // over the samples at the edge of a patch

double is_off_by(double winding_number) {
  return std::abs(winding_number - 0.5);
}

class InvertedPatches {
 public:
  InvertedPatches(PointCloud& cloud, const NeighbourGraph& graph, const SampleVotes& votes,
                  const InvertedPatchOptions& options, Progress& progress)
      : cloud_(cloud), graph_(graph), votes_(votes), options_(options), progress_(progress) {}

  Index turn() {
    const std::vector<Index> hidden = hidden_samples();
    if (hidden.empty()) return 0;
    const WindingNumber winding(cloud_, progress_);
    std::vector<char> is_off(hidden.size());
    parallel_for_each(static_cast<Index>(hidden.size()), kGrain, progress_,
                      [&](Index k) { is_off[k] = this->is_off(winding, hidden[k]); });
    visited_.assign(cloud_.position.size(), 0);
    settled_ = turned_ = visited_;
    std::vector<Patch> patches;
    for (std::size_t k = 0; k < hidden.size(); ++k) {
      if (!is_off[k] || visited_[hidden[k]]) continue;
      Patch patch = patch_around(winding, hidden[k]);
      if (static_cast<Index>(patch.size()) >= options_.least_samples && turn(patch))
        patches.push_back(std::move(patch));
    }
    return patches.empty() ? 0 : keep_right_ones(winding, patches);
  }

 private:
  using Patch = std::vector<Index>;  // samples

  std::vector<Index> hidden_samples() const {
    std::vector<Index> hidden;
    for (std::size_t k = 0; k < votes_.drawn.size(); ++k)
      if (votes_.votes[k].seen < options_.least_seen * votes_.votes[k].possible)
        hidden.push_back(votes_.drawn[k]);
    return hidden;
  }
  double winding_at(const WindingNumber& winding, Index sample) const {
    return winding.at(cloud_.position[sample]);
  }
  bool is_off(const WindingNumber& winding, Index sample) const {
    return is_off_by(winding_at(winding, sample)) > options_.most_off;
  }

  // Samples like this one that are connected with it, ascending.
  Patch patch_around(const WindingNumber& winding, Index seed) {
    Patch patch = {seed};
    visited_[seed] = 1;
    for (std::size_t next = 0; next < patch.size(); ++next) {
      if (next % kPollInterval == 0) progress_.update(0.0);
      graph_.for_each_neighbour_of(patch[next], [&](Index other) {
        if (visited_[other]) return;
        visited_[other] = 1;
        if (is_off(winding, other)) patch.push_back(other);
      });
    }
    std::sort(patch.begin(), patch.end());
    return patch;
  }

  // How much more of the edges of a sample say that it looks to the right side than object, by the
  // fourth power of how sure they are; or, if `only_objections`, those that object.
  double consent(Index sample, bool only_objections) const {
    double sum = 0.0;
    graph_.for_each_neighbour_of(sample, [&](Index other) {
      const double agreement = graph_.agreement(sample, other);
      const bool objects = (agreement < 0.0) != (turned_[sample] != turned_[other]);
      const double squared = agreement * agreement;
      if (objects || !only_objections) sum += (objects ? -1.0 : 1.0) * squared * squared;
    });
    return sum;
  }
  double objections(const Patch& samples) const {
    double sum = 0.0;
    for (const Index sample : samples) sum -= consent(sample, true);
    return sum;
  }
  Patch with_neighbours(Patch samples) const {
    const std::size_t count = samples.size();
    for (std::size_t i = 0; i < count; ++i)
      graph_.for_each_neighbour_of(samples[i], [&](Index other) { samples.push_back(other); });
    sort_unique(samples);
    return samples;
  }

  // Turns a patch, and has those at its edge follow their neighbours. False, and nothing is turned,
  // if edges object; else the patch is what was turned.
  bool turn(Patch& patch) {
    std::vector<Index> changed = patch;
    for (const Index sample : patch) turned_[sample] = 1;
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      std::vector<Index> next;
      for (const Index sample : with_neighbours(changed))
        if (!settled_[sample] && consent(sample, false) < 0.0) {
          turned_[sample] = !turned_[sample];
          next.push_back(sample);
        }
      if (next.empty()) break;
      changed = next;
      patch.insert(patch.end(), next.begin(), next.end());
      sort_unique(patch);
    }
    patch.erase(
        std::remove_if(patch.begin(), patch.end(), [&](Index sample) { return !turned_[sample]; }),
        patch.end());
    const Patch around = with_neighbours(patch);
    const double then = objections(around);
    for (const Index sample : patch) turned_[sample] = 0;
    if (then > options_.most_objections * objections(around)) return false;
    for (const Index sample : patch) turned_[sample] = settled_[sample] = 1;
    return true;
  }

  // Turns the normals, but for patches where the winding numbers are not right then.
  Index keep_right_ones(const WindingNumber& before, const std::vector<Patch>& patches) {
    std::vector<signed char> sign(cloud_.position.size());
    for (std::size_t i = 0; i < sign.size(); ++i) sign[i] = turned_[i] ? -1 : 1;
    const WindingNumber after(cloud_, sign, progress_);
    Index count = 0;
    for (const Patch& patch : patches) {
      double off_before = 0.0, off_after = 0.0;
      for (const Index sample : patch) {
        off_before += is_off_by(winding_at(before, sample));
        off_after += is_off_by(winding_at(after, sample));
      }
      if (off_after > options_.most_left * off_before) continue;
      for (const Index sample : patch) cloud_.normal[sample] = -cloud_.normal[sample];
      count += static_cast<Index>(patch.size());
    }
    return count;
  }

  PointCloud& cloud_;
  const NeighbourGraph& graph_;
  const SampleVotes& votes_;
  const InvertedPatchOptions& options_;
  Progress& progress_;
  std::vector<char> visited_;           // samples that patches were looked for at
  std::vector<char> turned_, settled_;  // by the patch that is tried, or by one before
};

}  // namespace

Index turn_inverted_patches(PointCloud& cloud, const NeighbourGraph& graph,
                            const SampleVotes& votes, const InvertedPatchOptions& options,
                            Progress& progress) {
  return InvertedPatches(cloud, graph, votes, options, progress).turn();
}

}  // namespace shrinkwrap
