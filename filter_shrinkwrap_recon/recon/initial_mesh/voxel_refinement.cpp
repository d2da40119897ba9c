#include "initial_mesh/voxel_refinement.h"

#include <algorithm>

#include "common/parallel.h"
#include "initial_mesh/voxel_boundary.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kSmallerVoxels = 0.5;
constexpr Index kLeastSamples = 50;  // of a part
constexpr double kDepth = 1.5;       // x spacing
// Parts of the dense samples that must agree with what smaller voxels show, and with more handles.
constexpr double kMost = 0.97, kNearlyAll = 0.995;
// Handles that show between fewer samples are gaps between these.
constexpr Index kSamplesPerHandle = 100;

bool is_uniform(BrickMask mask) {
  return mask == 0 || mask == kAllSolid;
}

// The mask of an octant of a brick whose voxels are cut in eight.
BrickMask halved(BrickMask mask, Index octant) {
  if (is_uniform(mask)) return mask;
  const auto half = [&](Index voxel, Index bit) { return (voxel >> 1) + 2 * (octant >> bit & 1); };
  BrickMask result = 0;
  for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
    const Voxel of{half(offset & 3, 0), half(offset >> 2 & 3, 1), half(offset >> 4, 2)};
    result |= (mask >> BrickIndex::offset_of(of) & 1) << offset;
  }
  return result;
}

class Refinement {
 public:
  Refinement(VoxelSolid& solid, const PointCloud& cloud, const WindingNumber& winding,
             const InitialMeshOptions& options)
      : solid_(solid), cloud_(cloud), winding_(winding), options_(options) {}

  Index run(Progress& progress) {
    mark_dense_parts(progress);
    if (parts_ == 0) return 0;
    make_well_composed(solid_.image, progress);
    solid_.near_samples.resize(solid_.image.mask.size(), 0);
    part_.resize(solid_.image.mask.size(), kNone);

    const VoxelSolid before = in_halves([&](Index brick) { return is_near_part(brick); });
    const VoxelSolid after = with_bricks_classified(
        before, bricks_of_parts(before.image.bricks),
        kSmallerVoxels * solid_.spacing / cloud_.spacing, cloud_, winding_, options_, progress);
    const std::vector<char> is_better = better_parts(before, after, progress);
    const Index taken = static_cast<Index>(std::count(is_better.begin(), is_better.end(), 1));
    if (taken == 0) return 0;
    VoxelSolid all = in_halves([](Index) { return true; });
    all.image.in_blocks.assign(all.image.mask.size(), 1);
    for (const Index brick : bricks_of_parts(all.image.bricks)) {
      const Voxel& at = all.image.bricks.brick(brick);
      if (!is_better[part_of(at)]) continue;
      const Index refined = after.image.bricks.find(at);
      all.image.mask[brick] = after.image.mask[refined];
      all.near_samples[brick] = after.near_samples[refined];
      all.image.in_blocks[brick] = 0;
    }
    solid_ = std::move(all);
    return taken;
  }

 private:
  std::vector<Index> dense_samples(Progress& progress) const {
    const std::vector<float> mean = mean_around(cloud_.local_spacing, progress);
    // Of samples at random some 20 may happen to be close, but not all around them too.
    const std::vector<float> wide_mean = mean_around(mean, progress);
    const float most = static_cast<float>(options_.dense_spacing * solid_.spacing);
    return parallel_collect<Index>(cloud_.size(), kGrain, progress,
                                   [&](Index begin, Index end, std::vector<Index>& dense) {
                                     for (Index i = begin; i < end; ++i)
                                       if (mean[i] < most && wide_mean[i] < most)
                                         dense.push_back(i);
                                   });
  }
  std::vector<float> mean_around(const std::vector<float>& spacing, Progress& progress) const {
    std::vector<float> mean(spacing.size());
    parallel_for_each(cloud_.size(), kGrain, progress, [&](Index i) {
      float sum = 0.0f;
      for (int e = 0; e < cloud_.neighbour_count; ++e) sum += spacing[cloud_.neighbours_of(i)[e]];
      mean[i] = sum / static_cast<float>(cloud_.neighbour_count);
    });
    return mean;
  }

