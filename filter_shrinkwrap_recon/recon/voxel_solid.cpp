#include "voxel_solid.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "bounding_box.h"
#include "morton.h"
#include "parallel.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr Index kSampleGrain = 1 << 12;
constexpr Index kBrickGrain = 16;
// A brick beside one in reach is uniform if the winding number at its corners keeps so far from
// the level.
constexpr double kFarMargin = 0.1;
// x median spacing: no sample reaches farther than if it were so isolated. Where a dense part has
// most of the samples, those elsewhere may be as far apart, and planes must meet between them.
constexpr double kGreatestSpacing = 16;
constexpr double kLeastReach = 1.75;  // x size of a voxel
constexpr Index kMembraneBricksPerSample = 2;
// In reach of the samples; a surface evenly sampled has less than a fifth of one.
constexpr std::size_t kMostBricksPerSample = 4;
constexpr std::size_t kMostBricksOfFewSamples = 1 << 12;
// Brick coordinates fit the 21 bits of a Morton key, with room for the bricks around.
constexpr double kMostVoxelsPerAxis = 1 << 22;
constexpr Index kKeyOffset = 1 << 19;

std::uint64_t key_of(const Voxel& brick) {
  const auto part = [](Index c) { return static_cast<std::uint32_t>(c + kKeyOffset); };
  return morton_key(part(brick[0]), part(brick[1]), part(brick[2]));
}

Voxel brick_of_key(std::uint64_t key) {
  const auto [x, y, z] = morton_coordinates(key);
  const auto part = [](std::uint32_t c) { return static_cast<Index>(c) - kKeyOffset; };
  return {part(x), part(y), part(z)};
}

// Of voxels of the size asked for, or as fine as keys of bricks can be.
VoxelLattice lattice_over(const Box& box, double voxel_size) {
  VoxelLattice lattice;
  lattice.size = std::max(voxel_size, (box.high - box.low).maxCoeff() / kMostVoxelsPerAxis);
  lattice.origin = box.low - Vec3::Constant(0.5 * lattice.size);
  return lattice;
}

// The plane of a sample; lengths in voxels, so that single precision will do.
struct SamplePlane {
  Vec3f position;  // from the lowest corner of the brick that holds it
  Vec3f normal;
  float reach;
  float per_spacing;
};

// Samples binned by the brick that holds them.
struct SampleBins {
  BrickIndex bricks;
  std::vector<Index> begin;        // per brick, and one more
  std::vector<SamplePlane> plane;  // by brick, in the order of the samples
  float greatest_reach = 0.0f;
};

// Samples count as at least `least_spacing` (x median) apart.
SampleBins bin_samples(const PointCloud& cloud, const VoxelLattice& lattice, double least_spacing,
                       const InitialMeshOptions& options, Progress& progress) {
  SampleBins bins;
  std::vector<Voxel> brick(cloud.position.size());
  parallel_for_each(cloud.size(), kSampleGrain, progress, [&](Index i) {
    brick[i] = BrickIndex::brick_of(lattice.voxel_of(cloud.position[i]));
  });
  std::vector<Index> bin(cloud.position.size());
  // Samples come in runs of one brick: only the first of each run looks it up.
  const std::vector<Index> run = parallel_collect<Index>(
      cloud.size(), kSampleGrain, progress, [&](Index begin, Index end, std::vector<Index>& some) {
        for (Index i = begin; i < end; ++i)
          if (i == 0 || brick[i] != brick[i - 1]) some.push_back(i);
      });
  for (const Index first : run) bin[first] = bins.bricks.insert(brick[first]);
  parallel_for_each(static_cast<Index>(run.size()), kSampleGrain, progress, [&](Index r) {
    const Index end = r + 1 < static_cast<Index>(run.size()) ? run[r + 1] : cloud.size();
    std::fill(bin.begin() + run[r] + 1, bin.begin() + end, bin[run[r]]);
  });
  bins.begin.assign(static_cast<std::size_t>(bins.bricks.size()) + 1, 0);
  for (const Index b : bin) ++bins.begin[b + 1];
  for (Index b = 0; b < bins.bricks.size(); ++b) bins.begin[b + 1] += bins.begin[b];
  std::vector<Index> place(cloud.position.size());
  std::vector<Index> cursor(bins.begin.begin(), bins.begin.end() - 1);
  for (Index i = 0; i < cloud.size(); ++i) place[i] = cursor[bin[i]]++;

  bins.plane.resize(cloud.position.size());
  const double least = least_spacing * cloud.spacing,
               greatest = std::max(kGreatestSpacing * cloud.spacing, least);
  parallel_for_each(cloud.size(), kSampleGrain, progress, [&](Index i) {
    const double spacing =
        std::clamp<double>(cloud.local_spacing[i], least, greatest) / lattice.size;
    const Voxel& holder = brick[i];
    const Vec3 corner(holder[0], holder[1], holder[2]);
    SamplePlane& plane = bins.plane[place[i]];
    plane.position = ((cloud.position[i] - lattice.origin) / lattice.size -
                      static_cast<double>(BrickIndex::kEdge) * corner)
                         .cast<float>();
    plane.normal = cloud.normal[i];
    plane.reach = static_cast<float>(std::max(options.blend_end * spacing, kLeastReach));
    plane.per_spacing = static_cast<float>(1.0 / spacing);
  });
  for (const SamplePlane& plane : bins.plane)
    bins.greatest_reach = std::max(bins.greatest_reach, plane.reach);
  return bins;
}

