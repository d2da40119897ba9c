// Views of a cloud, from all around or from one side of it, and what they tell of its samples.
#pragma once

#include <vector>

#include "orientation/orientation.h"

namespace shrinkwrap {

/// Draws samples from many directions. The cloud and the options are referred to.
class SampleViews {
 public:
  /// From all around.
  SampleViews(const PointCloud& cloud, const OrientationOptions& options);
  /// From where the ground faces, as nobody was behind it: from the directions within 90 degrees of
  /// `front`, a unit vector. A level and smooth sheet above other samples hides these from the
  /// views, though somebody saw them: from below it, as the ceiling of an arcade that a scanner
  /// stood in. (Crowns of trees are not smooth, and let pulses through.) So its samples may keep
  /// the sides that they have now: see keep_sides. Pre: oriented normals. O(N log N) but where very
  /// many samples lie above each other; the same for any number of threads.
  SampleViews(const PointCloud& cloud, const OrientationOptions& options, const Vec3& front,
              Progress& progress);

  bool are_from_one_side() const { return !front_.isZero(); }

  /// Of every so many-th sample, `most` at most; with the sides that some keep.
  SampleVotes draw_evenly(Index most, int directions, Progress& progress) const;
  /// Of samples, each of which stands for `stride`. See visibility_votes of components.
  SampleVotes draw(std::vector<Index> drawn, Index stride, int directions, Progress& progress,
                   const std::vector<Index>* component_of_sample = nullptr) const;
  /// The votes on samples of a sheet above others, from one side, say that they face where they
  /// did.
  void keep_sides(SampleVotes& samples) const;

 private:
  void find_sides_above_others(Progress& progress);
  double height_cosine(Index sample) const {
    return cloud_.normal[sample].cast<double>().dot(front_);
  }

  const PointCloud& cloud_;
  const OrientationOptions& options_;
  Vec3 front_ = Vec3::Zero();  // unit; zero: from all around
  /// Of each sample of a sheet above others, whether its normal was along `front` (1) or
  /// against it (-1); 0 of the others. Empty: from all around.
  std::vector<signed char> side_above_others_;
};

}  // namespace shrinkwrap