  // Finds the bricks that dense samples reach, and numbers the sets of them that touch each other.
  void mark_dense_parts(Progress& progress) {
    dense_ = dense_samples(progress);
    if (static_cast<Index>(dense_.size()) < kLeastSamples) return;
    const BrickIndex& bricks = solid_.image.bricks;
    const Vec3 reach = Vec3::Constant(options_.blend_end * solid_.spacing);
    const auto brick_at = [&](const Vec3& p) {
      return BrickIndex::brick_of(solid_.lattice.voxel_of(p));
    };
    const std::vector<Index> reached = parallel_collect<Index>(
        static_cast<Index>(dense_.size()), kGrain, progress,
        [&](Index begin, Index end, std::vector<Index>& found) {
          Voxel last_low{}, last_high{};
          for (Index i = begin; i < end; ++i) {
            const Vec3& p = cloud_.position[dense_[i]];
            const Voxel low = brick_at(p - reach), high = brick_at(p + reach);
            if (i > begin && low == last_low && high == last_high) continue;
            last_low = low;
            last_high = high;
            for (Index z = low[2]; z <= high[2]; ++z)
              for (Index y = low[1]; y <= high[1]; ++y)
                for (Index x = low[0]; x <= high[0]; ++x) {
                  const Index brick = bricks.find({x, y, z});
                  if (brick != kNone) found.push_back(brick);
                }
          }
        });
    constexpr Index kUnnumbered = -2;
    part_.assign(solid_.image.mask.size(), kNone);
    for (const Index brick : reached) part_[brick] = kUnnumbered;
    for (const Index first : reached) {
      if (part_[first] != kUnnumbered) continue;
      part_[first] = parts_;
      for (std::vector<Index> front = {first}; !front.empty();) {
        const Voxel at = bricks.brick(front.back());
        front.pop_back();
        for (Index k = 0; k < 27; ++k) {
          const Index beside = bricks.find(around(at, k));
          if (beside == kNone || part_[beside] != kUnnumbered) continue;
          part_[beside] = parts_;
          front.push_back(beside);
        }
      }
      ++parts_;
    }
    leave_out_small_parts();
  }

  // Parts of few dense samples are chance.
  void leave_out_small_parts() {
    std::vector<Index> samples(static_cast<std::size_t>(parts_), 0);
    for (const Index i : dense_) ++samples[part_at(cloud_.position[i])];
    std::vector<Index> number(samples.size(), kNone);
    parts_ = 0;
    for (std::size_t part = 0; part < samples.size(); ++part)
      if (samples[part] >= kLeastSamples) number[part] = parts_++;
    for (Index& part : part_)
      if (part != kNone) part = number[part];
  }

  // The part that holds a brick of half the size.
  Index part_of(const Voxel& half) const {
    const Index brick = solid_.image.bricks.find(whole_of(half));
    return brick == kNone ? kNone : part_[brick];
  }
  static Voxel whole_of(const Voxel& half) { return {half[0] >> 1, half[1] >> 1, half[2] >> 1}; }

  bool is_near_part(Index brick) const {
    for (Index k = 0; k < 27; ++k) {
      const Index beside = solid_.image.bricks.find(around(solid_.image.bricks.brick(brick), k));
      if (beside != kNone && part_[beside] != kNone) return true;
    }
    return false;
  }
  std::vector<Index> bricks_of_parts(const BrickIndex& halves) const {
    std::vector<Index> result;
    for (Index brick = 0; brick < halves.size(); ++brick)
      if (part_of(halves.brick(brick)) != kNone) result.push_back(brick);
    return result;
  }

  // The same solid with voxels of half the size: of the bricks that are wanted those in which
  // something happens, or may when they are refined, and all that touch these.
  template <class IsWanted>
  VoxelSolid in_halves(const IsWanted& is_wanted) const {
    VoxelSolid halves;
    halves.lattice = solid_.lattice;
    halves.spacing = solid_.spacing;
    halves.lattice.size *= kSmallerVoxels;
    const VoxelImage& image = solid_.image;
    for (Index brick = 0; brick < image.bricks.size(); ++brick) {
      if (!may_change_within(brick) || !is_wanted(brick)) continue;
      const Voxel& at = image.bricks.brick(brick);
      for (Index k = 0; k < 64; ++k) {
        const Voxel half{2 * at[0] + (k & 3) - 1, 2 * at[1] + (k >> 2 & 3) - 1,
                         2 * at[2] + (k >> 4) - 1};
        const Index known = halves.image.bricks.size();
        if (halves.image.add(half) != known) continue;
        const Index octant = (half[0] & 1) | (half[1] & 1) << 1 | (half[2] & 1) << 2;
        const Voxel whole = whole_of(half);
        halves.image.mask.back() = halved(image.mask_beside(brick, whole), octant);
        const Index of = image.bricks.find(whole);
        halves.near_samples.push_back(of == kNone ? 0 : halved(solid_.near_samples[of], octant));
      }
    }
    return halves;
  }
  bool may_change_within(Index brick) const {
    const VoxelImage& image = solid_.image;
    if (part_[brick] != kNone || !is_uniform(image.mask[brick])) return true;
    for (Index k = 0; k < 27; ++k)
      if (image.mask_beside(brick, around(image.bricks.brick(brick), k)) != image.mask[brick])
        return true;
    return false;
  }