class Classification {
 public:
  Classification(const PointCloud& cloud, const WindingNumber& winding,
                 const InitialMeshOptions& options, VoxelSolid solid = {})
      : cloud_(cloud), winding_(winding), options_(options), solid_(std::move(solid)) {}

  VoxelSolid run(Progress& progress) {
    progress.set_range(0.0, 0.1);
    const SampleBins bins = add_bricks_in_reach(progress);
    progress.set_range(0.1, 0.5);
    parallel_for_each(solid_.image.bricks.size(), kBrickGrain, progress,
                      [&](Index brick) { classify(brick, bins); });
    progress.set_range(0.5, 0.6);
    follow_level_set(progress);
    solid_.near_samples.resize(solid_.image.mask.size(), 0);
    return std::move(solid_);
  }

  // Only of some bricks.
  VoxelSolid run(const std::vector<Index>& bricks, double least_spacing, Progress& progress) {
    const SampleBins bins = bin_samples(cloud_, solid_.lattice, least_spacing, options_, progress);
    parallel_for_each(static_cast<Index>(bricks.size()), kBrickGrain, progress,
                      [&](Index i) { classify(bricks[i], bins); });
    return std::move(solid_);
  }

 private:
  // What samples say of the 64 voxels of a brick.
  struct PlaneField {
    float distance_sum[BrickIndex::kVoxels] = {};  // weighted, x 1/s_i
    float weight_sum[BrickIndex::kVoxels] = {};    // 0 where no sample reaches
    float nearest[BrickIndex::kVoxels];            // squared distance of the nearest, x 1/s_i^2
  };

  // Where most samples are so far apart, for the median spacing, that the voxels between them would
  // be many times the samples, voxels are larger; samples count as being as far apart as suits
  // these, for their planes to reach over two or three voxels.
  SampleBins add_bricks_in_reach(Progress& progress) {
    const std::size_t most =
        std::max(kMostBricksPerSample * cloud_.position.size(), kMostBricksOfFewSamples);
    const Box box = bounding_box(cloud_.position);
    const double asked_for = options_.voxel_size * cloud_.spacing;
    for (double size = asked_for;; size = 2.0 * solid_.lattice.size) {
      solid_.lattice = lattice_over(box, size);
      const double least_spacing = solid_.lattice.size / asked_for;
      SampleBins bins = bin_samples(cloud_, solid_.lattice, least_spacing, options_, progress);
      const std::vector<std::uint64_t> bricks = bricks_in_reach(bins, progress);
      if (bricks.size() > most) continue;
      for (const std::uint64_t key : bricks) solid_.image.add(brick_of_key(key));
      solid_.near_samples.assign(bricks.size(), 0);
      return bins;
    }
  }

  // Their keys, ascending.
  static std::vector<std::uint64_t> bricks_in_reach(const SampleBins& bins, Progress& progress) {
    std::vector<std::uint64_t> bricks = parallel_collect<std::uint64_t>(
        bins.bricks.size(), 64, progress,
        [&](Index begin, Index end, std::vector<std::uint64_t>& reached) {
          Voxel last_low{}, last_high{};
          for (Index bin = begin; bin < end; ++bin)
            for (Index k = bins.begin[bin]; k < bins.begin[bin + 1]; ++k) {
              const SamplePlane& plane = bins.plane[k];
              Voxel low = bins.bricks.brick(bin), high = low;
              for (int axis = 0; axis < 3; ++axis) {
                const auto bricks_off = [&](float voxels) {
                  return static_cast<Index>(std::floor(voxels / BrickIndex::kEdge));
                };
                low[axis] += bricks_off(plane.position[axis] - plane.reach);
                high[axis] += bricks_off(plane.position[axis] + plane.reach);
              }
              if (!reached.empty() && low == last_low && high == last_high) continue;
              last_low = low;
              last_high = high;
              for (Index z = low[2]; z <= high[2]; ++z)
                for (Index y = low[1]; y <= high[1]; ++y)
                  for (Index x = low[0]; x <= high[0]; ++x) reached.push_back(key_of({x, y, z}));
            }
          sort_unique(reached);
        });
    tbb::parallel_sort(bricks);
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    return bricks;
  }

