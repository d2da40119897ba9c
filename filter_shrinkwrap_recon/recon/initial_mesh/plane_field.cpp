#include "initial_mesh/plane_field.h"

#include <algorithm>
#include <cmath>

#include "common/parallel.h"
#include "common/sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr Index kBinGrain = 64;
constexpr double kLeastReach = 1.75;  // x size of a voxel

// Of the brick at a coordinate of voxels.
Index brick_at(float voxels) {
  return static_cast<Index>(std::floor(voxels / BrickIndex::kEdge));
}

}  // namespace

class PlaneField::LevelMaker {
 public:
  LevelMaker(const PointCloud& cloud, const VoxelLattice& lattice, const PlaneFieldOptions& options)
      : cloud_(cloud),
        lattice_(lattice),
        reach_(options.reach),
        least_(options.least_spacing * cloud.spacing),
        greatest_(std::max(kGreatestSpacing * cloud.spacing, least_)) {}

  // The least power of two that makes bins as large as the sample reaches.
  int power_for(Index i) const {
    const double reach = reach_of(i);
    int power = 0;
    while (reach > (BrickIndex::kEdge << power)) ++power;
    return power;
  }

  Level level_of(const std::vector<Index>& samples, int power, Progress& progress) const {
    const Index count = static_cast<Index>(samples.size());
    Level level;
    level.power = power;
    std::vector<Voxel> holder(samples.size());
    parallel_for_each(count, kGrain, progress, [&](Index k) {
      const Voxel brick = BrickIndex::brick_of(lattice_.voxel_of(cloud_.position[samples[k]]));
      for (int axis = 0; axis < 3; ++axis) holder[k][axis] = brick[axis] >> power;
    });
    std::vector<Index> bin(samples.size());
    // Samples come in runs of one bin: only the first of each run looks it up.
    const std::vector<Index> run = parallel_collect<Index>(
        count, kGrain, progress, [&](Index begin, Index end, std::vector<Index>& some) {
          for (Index k = begin; k < end; ++k)
            if (k == 0 || holder[k] != holder[k - 1]) some.push_back(k);
        });
    for (const Index first : run) bin[first] = level.bins.insert(holder[first]);
    parallel_for_each(static_cast<Index>(run.size()), kGrain, progress, [&](Index r) {
      const Index end = r + 1 < static_cast<Index>(run.size()) ? run[r + 1] : count;
      std::fill(bin.begin() + run[r] + 1, bin.begin() + end, bin[run[r]]);
    });
    level.begin.assign(static_cast<std::size_t>(level.bins.size()) + 1, 0);
    for (const Index b : bin) ++level.begin[b + 1];
    for (Index b = 0; b < level.bins.size(); ++b) level.begin[b + 1] += level.begin[b];
    std::vector<Index> place(samples.size());
    std::vector<Index> cursor(level.begin.begin(), level.begin.end() - 1);
    for (Index k = 0; k < count; ++k) place[k] = cursor[bin[k]]++;

    level.plane.resize(samples.size());
    parallel_for_each(count, kGrain, progress, [&](Index k) {
      level.plane[place[k]] = plane_of(samples[k], holder[k], level.edge());
    });
    for (const SamplePlane& plane : level.plane)
      level.greatest_reach = std::max(level.greatest_reach, plane.reach);
    return level;
  }

 private:
  // In voxels.
  double spacing_of(Index i) const {
    return std::clamp<double>(cloud_.local_spacing[i], least_, greatest_) / lattice_.size;
  }
  double reach_of(Index i) const { return std::max(reach_ * spacing_of(i), kLeastReach); }

  SamplePlane plane_of(Index i, const Voxel& holder, Index edge) const {
    SamplePlane plane;
    plane.position = ((cloud_.position[i] - lattice_.origin) / lattice_.size -
                      static_cast<double>(edge) * Vec3(holder[0], holder[1], holder[2]))
                         .cast<float>();
    plane.normal = cloud_.normal[i];
    plane.reach = static_cast<float>(reach_of(i));
    plane.per_spacing = static_cast<float>(1.0 / spacing_of(i));
    return plane;
  }

  const PointCloud& cloud_;
  const VoxelLattice& lattice_;
  double reach_, least_, greatest_;
};

PlaneField::PlaneField(const PointCloud& cloud, const VoxelLattice& lattice,
                       const PlaneFieldOptions& options, Progress& progress)
    : sideways_(static_cast<float>(options.sideways)) {
  const LevelMaker maker(cloud, lattice, options);
  Index left = cloud.size();
  for (int power = 0; left > 0; ++power) {
    const std::vector<Index> samples = parallel_collect<Index>(
        cloud.size(), kGrain, progress, [&](Index begin, Index end, std::vector<Index>& some) {
          for (Index i = begin; i < end; ++i)
            if (maker.power_for(i) == power) some.push_back(i);
        });
    left -= static_cast<Index>(samples.size());
    if (!samples.empty()) levels_.push_back(maker.level_of(samples, power, progress));
  }
}

