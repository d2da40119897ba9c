#include "voxel_solid.h"

#include <algorithm>
#include <cmath>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr double kPlaneSigma = 0.75;  // x local spacing: width of the Gaussian of the plane field
constexpr double kFarMargin =
    0.1;  // a brick is uniform if the winding number keeps so far from the level
constexpr double kGreatestSpacing =
    4;  // x median spacing: no sample reaches farther than if it were so isolated
constexpr Index kMembraneBricksPerSample = 2;

constexpr Voxel kSides[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

Voxel operator+(const Voxel& a, const Voxel& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Voxel voxel_in(const Voxel& brick, Index offset) {
  return {brick[0] * BrickIndex::kEdge + (offset & 3),
          brick[1] * BrickIndex::kEdge + (offset >> 2 & 3),
          brick[2] * BrickIndex::kEdge + (offset >> 4)};
}

}  // namespace

VoxelSolid::VoxelSolid(const PointCloud& cloud, const WindingNumber& winding,
                       const InitialMeshOptions& options, Progress& progress)
    : cloud_(cloud),
      winding_(winding),
      options_(options),
      size_(options.voxel_size * cloud.spacing) {
  origin_ = cloud.position.front();
  for (const Vec3& p : cloud.position) origin_ = origin_.cwiseMin(p);
  origin_ -= Vec3::Constant(0.5 * size_);
  progress.set_range(0.0, 0.3);
  splat(progress);
  progress.set_range(0.3, 0.5);
  classify(progress);
  progress.set_range(0.5, 0.6);
  follow_level_set(progress);
}

Voxel VoxelSolid::voxel_of(const Vec3& p) const {
  const Vec3 v = ((p - origin_) / size_).array().floor();
  return {static_cast<Index>(v.x()), static_cast<Index>(v.y()), static_cast<Index>(v.z())};
}

Vec3 VoxelSolid::centre_of(const Voxel& v) const {
  return origin_ + size_ * Vec3(v[0] + 0.5, v[1] + 0.5, v[2] + 0.5);
}

Index VoxelSolid::add_brick(const Voxel& brick) {
  const Index before = bricks_.size(), index = bricks_.insert(brick);
  if (index == before) {
    const std::size_t voxels = static_cast<std::size_t>(bricks_.size()) * BrickIndex::kVoxels;
    state_.resize(voxels, empty);
    distance_sum_.resize(voxels, 0.0f);
    weight_sum_.resize(voxels, 0.0f);
    nearest_.resize(voxels, 1e30f);
  }
  return index;
}

void VoxelSolid::splat(Progress& progress) {
  for (Index i = 0; i < cloud_.size(); ++i) {
    if (i % 4096 == 0) progress.update(static_cast<double>(i) / cloud_.size());
    const double s = std::clamp<double>(cloud_.local_spacing[i], cloud_.spacing,
                                        kGreatestSpacing * cloud_.spacing);
    const double reach = std::max(options_.blend_end * s, 1.75 * size_);
    const double sigma = std::max(kPlaneSigma * s, 0.6 * size_);
    const float sharpness = static_cast<float>(0.5 / (sigma * sigma)),
                per_s = static_cast<float>(1.0 / s);
    const Vec3f normal = cloud_.normal[i];
    const Voxel low = voxel_of(cloud_.position[i] - Vec3::Constant(reach));
    const Voxel high = voxel_of(cloud_.position[i] + Vec3::Constant(reach));
    const float reach_squared = static_cast<float>(reach * reach);
    const Voxel low_brick = BrickIndex::brick_of(low), high_brick = BrickIndex::brick_of(high);
    Voxel b;
    for (b[2] = low_brick[2]; b[2] <= high_brick[2]; ++b[2])
      for (b[1] = low_brick[1]; b[1] <= high_brick[1]; ++b[1])
        for (b[0] = low_brick[0]; b[0] <= high_brick[0]; ++b[0]) {
          const std::size_t base = static_cast<std::size_t>(add_brick(b)) * BrickIndex::kVoxels;
          Voxel first, last;
          for (int axis = 0; axis < 3; ++axis) {
            first[axis] = std::max(low[axis], b[axis] * BrickIndex::kEdge);
            last[axis] = std::min(high[axis], b[axis] * BrickIndex::kEdge + BrickIndex::kEdge - 1);
          }
          Voxel v;
          for (v[2] = first[2]; v[2] <= last[2]; ++v[2])
            for (v[1] = first[1]; v[1] <= last[1]; ++v[1])
              for (v[0] = first[0]; v[0] <= last[0]; ++v[0]) {
                const Vec3f d = (centre_of(v) - cloud_.position[i]).cast<float>();
                const float squared = d.squaredNorm();
                if (squared > reach_squared) continue;
                const std::size_t at = base + BrickIndex::offset_of(v);
                const float weight = std::exp(-squared * sharpness) + 1e-12f;
                distance_sum_[at] += weight * d.dot(normal) * per_s;
                weight_sum_[at] += weight;
                nearest_[at] = std::min(nearest_[at], squared * per_s * per_s);
              }
        }
  }
}

// Beyond the reach of the plane field the winding number varies slowly: one value serves the 8
// voxels of an octant of a brick, apart for those that the plane field calls inside, outside or
// nothing.
void VoxelSolid::classify(Progress& progress) {
  const double begin = options_.blend_begin, width = options_.blend_end - options_.blend_begin;
  parallel_for_each(bricks_.size(), 64, progress, [&](Index brick) {
    double plane[BrickIndex::kVoxels], trust_winding[BrickIndex::kVoxels];
    const std::size_t base = static_cast<std::size_t>(brick) * BrickIndex::kVoxels;
    for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
      const std::size_t at = base + offset;
      plane[offset] = -1.0;
      trust_winding[offset] = 1.0;
      if (weight_sum_[at] <= 0.0f) continue;
      plane[offset] = std::clamp(options_.level - distance_sum_[at] / weight_sum_[at], 0.0, 1.0);
      trust_winding[offset] = std::clamp((std::sqrt(nearest_[at]) - begin) / width, 0.0, 1.0);
    }
    for (Index octant = 0; octant < 8; ++octant) {
      const Index first = (octant >> 2) << 5 | (octant >> 1 & 1) << 3 | (octant & 1) << 1;
      double shared[3] = {-1.0, -1.0, -1.0};  // winding number by what the plane field says
      for (Index k = 0; k < 8; ++k) {
        const Index offset = first + ((k >> 2) << 4 | (k >> 1 & 1) << 2 | (k & 1));
        double inside = (1.0 - trust_winding[offset]) * std::max(plane[offset], 0.0);
        if (trust_winding[offset] > 0.0) {
          const Voxel v = voxel_in(bricks_.brick(brick), offset);
          double w;
          if (plane[offset] > 0.0 && plane[offset] < 1.0) {
            w = winding_.at(centre_of(v));
          } else {
            double& value = shared[plane[offset] < 0.0 ? 0 : plane[offset] > 0.0 ? 1 : 2];
            if (value == -1.0) value = winding_.at(centre_of(v));
            w = value;
          }
          inside += trust_winding[offset] * w;
        }
        state_[base + offset] = inside > options_.level ? solid : empty;
      }
    }
  });
}

