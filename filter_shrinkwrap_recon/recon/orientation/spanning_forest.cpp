#include "orientation/spanning_forest.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 14;
constexpr int kBuckets = 1 << 11;
constexpr Index kUnionsPerUpdate = 1 << 16;

// Union-find in which every element knows its sign against its root (the parity of the path).
class SignedSets {
 public:
  explicit SignedSets(Index count) : link_(static_cast<std::size_t>(count)) {
    for (Index i = 0; i < count; ++i) link_[i] = static_cast<std::uint32_t>(i) << 1;
  }
  // Twice the root of i, plus 1 if i is flipped against it. Halves the path.
  std::uint32_t find(Index i) {
    std::uint32_t at = static_cast<std::uint32_t>(i) << 1;
    for (;;) {
      const std::uint32_t up = link_[at >> 1];
      if (up >> 1 == at >> 1) return at;
      const std::uint32_t further = link_[up >> 1] ^ (up & 1);
      link_[at >> 1] = further;
      at = further ^ (at & 1);
    }
  }
  // Joins two sets, given what `find` said of an element of each, so that these two are of one sign
  // or, if `opposed`, of opposite signs. The lower root stays.
  void join(std::uint32_t root_a, std::uint32_t root_b, bool opposed) {
    if (root_a < root_b) std::swap(root_a, root_b);
    link_[root_a >> 1] = root_b ^ (root_a & 1) ^ static_cast<std::uint32_t>(opposed);
  }

 private:
  std::vector<std::uint32_t> link_;  // twice the parent, plus 1 if opposed to it
};

// The bucket of an edge: the surest come first.
int bucket_of(float agreement) {
  const float weight = std::abs(agreement);
  return std::clamp(static_cast<int>((1.0f - weight) * kBuckets), 0, kBuckets - 1);
}

struct Edge {
  Index a, b;
};

// The edges of one block of samples. Of those within the block only a spanning forest is kept: in
// the order of weights the others would join nothing in the whole either, unless views object to
// one that is kept.
class BlockEdges {
 public:
  BlockEdges(const NeighbourGraph& graph, Index begin, Index end) : begin_(begin), end_(end) {
    const std::size_t expected = static_cast<std::size_t>(end - begin) * graph.neighbours() * 2 / 3;
    edge_.reserve(expected);
    bucket_.reserve(expected);
    for (Index a = begin; a < end; ++a)
      graph.for_each_edge_of(a, [&](Index b) {
        edge_.push_back({a, b});
        bucket_.push_back(static_cast<std::uint16_t>(bucket_of(graph.agreement(a, b))));
      });
    keep_forest();
  }

  // Appends the edges that are kept, in the order in which they were found.
  void move_to(std::vector<Edge>& edges, std::vector<std::uint16_t>& buckets) const {
    for (std::size_t e = 0; e < edge_.size(); ++e) {
      if (!kept_[e]) continue;
      edges.push_back(edge_[e]);
      buckets.push_back(bucket_[e]);
    }
  }

 private:
  void keep_forest() {
    std::array<Index, kBuckets + 1> cursor = {};
    for (const std::uint16_t bucket : bucket_) ++cursor[bucket + 1];
    for (int bucket = 0; bucket < kBuckets; ++bucket) cursor[bucket + 1] += cursor[bucket];
    std::vector<Index> order(edge_.size());
    for (std::size_t e = 0; e < edge_.size(); ++e)
      order[cursor[bucket_[e]]++] = static_cast<Index>(e);
    kept_.assign(edge_.size(), 0);
    SignedSets sets(end_ - begin_);
    for (const Index e : order) {
      const auto [a, b] = edge_[e];
      if (b < begin_ || b >= end_) {
        kept_[e] = 1;
        continue;
      }
      const std::uint32_t root_a = sets.find(a - begin_), root_b = sets.find(b - begin_);
      if (root_a >> 1 == root_b >> 1) continue;
      sets.join(root_a, root_b, false);
      kept_[e] = 1;
    }
  }

  Index begin_, end_;
  std::vector<Edge> edge_;
  std::vector<std::uint16_t> bucket_;
  std::vector<char> kept_;
};

// The edges that a spanning forest of the greatest weight may have, each once, sorted by bucket,
// then by index.
std::vector<Edge> sorted_edges(const NeighbourGraph& graph, Progress& progress) {
  const Index count = graph.sample_count();
  const auto blocks = static_cast<std::size_t>(block_count(count, kGrain));
  std::vector<std::vector<Edge>> edges(blocks);
  std::vector<std::vector<std::uint16_t>> bucket_of_edge(blocks);
  std::vector<std::array<std::size_t, kBuckets>> offset(blocks);
  parallel_blocks(count, kGrain, progress, [&](Index block, Index begin, Index end) {
    BlockEdges(graph, begin, end).move_to(edges[block], bucket_of_edge[block]);
    offset[block].fill(0);
    for (const std::uint16_t bucket : bucket_of_edge[block]) ++offset[block][bucket];
  });
  std::size_t sum = 0;
  for (int bucket = 0; bucket < kBuckets; ++bucket)
    for (auto& histogram : offset) {
      const std::size_t in_block = histogram[bucket];
      histogram[bucket] = sum;
      sum += in_block;
    }
  std::vector<Edge> sorted(sum);
  parallel_for_each(static_cast<Index>(blocks), 1, progress, [&](Index block) {
    for (std::size_t e = 0; e < edges[block].size(); ++e)
      sorted[offset[block][bucket_of_edge[block][e]]++] = edges[block][e];
    edges[block] = {};
    bucket_of_edge[block] = {};
  });
  return sorted;
}

