#include "geometry/coordinate_matches.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr int kPartitionBits = 10;
constexpr Index kPartitions = 1 << kPartitionBits;
constexpr Index kGrain = 1 << 14;
constexpr int kMaxBlocks = 64;

// Equal coordinates, equal hash; adding zero makes -0 equal to 0.
std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double coordinate = p[axis] + 0.0;
    std::uint64_t bits;
    std::memcpy(&bits, &coordinate, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32;
  }
  return hash * 0xd6e8feb86659fd93ull;
}

// Samples and vertices in one sequence, samples first.
class Points {
 public:
  Points(const std::vector<Vec3>& samples, const std::vector<Vec3>& vertices)
      : samples_(samples), vertices_(vertices) {}

  Index count() const { return sample_count() + static_cast<Index>(vertices_.size()); }
  bool is_sample(Index i) const { return i < sample_count(); }
  const Vec3& at(Index i) const {
    return is_sample(i) ? samples_[i] : vertices_[i - sample_count()];
  }

 private:
  Index sample_count() const { return static_cast<Index>(samples_.size()); }

  const std::vector<Vec3>& samples_;
  const std::vector<Vec3>& vertices_;
};

// What is partitioned: 32 bits of the hash in the high half, the point in the low half.
using HashedPoint = std::uint64_t;
Index point_of(HashedPoint hashed) {
  return static_cast<Index>(hashed & 0xffffffffu);
}

struct Partitions {
  std::vector<HashedPoint> hashed;
  std::vector<std::size_t> begin;  // of each partition, and the end
  Index not_finite = 0;            // vertices that are not
};

// Points of equal coordinates get into one partition. Two passes over fixed blocks: count, scatter.
Partitions partition(const Points& points, Progress& progress) {
  const Index count = points.count();
  const Index grain = std::max(kGrain, count / kMaxBlocks + 1);
  struct Block {
    std::array<std::size_t, kPartitions> cursor = {};
    Index not_finite = 0;
  };
  std::vector<Block> blocks(block_count(count, grain));
  const auto partition_of = [](std::uint64_t hash) { return hash >> (64 - kPartitionBits); };
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    Block& own = blocks[block];
    for (Index i = begin; i < end; ++i) {
      if (points.at(i).allFinite())
        ++own.cursor[partition_of(hash_of(points.at(i)))];
      else if (!points.is_sample(i))
        ++own.not_finite;
    }
  });
  Partitions result;
  std::size_t sum = 0;
  for (Index p = 0; p < kPartitions; ++p) {
    result.begin.push_back(sum);
    for (Block& block : blocks) {
      const std::size_t in_block = block.cursor[p];
      block.cursor[p] = sum;
      sum += in_block;
    }
  }
  result.begin.push_back(sum);
  for (const Block& block : blocks) result.not_finite += block.not_finite;
  result.hashed.resize(sum);
  parallel_blocks(count, grain, progress, [&](Index block, Index begin, Index end) {
    auto& cursor = blocks[block].cursor;
    for (Index i = begin; i < end; ++i) {
      if (!points.at(i).allFinite()) continue;
      const std::uint64_t hash = hash_of(points.at(i));
      result.hashed[cursor[partition_of(hash)]++] = hash << 32 | static_cast<std::uint32_t>(i);
    }
  });
  return result;
}

// Adds what lies at one place.
void tally(const Points& points, const HashedPoint* begin, const HashedPoint* end,
           CoordinateMatches& matches) {
  Index samples = 0, vertices = 0;
  for (const HashedPoint* i = begin; i != end; ++i)
    ++(points.is_sample(point_of(*i)) ? samples : vertices);
  if (samples == 0) {
    matches.extra += vertices;
    return;
  }
  ++matches.samples;
  ++(vertices == 0 ? matches.missing : vertices == 1 ? matches.matched : matches.matched_twice);
}

void tally_partition(const Points& points, HashedPoint* begin, HashedPoint* end,
                     CoordinateMatches& matches) {
  std::sort(begin, end);
  const auto less = [&](HashedPoint a, HashedPoint b) {
    return coordinates_less(points.at(point_of(a)), points.at(point_of(b)));
  };
  for (HashedPoint* run = begin; run != end;) {
    HashedPoint* run_end = run + 1;
    bool one_place = true;
    for (; run_end != end && *run_end >> 32 == *run >> 32; ++run_end)
      one_place &= !less(*run, *run_end) && !less(*run_end, *run);
    if (!one_place) std::sort(run, run_end, less);
    for (HashedPoint* place = run; place != run_end;) {
      HashedPoint* place_end = one_place ? run_end : std::upper_bound(place, run_end, *place, less);
      tally(points, place, place_end, matches);
      place = place_end;
    }
    run = run_end;
  }
}

}  // namespace

CoordinateMatches match_coordinates(const std::vector<Vec3>& samples,
                                    const std::vector<Vec3>& vertices, Progress& progress) {
  const Points points(samples, vertices);
  Partitions partitions = partition(points, progress);
  std::vector<CoordinateMatches> partial(kPartitions);
  HashedPoint* hashed = partitions.hashed.data();
  parallel_for_each(kPartitions, 8, progress, [&](Index p) {
    tally_partition(points, hashed + partitions.begin[p], hashed + partitions.begin[p + 1],
                    partial[p]);
  });
  CoordinateMatches matches;
  matches.extra = partitions.not_finite;
  for (const CoordinateMatches& part : partial) {
    matches.samples += part.samples;
    matches.matched += part.matched;
    matches.missing += part.missing;
    matches.matched_twice += part.matched_twice;
    matches.extra += part.extra;
  }
  return matches;
}

}  // namespace shrinkwrap