  // Parts that are better with smaller voxels: their samples bear these out, and there are no more
  // handles, or they bear out these too.
  std::vector<char> better_parts(const VoxelSolid& before, const VoxelSolid& after,
                                 Progress& progress) const {
    const std::vector<Index> euler_before = euler_by_part(before.image, progress),
                             euler_after = euler_by_part(after.image, progress);
    const std::vector<Evidence> evidence = evidence_for(after);
    std::vector<char> result;
    for (Index part = 0; part < parts_; ++part) {
      const Index handles = (euler_before[part] - euler_after[part]) / 2;  // more, if positive
      result.push_back(evidence[part].agreement() >= (handles > 0 ? kNearlyAll : kMost) &&
                       evidence[part].samples >= kSamplesPerHandle * handles);
    }
    return result;
  }

  // Euler characteristic of the boundary in and beside each part, by bricks of half the size. Parts
  // are at least two of these apart, so that none is beside two parts.
  std::vector<Index> euler_by_part(VoxelImage image, Progress& progress) const {
    make_well_composed(image, progress);
    const std::vector<Index> of_brick = euler_characteristics(image, progress);
    std::vector<Index> result(static_cast<std::size_t>(parts_), 0);
    for (Index brick = 0; brick < image.bricks.size(); ++brick) {
      if (of_brick[brick] == 0) continue;
      for (Index k = 0; k < 27; ++k) {
        const Index part = part_of(around(image.bricks.brick(brick), k));
        if (part == kNone) continue;
        result[part] += of_brick[brick];
        break;
      }
    }
    return result;
  }

  // How many dense samples of a part have solid behind, and how many nothing before them.
  struct Evidence {
    Index samples = 0, solid_behind = 0, empty_before = 0;
    double agreement() const {
      return static_cast<double>(std::min(solid_behind, empty_before)) / samples;
    }
  };
  std::vector<Evidence> evidence_for(const VoxelSolid& refined) const {
    std::vector<Evidence> evidence(static_cast<std::size_t>(parts_));
    for (const Index i : dense_) {
      const Index part = part_at(cloud_.position[i]);
      if (part == kNone) continue;
      const double spacing =
          std::max<double>(cloud_.local_spacing[i], kSmallerVoxels * solid_.spacing);
      const Vec3 depth = kDepth * spacing * cloud_.normal[i].cast<double>();
      ++evidence[part].samples;
      evidence[part].solid_behind += refined.contains(cloud_.position[i] - depth);
      evidence[part].empty_before += !refined.contains(cloud_.position[i] + depth);
    }
    return evidence;
  }

  // The part that holds a point.
  Index part_at(const Vec3& p) const {
    const Index brick = solid_.image.bricks.find(BrickIndex::brick_of(solid_.lattice.voxel_of(p)));
    return brick == kNone ? kNone : part_[brick];
  }

  VoxelSolid& solid_;
  const PointCloud& cloud_;
  const WindingNumber& winding_;
  const InitialMeshOptions& options_;
  std::vector<Index> dense_;  // samples
  std::vector<Index> part_;   // per brick of the solid; kNone: not dense
  Index parts_ = 0;
};

}  // namespace

Index refine_dense_parts(VoxelSolid& solid, const PointCloud& cloud, const WindingNumber& winding,
                         const InitialMeshOptions& options, Progress& progress) {
  if (options.dense_spacing <= 0.0) return 0;
  return Refinement(solid, cloud, winding, options).run(progress);
}

}  // namespace shrinkwrap