// Classifies a brick that no sample reaches; true if the level set passes through it.
bool VoxelSolid::classify_far_brick(const Voxel& brick, CornerValues& winding_at_corners) {
  double low = 1e30, high = -1e30;
  for (int k = 0; k < 8; ++k) {
    const Voxel corner = {brick[0] + (k & 1), brick[1] + (k >> 1 & 1), brick[2] + (k >> 2)};
    const Index at = winding_at_corners.index.insert(corner);
    if (at == static_cast<Index>(winding_at_corners.value.size()))
      winding_at_corners.value.push_back(
          winding_.at(origin_ + size_ * BrickIndex::kEdge * Vec3(corner[0], corner[1], corner[2])));
    low = std::min(low, winding_at_corners.value[at]);
    high = std::max(high, winding_at_corners.value[at]);
  }
  if (low <= options_.level + kFarMargin && high >= options_.level - kFarMargin) return true;
  far_bricks_.insert(brick);
  far_state_.push_back(low > options_.level ? solid : empty);
  return false;
}

// Classifies every brick that touches one where something happens, be it at a corner only: the
// boundary is closed because no face, edge or corner of a brick with voxels meets the unknown.
void VoxelSolid::follow_level_set(Progress& progress) {
  CornerValues winding_at_corners;
  const Index near_bricks = bricks_.size();
  const Index limit = near_bricks + kMembraneBricksPerSample * cloud_.size() + 4096;
  for (Index i = 0; i < bricks_.size(); ++i) {
    if (i % 256 == 0)
      progress.update(static_cast<double>(i) / std::max(near_bricks, bricks_.size()));
    const Voxel brick = bricks_.brick(i);
    for (Index k = 0; k < 27; ++k) {
      const Voxel neighbour = brick + Voxel{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
      if (bricks_.find(neighbour) != kNone || far_bricks_.find(neighbour) != kNone) continue;
      if (!classify_far_brick(neighbour, winding_at_corners)) continue;
      if (bricks_.size() >= limit)
        throw ReconstructionFailed(
            "the surface over the openings of the cloud would be far larger than the surface "
            "itself: try the other "
            "way round (leave openings open), or remove stray points");
      const std::size_t base = static_cast<std::size_t>(add_brick(neighbour)) * BrickIndex::kVoxels;
      for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset)
        state_[base + offset] =
            winding_.at(centre_of(voxel_in(neighbour, offset))) > options_.level ? solid : empty;
    }
  }
}

