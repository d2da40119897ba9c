#include "initial_mesh/voxel_solid.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "geometry/bounding_box.h"
#include "initial_mesh/plane_field.h"

namespace shrinkwrap {
namespace {

constexpr Index kBrickGrain = 16;
// A brick beside one in reach is uniform if the winding number at its corners keeps so far from
// the level.
constexpr double kFarMargin = 0.1;
constexpr Index kMembraneBricksPerSample = 2;
// In reach of the samples; a surface evenly sampled has less than a fifth of one.
constexpr std::size_t kMostBricksPerSample = 4;
constexpr std::size_t kMostBricksOfFewSamples = 1 << 12;
// Coordinates of bricks fit their keys, with room for the bricks around.
constexpr double kMostVoxelsPerAxis = 1 << 22;

// Of voxels of the size asked for, or as fine as keys of bricks can be.
VoxelLattice lattice_over(const Box& box, double voxel_size) {
  VoxelLattice lattice;
  lattice.size = std::max(voxel_size, (box.high - box.low).maxCoeff() / kMostVoxelsPerAxis);
  lattice.origin = box.low - Vec3::Constant(0.5 * lattice.size);
  return lattice;
}

class Classification {
 public:
  Classification(const PointCloud& cloud, const WindingNumber& winding,
                 const InitialMeshOptions& options, VoxelSolid solid = {})
      : cloud_(cloud), winding_(winding), options_(options), solid_(std::move(solid)) {}

  VoxelSolid run(Progress& progress) {
    progress.set_range(0.0, 0.1);
    const PlaneField planes = add_bricks_in_reach(progress);
    progress.set_range(0.1, 0.5);
    parallel_for_each(solid_.image.bricks.size(), kBrickGrain, progress,
                      [&](Index brick) { classify(brick, planes); });
    progress.set_range(0.5, 0.6);
    follow_level_set(progress);
    solid_.near_samples.resize(solid_.image.mask.size(), 0);
    return std::move(solid_);
  }

  // Only of some bricks.
  VoxelSolid run(const std::vector<Index>& bricks, double least_spacing, Progress& progress) {
    const PlaneField planes = make_plane_field(least_spacing, progress);
    parallel_for_each(static_cast<Index>(bricks.size()), kBrickGrain, progress,
                      [&](Index i) { classify(bricks[i], planes); });
    return std::move(solid_);
  }

 private:
  // See InitialMeshOptions::squares_per_sample.
  double spacing_to_suit() const {
    const double greatest = kGreatestSpacing * cloud_.spacing;
    double squares = 0.0;
    for (const float spacing : cloud_.local_spacing) {
      const double s = std::min<double>(spacing, greatest);
      squares += s * s;
    }
    const double most =
        std::max(options_.squares_per_sample * cloud_.size(), options_.many_squares);
    const double excess = squares / (most * cloud_.spacing * cloud_.spacing);
    return excess > 1.0 ? std::sqrt(excess) * cloud_.spacing : cloud_.spacing;
  }

  // Where many samples are so far apart, for the median spacing, that the voxels between them would
  // be many times the samples, voxels are larger; samples count as being as far apart as suits
  // these, for their planes to reach over two or three voxels.
  PlaneField add_bricks_in_reach(Progress& progress) {
    const std::size_t most =
        std::max(kMostBricksPerSample * cloud_.position.size(), kMostBricksOfFewSamples);
    const Box box = bounding_box(cloud_.position);
    solid_.spacing = spacing_to_suit();
    for (double size = options_.voxel_size * solid_.spacing;; size = 2.0 * solid_.lattice.size) {
      solid_.lattice = lattice_over(box, size);
      PlaneField planes =
          make_plane_field(solid_.lattice.size / (options_.voxel_size * cloud_.spacing), progress);
      const std::vector<BrickKey> keys = planes.keys_of_bricks_in_reach(progress);
      if (keys.size() > most) continue;
      for (const BrickKey key : keys) solid_.image.add(brick_of_key(key));
      solid_.near_samples.assign(keys.size(), 0);
      return planes;
    }
  }
  PlaneField make_plane_field(double least_spacing, Progress& progress) const {
    return {
        cloud_, solid_.lattice, {options_.blend_end, least_spacing, options_.sideways}, progress};
  }