std::vector<BrickKey> PlaneField::keys_of_bricks_in_reach(Progress& progress) const {
  std::vector<BrickKey> keys;
  for (const Level& level : levels_) {
    const std::vector<BrickKey> of_level =
        parallel_collect<BrickKey>(level.bins.size(), kBinGrain, progress,
                                   [&](Index begin, Index end, std::vector<BrickKey>& reached) {
                                     for (Index bin = begin; bin < end; ++bin)
                                       add_bricks_in_reach(level, bin, reached);
                                     sort_unique(reached);
                                   });
    keys.insert(keys.end(), of_level.begin(), of_level.end());
  }
  parallel_sort_unique(keys);
  return keys;
}

void PlaneField::add_bricks_in_reach(const Level& level, Index bin,
                                     std::vector<BrickKey>& reached) {
  const Voxel first = level.bins.brick(bin);
  Voxel last_low{}, last_high{};
  for (Index k = level.begin[bin]; k < level.begin[bin + 1]; ++k) {
    const SamplePlane& plane = level.plane[k];
    Voxel low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = (first[axis] << level.power) + brick_at(plane.position[axis] - plane.reach);
      high[axis] = (first[axis] << level.power) + brick_at(plane.position[axis] + plane.reach);
    }
    if (k > level.begin[bin] && low == last_low && high == last_high) continue;
    last_low = low;
    last_high = high;
    for (Index z = low[2]; z <= high[2]; ++z)
      for (Index y = low[1]; y <= high[1]; ++y)
        for (Index x = low[0]; x <= high[0]; ++x) reached.push_back(key_of({x, y, z}));
  }
}

BrickPlanes PlaneField::planes_at(const Voxel& brick) const {
  BrickPlanes planes;
  std::fill(std::begin(planes.nearest), std::end(planes.nearest), 1e30f);
  for (const Level& level : levels_) {
    const Index edge = level.edge();
    Voxel low, high;  // bins whose samples may reach the brick
    for (int axis = 0; axis < 3; ++axis) {
      const Index from_bin = (brick[axis] & ((1 << level.power) - 1)) * BrickIndex::kEdge;
      const auto bins_off = [&](float voxels) {
        return static_cast<Index>(std::floor(voxels / static_cast<float>(edge)));
      };
      const float from = static_cast<float>(from_bin);
      low[axis] = (brick[axis] >> level.power) + bins_off(from - level.greatest_reach);
      high[axis] =
          (brick[axis] >> level.power) + bins_off(from + BrickIndex::kEdge + level.greatest_reach);
    }
    for (Index z = low[2]; z <= high[2]; ++z)
      for (Index y = low[1]; y <= high[1]; ++y)
        for (Index x = low[0]; x <= high[0]; ++x) {
          const Index bin = level.bins.find({x, y, z});
          if (bin == kNone) continue;
          const auto from = [&](int axis, Index at) {
            return static_cast<float>(brick[axis] * BrickIndex::kEdge - at * edge) + 0.5f;
          };
          const Vec3f to_first(from(0, x), from(1, y), from(2, z));
          for (Index k = level.begin[bin]; k < level.begin[bin + 1]; ++k)
            add_plane(level.plane[k], to_first - level.plane[k].position, planes);
        }
  }
  return planes;
}

// Of weight (1 - (d / reach)^2)^5: close to a Gaussian of 0.75 s. `to_first`: from the sample to
// the centre of the lowest voxel of the brick.
void PlaneField::add_plane(const SamplePlane& plane, const Vec3f& to_first,
                           BrickPlanes& planes) const {
  constexpr float kLast = BrickIndex::kEdge - 1;
  const auto gap = [](float from) {  // of a row of voxel centres, from the sample
    return std::max(std::max(from, -from - kLast), 0.0f);
  };
  const float reach_squared = plane.reach * plane.reach;
  const float gap_x = gap(to_first.x()), gap_y = gap(to_first.y()), gap_z = gap(to_first.z());
  if (gap_x * gap_x + gap_y * gap_y + gap_z * gap_z > reach_squared) return;

  const float per_reach_squared = 1.0f / reach_squared,
              per_spacing_squared = plane.per_spacing * plane.per_spacing, sideways = sideways_;
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
        const float height = row_dot + x * normal.x();
        planes.distance_sum[at + kx] += weight * height;
        planes.weight_sum[at + kx] += weight;
        const float squared_off =
            (1.0f + sideways) * squared * per_spacing_squared - sideways * height * height;
        planes.nearest[at + kx] = std::min(planes.nearest[at + kx], in_reach ? squared_off : 1e30f);
      }
    }
  }
}

}  // namespace shrinkwrap
