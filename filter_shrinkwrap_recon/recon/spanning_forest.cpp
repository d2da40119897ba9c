#include "spanning_forest.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "parallel.h"

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

// The bucket of an edge: the heaviest come first.
int bucket_of(const PointCloud& cloud, Index a, Index b) {
  const Vec3f d = (cloud.position[a] - cloud.position[b]).cast<float>();
  const Vec3f &n = cloud.normal[a], &m = cloud.normal[b];
  const float length = d.norm();
  const float across =
      length > 0.0f ? std::max(std::abs(d.dot(n)), std::abs(d.dot(m))) / length : 0.0f;
  const float weight = std::abs(n.dot(m)) * (1.0f - across);
  return std::clamp(static_cast<int>((1.0f - weight) * kBuckets), 0, kBuckets - 1);
}

struct Edge {
  Index a, b;
};

// The edges of one block of samples. Of those within the block only a spanning forest is kept: in
// the order of weights the others would not join anything in the whole either.
class BlockEdges {
 public:
  BlockEdges(const PointCloud& cloud, int neighbours, Index begin, Index end)
      : begin_(begin), end_(end) {
    const std::size_t expected = static_cast<std::size_t>(end - begin) * neighbours * 2 / 3;
    edge_.reserve(expected);
    bucket_.reserve(expected);
    for (Index a = begin; a < end; ++a) {
      const Index* list = cloud.neighbours_of(a);
      for (int place = 1; place <= neighbours; ++place) {
        const Index b = list[place];
        const Index* back = cloud.neighbours_of(b);
        if (b < a && std::find(back + 1, back + 1 + neighbours, a) != back + 1 + neighbours)
          continue;  // b has it in its own list
        edge_.push_back({a, b});
        bucket_.push_back(static_cast<std::uint16_t>(bucket_of(cloud, a, b)));
      }
    }
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
std::vector<Edge> sorted_edges(const PointCloud& cloud, int neighbours, Progress& progress) {
  const Index count = cloud.size();
  const auto blocks = static_cast<std::size_t>(block_count(count, kGrain));
  std::vector<std::vector<Edge>> edges(blocks);
  std::vector<std::vector<std::uint16_t>> bucket_of_edge(blocks);
  std::vector<std::array<std::size_t, kBuckets>> offset(blocks);
  parallel_blocks(count, kGrain, progress, [&](Index block, Index begin, Index end) {
    BlockEdges(cloud, neighbours, begin, end).move_to(edges[block], bucket_of_edge[block]);
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
  SignedForest(const PointCloud& cloud, const SignOptions& options)
      : cloud_(cloud), options_(options), sets_(cloud.size()) {}

  // Joins all that the edges connect; with votes, as they say where they are clear.
  void join(const std::vector<Edge>& edges, const SampleVotes* votes, Progress& progress) {
    if (votes) {
      tally_.assign(cloud_.position.size(), Tally());
      for (std::size_t k = 0; k < votes->drawn.size(); ++k)
        tally_[votes->drawn[k]] = {static_cast<float>(votes->votes[k].outward),
                                   static_cast<float>(votes->votes[k].possible), 1};
    }
    Index sets_left = cloud_.size();
    for (std::size_t begin = 0; begin < edges.size() && sets_left > 1; begin += kUnionsPerUpdate) {
      const std::size_t end = std::min(begin + kUnionsPerUpdate, edges.size());
      for (std::size_t e = begin; e < end; ++e) sets_left -= join(edges[e]);
      progress.update(static_cast<double>(end) / static_cast<double>(edges.size()));
    }
  }

  std::uint32_t find(Index i) { return sets_.find(i); }
  bool has_followed_views() const { return has_followed_views_; }

 private:
  struct Tally {
    float outward = 0.0f, possible = 0.0f;
    Index drawn = 0;
  };

  bool join(const Edge& edge) {
    const std::uint32_t a = sets_.find(edge.a), b = sets_.find(edge.b);
    if (a >> 1 == b >> 1) return false;
    bool opposed = cloud_.normal[edge.a].dot(cloud_.normal[edge.b]) < 0.0f;
    if (!tally_.empty()) {
      Tally &tally_a = tally_[a >> 1], &tally_b = tally_[b >> 1];
      const bool are_roots_opposed = opposed != ((a & 1) != (b & 1));
      const bool agree = (tally_a.outward * tally_b.outward < 0.0f) == are_roots_opposed;
      if (!agree && is_clear(tally_a) && is_clear(tally_b) && is_doubtful(edge)) {
        opposed = !opposed;
        has_followed_views_ = true;
      }
      const float sign = opposed != ((a & 1) != (b & 1)) ? -1.0f : 1.0f;
      Tally& root = a < b ? tally_a : tally_b;
      const Tally& other = a < b ? tally_b : tally_a;
      root = {root.outward + sign * other.outward, root.possible + other.possible,
              root.drawn + other.drawn};
    }
    sets_.join(a, b, opposed);
    return true;
  }
  bool is_clear(const Tally& tally) const {
    return tally.drawn >= options_.least_samples &&
           std::abs(tally.outward) > options_.least_majority * tally.possible;
  }
  bool is_doubtful(const Edge& edge) const {
    return bucket_of(cloud_, edge.a, edge.b) > (1.0 - options_.greatest_weight) * kBuckets;
  }

  const PointCloud& cloud_;
  const SignOptions& options_;
  SignedSets sets_;
  std::vector<Tally> tally_;  // by root; empty without votes
  bool has_followed_views_ = false;
};

}  // namespace

SpanningForest span_normals(const PointCloud& cloud, int neighbours, const SampleVotes& votes,
                            const SignOptions& options, Progress& progress) {
  const Index count = cloud.size();
  neighbours = std::clamp(neighbours, 1, cloud.neighbour_count - 1);
  const std::vector<Edge> edges = sorted_edges(cloud, neighbours, progress);
  SignedForest by_edges(cloud, options), by_views(cloud, options);
  by_views.join(edges, &votes, progress);
  const bool do_views_object = by_views.has_followed_views();
  if (do_views_object) by_edges.join(edges, nullptr, progress);
  SpanningForest forest;
  forest.component_of_sample.resize(static_cast<std::size_t>(count));
  forest.flipped.resize(static_cast<std::size_t>(count));
  if (do_views_object) forest.flipped_by_views.resize(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    const std::uint32_t root = by_views.find(i);
    const Index first = static_cast<Index>(root >> 1);  // the lowest sample of its set
    if (do_views_object) forest.flipped_by_views[i] = static_cast<char>(root & 1);
    forest.flipped[i] = static_cast<char>((do_views_object ? by_edges.find(i) : root) & 1);
    forest.component_of_sample[i] =
        first == i ? forest.components++ : forest.component_of_sample[first];
  }
  return forest;
}

}  // namespace shrinkwrap