// The sets that edges join, and what the views say of each, against the normal of its root.
class SignedForest {
 public:
  SignedForest(const NeighbourGraph& graph, const SampleVotes& votes, const SignOptions& options)
      : graph_(graph),
        options_(options),
        contact_agreement_(static_cast<float>(options.contact_agreement) * (1.0f - graph.noise())),
        set_count_(graph.sample_count()),
        sets_(graph.sample_count()),
        tally_(static_cast<std::size_t>(graph.sample_count())) {
    for (std::size_t k = 0; k < votes.drawn.size(); ++k)
      tally_[votes.drawn[k]] = {static_cast<float>(votes.votes[k].outward),
                                static_cast<float>(votes.votes[k].possible), 1, 1};
  }

  // Joins what the edges connect, unless they are mere contacts. Edges to which the views object
  // are not followed if there is a place to put them.
  void join(const Edge* begin, const Edge* end, std::vector<Edge>* objected, Progress& progress) {
    for (const Edge* edge = begin; edge != end && set_count_ > 1; ++edge) {
      if ((edge - begin) % kUnionsPerUpdate == 0)
        progress.update(static_cast<double>(edge - begin) / static_cast<double>(end - begin));
      join(*edge, objected);
    }
  }

  // The sets as they are, numbered in order of lowest sample.
  SignedPatches sets() {
    SignedPatches patches;
    const Index count = graph_.sample_count();
    patches.patch_of_sample.resize(static_cast<std::size_t>(count));
    patches.flipped.resize(static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
      const std::uint32_t root = sets_.find(i);
      const Index first = static_cast<Index>(root >> 1);  // the lowest sample of its set
      patches.flipped[i] = static_cast<char>(root & 1);
      patches.patch_of_sample[i] = first == i ? patches.count++ : patches.patch_of_sample[first];
    }
    return patches;
  }

 private:
  struct Tally {
    float outward = 0.0f, possible = 0.0f;
    Index drawn = 0, samples = 1;
  };

  void join(const Edge& edge, std::vector<Edge>* objected) {
    const std::uint32_t a = sets_.find(edge.a), b = sets_.find(edge.b);
    if (a >> 1 == b >> 1) return;
    const float agreement = graph_.agreement(edge.a, edge.b);
    const bool opposed = agreement < 0.0f;
    const bool are_roots_opposed = opposed != ((a & 1) != (b & 1));
    const Tally tally_a = tally_[a >> 1], tally_b = tally_[b >> 1];
    if (std::abs(agreement) < contact_agreement_ && is_large(tally_a) && is_large(tally_b)) return;
    const bool do_views_agree = (tally_a.outward * tally_b.outward < 0.0f) == are_roots_opposed;
    if (objected && !do_views_agree && is_clear(tally_a) && is_clear(tally_b)) {
      objected->push_back(edge);
      return;
    }
    const Tally& root = a < b ? tally_a : tally_b;
    const Tally& other = a < b ? tally_b : tally_a;
    tally_[std::min(a, b) >> 1] = {
        root.outward + (are_roots_opposed ? -other.outward : other.outward),
        root.possible + other.possible, root.drawn + other.drawn, root.samples + other.samples};
    sets_.join(a, b, opposed);
    --set_count_;
  }
  bool is_large(const Tally& tally) const { return tally.samples >= options_.contact_samples; }
  bool is_clear(const Tally& tally) const {
    return tally.drawn >= options_.least_samples &&
           std::abs(tally.outward) > options_.least_majority * tally.possible;
  }

  const NeighbourGraph& graph_;
  const SignOptions& options_;
  const float contact_agreement_;
  Index set_count_;
  SignedSets sets_;
  std::vector<Tally> tally_;  // by root
};

}  // namespace

SpanningForest span_normals(const NeighbourGraph& graph, const SampleVotes& votes,
                            const SignOptions& options, Progress& progress) {
  const std::vector<Edge> edges = sorted_edges(graph, progress);
  const Edge* const first = edges.data();
  const Edge* const last = first + edges.size();
  const Edge* const doubtful = std::partition_point(first, last, [&](const Edge& edge) {
    return bucket_of(graph.agreement(edge.a, edge.b)) < (1.0 - options.patch_agreement) * kBuckets;
  });
  SignedForest sets(graph, votes, options);
  std::vector<Edge> objected;
  sets.join(first, doubtful, &objected, progress);
  const SignedPatches patches = sets.sets();
  sets.join(objected.data(), objected.data() + objected.size(), nullptr, progress);
  sets.join(doubtful, last, nullptr, progress);
  SignedPatches components = sets.sets();

  SpanningForest forest;
  if (patches.count > components.count) {
    SampleVotes trusted = votes;
    trusted.weigh_by_trust(components.patch_of_sample, components.count);
    const std::vector<float> signs =
        agreed_signs(graph, patches, trusted, options.vote_weight, progress);
    forest.flipped_as_agreed.resize(patches.patch_of_sample.size());
    for (Index i = 0; i < graph.sample_count(); ++i) {
      const float sign = signs[patches.patch_of_sample[i]];
      forest.flipped_as_agreed[i] =
          sign == 0.0f ? components.flipped[i]
                       : static_cast<char>((sign < 0.0f) != (patches.flipped[i] != 0));
    }
  }
  forest.component_of_sample = std::move(components.patch_of_sample);
  forest.flipped = std::move(components.flipped);
  forest.components = components.count;
  return forest;
}

}  // namespace shrinkwrap
