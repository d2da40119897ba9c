// What the planes of samples say of the voxels around them.
#pragma once

#include <vector>

#include "common/progress.h"
#include "geometry/brick_keys.h"
#include "geometry/voxel_lattice.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

/// Sums over the samples that reach the voxels of a brick; by `BrickIndex::offset_of`.
struct BrickPlanes {
  float distance_sum[BrickIndex::kVoxels] = {};  ///< above the planes, weighted, x 1/s_i
  float weight_sum[BrickIndex::kVoxels] = {};    ///< 0 where no sample reaches
  /// Squared distance of the nearest, x 1/s_i^2; see PlaneFieldOptions::sideways.
  float nearest[BrickIndex::kVoxels];
};

/// x median spacing: no sample reaches farther than if it were so isolated. Where a dense part has
/// most of the samples, those elsewhere may be as far apart, and planes must meet between them.
constexpr double kGreatestSpacing = 16.0;

struct PlaneFieldOptions {
  /// x local spacing s_i, which counts as 16 median spacings at most; 1.75 voxels at least.
  double reach = 2.5;
  double least_spacing = 1.0;  ///< x median spacing: samples count as at least so far apart
  /// The square of a distance along the plane counts so many times more than that of one across it:
  /// beside its sample a plane is a guess, and a wrong one beyond an edge.
  double sideways = 0.0;
};

/// The tangent planes of all samples, each as far as its sample reaches and blended where several
/// do, binned by where and how far they reach: a brick is looked up in few bins even if the
/// spacings of the samples are very different.
class PlaneField {
 public:
  /// Pre: oriented normals. O(N) expected.
  PlaneField(const PointCloud& cloud, const VoxelLattice& lattice, const PlaneFieldOptions& options,
             Progress& progress);

  /// Of the bricks that samples reach, ascending.
  std::vector<BrickKey> keys_of_bricks_in_reach(Progress& progress) const;
  BrickPlanes planes_at(const Voxel& brick) const;

 private:
  // The plane of a sample; lengths in voxels, so that single precision will do.
  struct SamplePlane {
    Vec3f position;  // from the lowest corner of the bin that holds it
    Vec3f normal;
    float reach;
    float per_spacing;
  };
  // Samples that reach no farther than the edge of a bin.
  struct Level {
    int power = 0;  // of two: bricks along the edge of a bin
    Index edge() const { return BrickIndex::kEdge << power; }  // of a bin, in voxels
    BrickIndex bins;
    std::vector<Index> begin;        // per bin, and one more
    std::vector<SamplePlane> plane;  // by bin, in the order of the samples
    float greatest_reach = 0.0f;
  };

  class LevelMaker;
  static void add_bricks_in_reach(const Level& level, Index bin, std::vector<BrickKey>& reached);
  void add_plane(const SamplePlane& plane, const Vec3f& to_first, BrickPlanes& planes) const;

  float sideways_;
  std::vector<Level> levels_;  // of bins ever larger, without empty ones
};

}  // namespace shrinkwrap
