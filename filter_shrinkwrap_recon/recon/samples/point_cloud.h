// The samples: conditioned, moved to the unit frame, in Morton order, with neighbours, spacing and
// normals.
#pragma once

#include <algorithm>
#include <vector>

#include "common/progress.h"
#include "common/types.h"
#include "geometry/voxel_search.h"
#include "samples/far_strays.h"
#include "samples/near_copies.h"
#include "samples/scan_lines.h"

namespace shrinkwrap {

/// What conditioning left out of the input.
struct ConditioningReport {
  std::size_t given = 0;
  std::size_t not_finite = 0;  ///< points with a NaN or infinite coordinate, left out
  std::size_t duplicates =
      0;  ///< points at the coordinates of an earlier one (-0 equals 0), left out
  std::size_t distinct = 0;  ///< samples: given - not_finite - duplicates
  /// The step from the coordinate farthest from the origin, of those that are no outliers, to the
  /// next that a float can hold, in input units; 0 if any has more digits than a float.
  double coordinate_step = 0.0;
  /// Of the samples, those that are no part of the cloud, since they lie where one that is does,
  /// but for a little: they become vertices at last (near_copy_insertion.h). Indices of points.
  std::vector<NearCopy> near_copies;
  /// The nearest neighbours of a sample lie on a line with it, as in slices: the lines beside are
  /// as far away as the farthest of its neighbours.
  bool on_lines = false;
  /// Neighbours per sample in place of those asked for, which lie on lines; 0: as asked for.
  int neighbours_across_lines = 0;
};

struct SampleOptions {
  /// Neighbours per sample, the sample itself among them (12 loses thin CAD walls, 16 keeps them).
  /// Where they would lie on one line, there are more: see scan_lines.h.
  int neighbours = kUsualNeighbours;
  static constexpr int kUsualNeighbours = 16;
  ScanLineOptions scan_lines;
  NearCopyOptions near_copies;
  /// Bytes that a run may take, looked at again where there are more neighbours; 0: what the
  /// machine has available.
  std::uint64_t memory_limit = 0;
  bool keeps_stages = false;  ///< so that it takes more: RunSize
};

/// An oriented plane near a sample: the point of the local surface and its unit normal (float: a
/// target, not data).
struct TangentPlane {
  Vec3f point;
  Vec3f normal;
};

/// Distinct samples in Morton order (a SampleId indexes every array) and what the stages need to
/// know of them. Built once by `prepare_samples`; read by all stages, from any thread.
class PointCloud {
 public:
  Frame frame;
  ConditioningReport conditioning;
  std::vector<Vec3> position;        ///< unit frame
  std::vector<Index> input_index;    ///< of each sample in the caller's array
  int neighbour_count = 0;           ///< k: at least min(SampleOptions::neighbours, N)
  std::vector<Index> neighbour;      ///< k per sample, nearest first; entry 0 is the sample itself
  std::vector<float> local_spacing;  ///< s_i = sqrt(pi/(k-1)) * distance to the k-th neighbour
  double spacing = 0.0;              ///< s: median of local_spacing
  /// That at a sample, but no less than the median.
  double spacing_at(Index sample) const {
    return std::max(spacing, static_cast<double>(local_spacing[sample]));
  }
  /// That among the samples beside it, but no more: the median of its neighbours. At the rim of an
  /// opening, where half of the neighbours are missing, samples seem up to 1.4 times as far apart
  /// as they are. O(k).
  double spacing_beside(Index sample) const;
  VoxelSearch search;            ///< of `position`
  std::vector<Vec3f> normal;     ///< of the plane that fits the k neighbours best, or of two
                                 ///< (parallel_sheets.h); sign arbitrary until `orient_normals`,
                                 ///< then, in thin parts, the way to the pole (pole_normals.h) and,
                                 ///< beside edges, of one face (crease_planes.h)
  std::vector<float> deviation;  ///< of the k neighbours from their plane, root mean square
  std::vector<TangentPlane>
      plane;  ///< after `orient_normals`: Gaussian mean of the compatible neighbours
  /// After `orient_normals`: 0 of an open sheet, such as the ground with what stands on it, most of
  /// which is seen from both sides (VisibilityVote::trust) and faces one way, 1 of bodies.
  double closedness = 1.0;
  /// After `measure_more_noise`: the noise around each sample that has more than the others, x its
  /// local spacing then, and 0 of the others. Else empty.
  std::vector<float> more_noise;
  /// That around a sample, given that of the others (either x the local spacing that there was
  /// when it was measured).
  double noise_at(Index sample, double of_others) const {
    return more_noise.empty() ? of_others : std::max<double>(of_others, more_noise[sample]);
  }
  /// After `denoise`, of each sample: its index before. Empty where samples are where the caller
  /// had them.
  std::vector<Index> index_before;

  /// Of a sample in the caller's array; from `size()` on, of a near copy.
  Index input_index_of(SampleId sample) const {
    const Index i = to_index(sample);
    return i < size() ? input_index[i] : conditioning.near_copies[i - size()].copy;
  }
  /// Of all samples, near copies after the others.
  std::vector<Index> input_indices() const;

  bool is_denoised() const { return !index_before.empty(); }  ///< see denoising.h
  Index size() const { return static_cast<Index>(position.size()); }
  const Index* neighbours_of(Index sample) const {
    return neighbour.data() + static_cast<std::size_t>(sample) * neighbour_count;
  }
};

/// The unit frame of a set of finite points: the largest half-extent of their bounding box in
/// (1/2, 1], their coordinates within 3. An axis along which the box is far from zero (farther than
/// half its extent) is centred, others are not moved: then `to_unit` rounds nothing (unless the
/// extent is near the least of all doubles), and what is exact in the unit frame is exact in the
/// input's.
Frame unit_frame(const std::vector<Vec3>& points);

/// What to do where `ConditioningReport::coordinate_step` is too large: the end of a message.
const char* advice_for_coarse_steps();

/// Conditions points (leaves out what is not finite and exact duplicates), orders them, and
/// computes neighbours, spacing and normals. Points are the caller's, in its own frame; they are
/// copied, never changed. Throws InvalidInput if fewer than 4 distinct points are left, or if all
/// are collinear or coplanar. `far_strays` are no samples, but `conditioning` speaks of them too.
/// O(N log N) comparisons at most, O(N) memory.
PointCloud prepare_samples(const std::vector<Vec3>& points, const SampleOptions& options,
                           Progress& progress, const FarStrays& far_strays = {});

/// Of the plane that fits some places best: how far the farthest is from it. O(N), parallel.
double height_over_plane(const std::vector<Vec3>& positions, Progress& progress);

/// Whether the samples lie in the unit frame exactly where they lie among the points that they were
/// prepared from; not so where coordinates are so small, beside others, that they vanish.
bool is_exact_in_unit_frame(const PointCloud& cloud, const std::vector<Vec3>& points,
                            Progress& progress);

/// Computes neighbours, spacing and normals anew, with another number of neighbours. The normals
/// are not oriented after that, and there are no planes. Pre: the cloud was prepared.
void measure_neighbourhoods(PointCloud& cloud, int neighbours, Progress& progress);

/// Some of the caller's points, where it had them: of a cloud's samples, given its `input_index`.
std::vector<Vec3> points_at(const std::vector<Vec3>& points, const std::vector<Index>& input_index);

}  // namespace shrinkwrap