  static void gather(const Voxel& brick, const SampleBins& bins, PlaneField& field) {
    std::fill(std::begin(field.nearest), std::end(field.nearest), 1e30f);
    // Bins to each side whose samples may reach the brick.
    const Index around = static_cast<Index>(std::ceil(bins.greatest_reach / BrickIndex::kEdge));
    for (Index z = -around; z <= around; ++z)
      for (Index y = -around; y <= around; ++y)
        for (Index x = -around; x <= around; ++x) {
          const Index bin = bins.bricks.find(brick + Voxel{x, y, z});
          if (bin == kNone) continue;
          const Vec3f to_first =
              Vec3f::Constant(0.5f) -
              static_cast<float>(BrickIndex::kEdge) *
                  Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
          for (Index k = bins.begin[bin]; k < bins.begin[bin + 1]; ++k)
            splat(bins.plane[k], to_first - bins.plane[k].position, field);
        }
  }

  // Adds the plane of a sample, of weight (1 - (d / reach)^2)^5: close to a Gaussian of 0.75 s.
  // `to_first`: from the sample to the centre of the lowest voxel of the brick.
  static void splat(const SamplePlane& plane, const Vec3f& to_first, PlaneField& field) {
    constexpr float kLast = BrickIndex::kEdge - 1;
    const auto gap = [](float from) {  // of a row of voxel centres, from the sample
      return std::max(std::max(from, -from - kLast), 0.0f);
    };
    const float reach_squared = plane.reach * plane.reach;
    const float gap_x = gap(to_first.x()), gap_y = gap(to_first.y()), gap_z = gap(to_first.z());
    if (gap_x * gap_x + gap_y * gap_y + gap_z * gap_z > reach_squared) return;

    const float per_reach_squared = 1.0f / reach_squared,
                per_spacing_squared = plane.per_spacing * plane.per_spacing;
    const Vec3f normal = plane.per_spacing * plane.normal;
    for (int kz = 0; kz < BrickIndex::kEdge; ++kz) {
      const float z = to_first.z() + static_cast<float>(kz);
      for (int ky = 0; ky < BrickIndex::kEdge; ++ky) {
        const float y = to_first.y() + static_cast<float>(ky);
        const float row = y * y + z * z, row_dot = y * normal.y() + z * normal.z();
        if (row + gap_x * gap_x > reach_squared) continue;
        const int at = kz << 4 | ky << 2;
        for (int kx = 0; kx < BrickIndex::kEdge; ++kx) {
          const float x = to_first.x() + static_cast<float>(kx);
          const float squared = row + x * x;
          const bool in_reach = squared <= reach_squared;
          const float rest = in_reach ? 1.0f - squared * per_reach_squared : 0.0f,
                      rest_squared = rest * rest;
          const float weight = rest_squared * rest_squared * rest + (in_reach ? 1e-12f : 0.0f);
          field.distance_sum[at + kx] += weight * (row_dot + x * normal.x());
          field.weight_sum[at + kx] += weight;
          field.nearest[at + kx] =
              std::min(field.nearest[at + kx], in_reach ? squared * per_spacing_squared : 1e30f);
        }
      }
    }
  }

  // Beyond the reach of the plane field the winding number varies slowly: one value serves the 8
  // voxels of an octant of a brick, apart for those that the plane field calls inside, outside or
  // nothing. It is not asked for where it cannot tip the balance.
  void classify(Index index, const SampleBins& bins) {
    const Voxel brick = solid_.image.bricks.brick(index);
    PlaneField field;
    gather(brick, bins, field);
    const double begin = options_.blend_begin, width = options_.blend_end - options_.blend_begin,
                 level = options_.level;
    BrickMask inside = 0, near = 0;
    for (Index octant = 0; octant < 8; ++octant) {
      const Index first = (octant >> 2) << 5 | (octant >> 1 & 1) << 3 | (octant & 1) << 1;
      double shared[3] = {-1.0, -1.0, -1.0};  // winding number by what the plane field says
      for (Index k = 0; k < 8; ++k) {
        const Index offset = first + ((k >> 2) << 4 | (k >> 1 & 1) << 2 | (k & 1));
        double plane = -1.0, trust_winding = 1.0;
        if (field.weight_sum[offset] > 0.0f) {
          near |= BrickMask{1} << offset;
          plane = std::clamp<double>(level - field.distance_sum[offset] / field.weight_sum[offset],
                                     0.0, 1.0);
          trust_winding = std::clamp(
              (std::sqrt(static_cast<double>(field.nearest[offset])) - begin) / width, 0.0, 1.0);
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
            "itself: leave openings open, or remove stray points");
      const Index known = image.bricks.size();
      for (const std::uint64_t key : unknown_around(front, progress)) image.add(brick_of_key(key));
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
  std::vector<std::uint64_t> unknown_around(const std::vector<Index>& bricks,
                                            Progress& progress) const {
    const BrickIndex& known = solid_.image.bricks;
    std::vector<std::uint64_t> found = parallel_collect<std::uint64_t>(
        static_cast<Index>(bricks.size()), 256, progress,
        [&](Index begin, Index end, std::vector<std::uint64_t>& unknown) {
          for (Index i = begin; i < end; ++i)
            for (Index k = 0; k < 27; ++k) {
              const Voxel brick = around(known.brick(bricks[i]), k);
              if (known.find(brick) == kNone) unknown.push_back(key_of(brick));
            }
          sort_unique(unknown);
        });
    tbb::parallel_sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
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