VoxelSolid::State VoxelSolid::state_of(const Voxel& v) const {
  const Voxel brick = BrickIndex::brick_of(v);
  const Index index = bricks_.find(brick);
  if (index != kNone)
    return static_cast<State>(
        state_[static_cast<std::size_t>(index) * BrickIndex::kVoxels + BrickIndex::offset_of(v)]);
  const Index far = far_bricks_.find(brick);
  return far != kNone ? static_cast<State>(far_state_[far]) : empty;
}

bool VoxelSolid::contains(const Vec3& p) const {
  return state_of(voxel_of(p)) == solid;
}

void VoxelSolid::fill_near_samples() {
  for (std::size_t at = 0; at < state_.size(); ++at)
    state_[at] = weight_sum_[at] > 0.0f ? solid : empty;
  std::fill(far_state_.begin(), far_state_.end(), static_cast<signed char>(empty));
}

void VoxelSolid::make_well_composed(Progress& progress) {
  // A cell is the cube of 8 voxels from v to v + (1, 1, 1); corner k is v + (k & 1, k >> 1 & 1, k
  // >> 2).
  const auto corner = [](const Voxel& v, int k) {
    return Voxel{v[0] + (k & 1), v[1] + (k >> 1 & 1), v[2] + (k >> 2)};
  };
  static constexpr int kSquares[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 4, 5},
                                         {2, 3, 6, 7}, {0, 2, 4, 6}, {1, 3, 5, 7}};
  std::vector<Voxel> cells = parallel_collect<Voxel>(
      bricks_.size(), 64, progress, [&](Index begin, Index end, std::vector<Voxel>& mixed) {
        for (Index brick = begin; brick < end; ++brick)
          for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
            const Voxel v = voxel_in(bricks_.brick(brick), offset);
            int sum = 0;
            for (int k = 0; k < 8; ++k) sum += state_of(corner(v, k));
            if (sum > 0 && sum < 8) mixed.push_back(v);
          }
      });
  std::vector<Voxel> next;
  while (!cells.empty()) {
    next.clear();
    for (const Voxel& cell : cells) {
      int state[8];
      for (int k = 0; k < 8; ++k) state[k] = state_of(corner(cell, k));
      const auto fill = [&](int k) {
        const Voxel v = corner(cell, k);
        const Voxel brick = BrickIndex::brick_of(v);
        const std::size_t base = static_cast<std::size_t>(add_brick(brick)) * BrickIndex::kVoxels;
        state_[base + BrickIndex::offset_of(v)] = solid;
        state[k] = 1;
        for (int q = 0; q < 8; ++q)
          next.push_back({v[0] - (q & 1), v[1] - (q >> 1 & 1), v[2] - (q >> 2)});
      };
      for (const auto& square : kSquares) {
        const int a = state[square[0]], b = state[square[1]], c = state[square[2]],
                  d = state[square[3]];
        if (a && d && !b && !c) fill(square[1]);
        if (!a && !d && b && c) fill(square[0]);
      }
      int sum = 0;
      for (const int s : state) sum += s;
      if (sum != 2 && sum != 6) continue;
      const int odd = sum == 2 ? 1 : 0;
      for (int k = 0; k < 4; ++k)
        if (state[k] == odd && state[7 - k] == odd) {
          fill(odd == 1 ? k ^ 1 : k);
          break;
        }
    }
    cells.swap(next);
  }
}

