#include "orientation/inverted_patches.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "orientation/winding_number.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr std::size_t kPollInterval = 1 << 12;

class InvertedPatches {
 public:
  InvertedPatches(PointCloud& cloud, const NeighbourGraph& graph, const SampleVotes& votes,
                  const InvertedPatchOptions& options, Progress& progress)
      : cloud_(cloud), graph_(graph), votes_(votes), options_(options), progress_(progress) {}

  Index turn() {
    find();
    drop_those_that_do_not_come_right();
    Index count = 0;
    for (const Patch& patch : patches_) {
      for (const Index sample : patch.samples) cloud_.normal[sample] = -cloud_.normal[sample];
      count += static_cast<Index>(patch.samples.size());
    }
    return count;
  }

 private:
  struct Patch {
    std::vector<Index> samples;
    double distance;  // of their winding numbers from 1/2, the sum
  };

  // Fills in the patches that may be turned, no sample in two of them.
  void find();
  std::vector<Index> hidden_samples() const;
  Patch patch_around(const WindingNumber& winding, Index seed);
  bool do_edges_object(const Patch& patch);
  void drop_those_that_do_not_come_right();
  double objections(const std::vector<Index>& samples) const;

  double distance_from_half(const WindingNumber& winding, Index sample) const {
    return std::abs(winding.at(cloud_.position[sample]) - 0.5);
  }
  void mark(const Patch& patch, char is_turned) {
    for (const Index sample : patch.samples) turned_[sample] = is_turned;
  }

  PointCloud& cloud_;
  const NeighbourGraph& graph_;
  const SampleVotes& votes_;
  const InvertedPatchOptions& options_;
  Progress& progress_;
  std::vector<Patch> patches_;
  std::vector<char> visited_;  // samples that patches were looked for at
  std::vector<char> turned_;   // the samples of `patches_`
};

void InvertedPatches::find() {
  const std::vector<Index> hidden = hidden_samples();
  if (hidden.empty()) return;
  const WindingNumber winding(cloud_, progress_);
  std::vector<char> is_seed(hidden.size());
  parallel_for_each(static_cast<Index>(hidden.size()), kGrain, progress_, [&](Index k) {
    is_seed[k] = distance_from_half(winding, hidden[k]) > options_.most_off;
  });
  visited_.assign(cloud_.position.size(), 0);
  turned_ = visited_;
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    if (!is_seed[k] || visited_[hidden[k]]) continue;
    Patch patch = patch_around(winding, hidden[k]);
    if (static_cast<Index>(patch.samples.size()) < options_.least_samples) continue;
    mark(patch, 1);
    if (do_edges_object(patch))
      mark(patch, 0);
    else
      patches_.push_back(std::move(patch));
  }
}

std::vector<Index> InvertedPatches::hidden_samples() const {
  std::vector<Index> hidden;
  for (std::size_t k = 0; k < votes_.drawn.size(); ++k)
    if (votes_.votes[k].seen < options_.least_seen * votes_.votes[k].possible)
      hidden.push_back(votes_.drawn[k]);
  return hidden;
}

// A sample and those like it, hidden or not, that are connected with it.
InvertedPatches::Patch InvertedPatches::patch_around(const WindingNumber& winding, Index seed) {
  Patch patch{{seed}, distance_from_half(winding, seed)};
  visited_[seed] = 1;
  for (std::size_t next = 0; next < patch.samples.size(); ++next) {
    if (next % kPollInterval == 0) progress_.update(0.0);
    graph_.for_each_neighbour_of(patch.samples[next], [&](Index other) {
      if (visited_[other]) return;
      visited_[other] = 1;
      const double distance = distance_from_half(winding, other);
      if (!(distance > options_.most_off)) return;
      patch.samples.push_back(other);
      patch.distance += distance;
    });
  }
  return patch;
}

// How surely the edges of samples say that they look to the wrong side: the sum of the fourth
// powers of those that do.
double InvertedPatches::objections(const std::vector<Index>& samples) const {
  return parallel_sum(static_cast<Index>(samples.size()), kGrain, progress_, 0.0,
                      [&](Index begin, Index end) {
                        double sum = 0.0;
                        for (Index k = begin; k < end; ++k) {
                          const Index a = samples[k];
                          graph_.for_each_neighbour_of(a, [&](Index b) {
                            const double weight = edge_weight(graph_.agreement(a, b));
                            if ((weight < 0.0) != (turned_[a] != turned_[b]))
                              sum += std::abs(weight);
                          });
                        }
                        return sum;
                      });
}

// Pre: the patch is marked as turned.
bool InvertedPatches::do_edges_object(const Patch& patch) {
  std::vector<Index> around = patch.samples;
  for (const Index sample : patch.samples)
    graph_.for_each_neighbour_of(sample, [&](Index other) { around.push_back(other); });
  sort_unique(around);
  const double after = objections(around);
  mark(patch, 0);
  const double before = objections(around);
  mark(patch, 1);
  return after > options_.most_objections * before;
}

// Those that are dropped change the winding numbers of the others.
void InvertedPatches::drop_those_that_do_not_come_right() {
  for (std::size_t count = patches_.size() + 1; !patches_.empty() && count > patches_.size();) {
    count = patches_.size();
    std::vector<signed char> sign(cloud_.position.size());
    for (std::size_t i = 0; i < sign.size(); ++i) sign[i] = turned_[i] ? -1 : 1;
    const WindingNumber winding(cloud_, sign, progress_);
    const auto comes_right = [&](const Patch& patch) {
      const double distance = parallel_sum(static_cast<Index>(patch.samples.size()), kGrain,
                                           progress_, 0.0, [&](Index begin, Index end) {
                                             double sum = 0.0;
                                             for (Index k = begin; k < end; ++k)
                                               sum += distance_from_half(winding, patch.samples[k]);
                                             return sum;
                                           });
      return distance <= options_.most_left * patch.distance;
    };
    std::vector<Patch> right;
    for (Patch& patch : patches_) {
      if (comes_right(patch))
        right.push_back(std::move(patch));
      else
        mark(patch, 0);
    }
    patches_ = std::move(right);
  }
}

}  // namespace

Index turn_inverted_patches(PointCloud& cloud, const NeighbourGraph& graph,
                            const SampleVotes& votes, const InvertedPatchOptions& options,
                            Progress& progress) {
  if (graph.noise() > options.most_noise) return 0;
  return InvertedPatches(cloud, graph, votes, options, progress).turn();
}

}  // namespace shrinkwrap