  // Beyond the reach of the plane field the winding number varies slowly: one value serves the 8
  // voxels of an octant of a brick, apart for those that the plane field calls inside, outside or
  // nothing. It is not asked for where it cannot tip the balance.
  void classify(Index index, const PlaneField& plane_field) {
    const Voxel brick = solid_.image.bricks.brick(index);
    const BrickPlanes planes = plane_field.planes_at(brick);
    const double begin = options_.blend_begin, width = options_.blend_end - options_.blend_begin,
                 level = options_.level;
    BrickMask inside = 0, near = 0;
    for (Index octant = 0; octant < 8; ++octant) {
      const Index first = (octant >> 2) << 5 | (octant >> 1 & 1) << 3 | (octant & 1) << 1;
      double shared[3] = {-1.0, -1.0, -1.0};  // winding number by what the plane field says
      for (Index k = 0; k < 8; ++k) {
        const Index offset = first + ((k >> 2) << 4 | (k >> 1 & 1) << 2 | (k & 1));
        double plane = -1.0, trust_winding = 1.0;
        if (planes.weight_sum[offset] > 0.0f) {
          near |= BrickMask{1} << offset;
          plane = std::clamp<double>(
              level - planes.distance_sum[offset] / planes.weight_sum[offset], 0.0, 1.0);
          trust_winding = std::clamp(
              (std::sqrt(static_cast<double>(planes.nearest[offset])) - begin) / width, 0.0, 1.0);
        }
        const double by_plane = (1.0 - trust_winding) * std::max(plane, 0.0);
        double value = by_plane;
        if (by_plane <= level && by_plane + trust_winding > level) {
          const auto winding_here = [&] {
            return std::clamp(
                winding_.at(solid_.lattice.centre_of(BrickIndex::voxel_in(brick, offset))), 0.0,
                1.0);
          };
          if (plane > 0.0 && plane < 1.0) {
            value += trust_winding * winding_here();
          } else {
            double& winding = shared[plane < 0.0 ? 0 : plane > 0.0 ? 1 : 2];
            if (winding == -1.0) winding = winding_here();
            value += trust_winding * winding;
          }
        }
        if (value > level) inside |= BrickMask{1} << offset;
      }
    }
    solid_.image.mask[index] = inside;
    solid_.near_samples[index] = near;
  }

  // Classifies every brick that touches one where something happens, be it at a corner only, and
  // goes on from those through which the level set of the winding number runs: the boundary is
  // closed because no brick in which it runs meets the unknown.
  void follow_level_set(Progress& progress) {
    VoxelImage& image = solid_.image;
    const std::int64_t limit =
        image.bricks.size() + std::int64_t{kMembraneBricksPerSample} * cloud_.size() + 4096;
    BrickIndex corners;  // of bricks, where the winding number is known
    std::vector<double> winding;
    std::vector<Index> front(static_cast<std::size_t>(image.bricks.size()));
    for (Index i = 0; i < image.bricks.size(); ++i) front[i] = i;
    std::int64_t active = image.bricks.size();
    for (bool near_samples = true; !front.empty(); near_samples = false) {
      if (active > limit)
        throw ReconstructionFailed(
            "the surface over the openings of the cloud would be far larger than the surface "
            "itself: raise the inside level, remove stray points, or reconstruct one part of "
            "the cloud at a time");
      const Index known = image.bricks.size();
      for (const BrickKey key : unknown_around(front, progress)) image.add(brick_of_key(key));
      const Index count = image.bricks.size() - known;

      const Index known_corners = corners.size();
      std::vector<std::array<Index, 8>> corner(static_cast<std::size_t>(count));
      for (Index i = 0; i < count; ++i)
        for (Index k = 0; k < 8; ++k)
          corner[i][k] =
              corners.insert(image.bricks.brick(known + i) + Voxel{k & 1, k >> 1 & 1, k >> 2});
      winding.resize(static_cast<std::size_t>(corners.size()));
      parallel_for_each(corners.size() - known_corners, 64, progress, [&](Index i) {
        const Voxel& c = corners.brick(known_corners + i);
        winding[known_corners + i] = winding_.at(solid_.lattice.corner_of(
            {c[0] * BrickIndex::kEdge, c[1] * BrickIndex::kEdge, c[2] * BrickIndex::kEdge}));
      });
      front = parallel_collect<Index>(
          count, kBrickGrain, progress, [&](Index begin, Index end, std::vector<Index>& mixed) {
            for (Index i = begin; i < end; ++i)
              if (classify_far(known + i, corner[i], winding, near_samples))
                mixed.push_back(known + i);
          });
      active += static_cast<std::int64_t>(front.size());
    }
  }