SurfaceMesh VoxelSolid::boundary(Index min_samples, Index& dropped) const {
  dropped = 0;
  std::vector<Vec3> position;
  std::vector<Triangle> triangles;
  BrickIndex corners;  // reused as a map from lattice corners to vertices
  const auto vertex = [&](const Voxel& at) {
    const Index v = corners.insert(at);
    if (v == static_cast<Index>(position.size()))
      position.push_back(origin_ + size_ * Vec3(at[0], at[1], at[2]));
    return v;
  };
  // The face between the solid voxel v and its empty neighbour on that side, counter-clockwise from
  // outside.
  const auto emit = [&](const Voxel& v, int side) {
    const int axis = side / 2, u = (axis + 1) % 3, w = (axis + 2) % 3;
    const bool positive = side % 2 == 0;
    Voxel at = v;
    at[axis] += positive;
    Index quad[4];
    for (int k = 0; k < 4; ++k) {
      Voxel p = at;
      p[u] += k == 1 || k == 2;
      p[w] += k >= 2;
      quad[k] = vertex(p);
    }
    if (!positive) std::swap(quad[1], quad[3]);
    const int first = (v[0] + v[1] + v[2]) & 1;  // alternate the diagonals
    triangles.push_back({quad[first], quad[first + 1], quad[first + 2]});
    triangles.push_back({quad[first], quad[first + 2], quad[(first + 3) & 3]});
  };
  for (Index brick = 0; brick < bricks_.size(); ++brick)
    for (Index offset = 0; offset < BrickIndex::kVoxels; ++offset) {
      const Voxel v = voxel_in(bricks_.brick(brick), offset);
      const bool inside =
          state_[static_cast<std::size_t>(brick) * BrickIndex::kVoxels + offset] == solid;
      for (int side = 0; side < 6; ++side) {
        const Voxel other = v + kSides[side];
        if (inside) {
          if (state_of(other) == empty) emit(v, side);
        } else if (bricks_.find(BrickIndex::brick_of(other)) == kNone && state_of(other) == solid) {
          emit(other, side ^ 1);
        }
      }
    }
  if (triangles.empty()) return SurfaceMesh();

  SurfaceMesh mesh = SurfaceMesh::from_triangles(std::move(position), triangles);
  const MeshComponents components = connected_components(mesh);
  if (components.count > 1) {
    std::vector<Index> support(static_cast<std::size_t>(components.count), 0);
    for (const Vec3& p : cloud_.position) {
      const Voxel v = voxel_of(p);
      Index nearest = kNone;
      double least = 1e30;
      for (int reach = 1; reach <= 3 && nearest == kNone; ++reach)
        for (Index z = 1 - reach; z <= reach; ++z)
          for (Index y = 1 - reach; y <= reach; ++y)
            for (Index x = 1 - reach; x <= reach; ++x) {
              const Index at = corners.find({v[0] + x, v[1] + y, v[2] + z});
              if (at == kNone) continue;
              const double squared = (mesh.position[at] - p).squaredNorm();
              if (squared < least) {
                least = squared;
                nearest = at;
              }
            }
      if (nearest != kNone) ++support[components.of_vertex[nearest]];
    }
    const Index most = *std::max_element(support.begin(), support.end());
    const Index needed = std::min(min_samples, most);
    std::vector<Index> new_index(mesh.position.size(), kNone);
    std::vector<Vec3> kept;
    for (Index v = 0; v < mesh.vertex_slots(); ++v)
      if (support[components.of_vertex[v]] >= needed) {
        new_index[v] = static_cast<Index>(kept.size());
        kept.push_back(mesh.position[v]);
      }
    for (const Index count : support) dropped += count < needed;
    std::vector<Triangle> kept_triangles;
    for (Triangle triangle : triangles) {
      if (new_index[triangle[0]] == kNone) continue;
      for (Index& v : triangle) v = new_index[v];
      kept_triangles.push_back(triangle);
    }
    mesh = SurfaceMesh::from_triangles(std::move(kept), kept_triangles);
  }
  mesh.compact();
  return mesh;
}

}  // namespace shrinkwrap