  // Keys of the bricks that touch those given and are not in the image, ascending.
  std::vector<BrickKey> unknown_around(const std::vector<Index>& bricks, Progress& progress) const {
    const BrickIndex& known = solid_.image.bricks;
    std::vector<BrickKey> found =
        parallel_collect<BrickKey>(static_cast<Index>(bricks.size()), 256, progress,
                                   [&](Index begin, Index end, std::vector<BrickKey>& unknown) {
                                     for (Index i = begin; i < end; ++i)
                                       for (Index k = 0; k < 27; ++k) {
                                         const Voxel brick = around(known.brick(bricks[i]), k);
                                         if (known.find(brick) == kNone)
                                           unknown.push_back(key_of(brick));
                                       }
                                     sort_unique(unknown);
                                   });
    parallel_sort_unique(found);
    return found;
  }

  // Fills a brick that no sample reaches; true if the level set runs through it. Farther out than
  // next to bricks in reach, the winding number varies so slowly that the errors of its tree would
  // make foam of the level set: interpolated between the corners, it is smooth, and cheap.
  bool classify_far(Index index, const std::array<Index, 8>& corner,
                    const std::vector<double>& winding, bool near_samples) {
    double at_corner[8], low = 1e30, high = -1e30;
    for (int k = 0; k < 8; ++k) {
      at_corner[k] = winding[corner[k]];
      low = std::min(low, at_corner[k]);
      high = std::max(high, at_corner[k]);
    }
    const double margin = near_samples ? kFarMargin : 0.0;
    BrickMask& mask = solid_.image.mask[index];
    mask = low > options_.level + margin ? kAllSolid : 0;
    if (low > options_.level + margin || high <= options_.level - margin) return false;
    const Voxel brick = solid_.image.bricks.brick(index);
    for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
      const double value =
          near_samples ? winding_.at(solid_.lattice.centre_of(BrickIndex::voxel_in(brick, offset)))
                       : interpolated(at_corner, offset);
      if (value > options_.level) mask |= BrickMask{1} << offset;
    }
    return true;
  }

  // Trilinear, at the centre of a voxel of a brick.
  static double interpolated(const double (&at_corner)[8], Index offset) {
    const auto part = [](Index voxel) { return (voxel + 0.5) / BrickIndex::kEdge; };
    const double x = part(offset & 3), y = part(offset >> 2 & 3), z = part(offset >> 4);
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    const auto on_face = [&](int first) {
      return between(between(at_corner[first], at_corner[first + 1], x),
                     between(at_corner[first + 2], at_corner[first + 3], x), y);
    };
    return between(on_face(0), on_face(4), z);
  }

  const PointCloud& cloud_;
  const WindingNumber& winding_;
  const InitialMeshOptions& options_;
  VoxelSolid solid_;
};

}  // namespace

VoxelSolid make_voxel_solid(const PointCloud& cloud, const WindingNumber& winding,
                            const InitialMeshOptions& options, Progress& progress) {
  return Classification(cloud, winding, options).run(progress);
}

VoxelSolid with_bricks_classified(VoxelSolid solid, const std::vector<Index>& bricks,
                                  double least_spacing, const PointCloud& cloud,
                                  const WindingNumber& winding, const InitialMeshOptions& options,
                                  Progress& progress) {
  return Classification(cloud, winding, options, std::move(solid))
      .run(bricks, least_spacing, progress);
}

}  // namespace shrinkwrap
