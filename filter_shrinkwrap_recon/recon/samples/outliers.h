// Stray points: found before orientation, left out of the surface, and reported.
#pragma once

#include <vector>

#include "samples/point_cloud.h"

namespace shrinkwrap {

struct OutlierOptions {
  bool exclude = true;  ///< off: every distinct sample is part of the surface

  // What holds samples together, as in DBSCAN (Ester et al. 1996): core samples join sets, others
  // belong to the sets near them. Reaches are x the smaller local spacing of two samples.
  double reach = 2.5;            ///< between core samples
  double reach_of_others = 3.0;  ///< from a core sample to one that is none
  double reach_beyond = 1.5;     ///< from there to one further
  // A sample that is no core sample, and farther from one than `reach_off_plane` times the spacing
  // there, must lie about in its plane, or no farther off it than the surroundings are rough.
  double reach_off_plane = 1.5;
  double slope_of_others = 0.35;      ///< height over the plane, x distance, at most
  double deviations_of_others = 3.0;  ///< the same, x PointCloud::deviation of the core sample
  Index smallest_set = 30;  ///< samples; a hundredth of all where that is less, at least 4
  // A smaller set stays if it is as flat as a surface (`roughness`), dense enough, and goes on the
  // surface with any of its samples, as fins and fillets do; or, as the last lines of a scan, if it
  // is near and has the samples of a neighbourhood (SampleOptions::kUsualNeighbours).
  double spacing_of_flat_sets = 3.0;  ///< x median spacing, on average at most
  double reach_of_flat_sets = 1.5;    ///< x width of the set: from samples that stay
  double gap_of_flat_sets = 1.0;      ///< or x median spacing, if that is more
  /// No core sample has a spacing of more than this many times that of most of its neighbours ...
  double least_alike = 1.5;
  /// ... nor, if its spacing is more than this many times the median, may it be part of a haze of
  /// stray points that hold each other together:
  double sparse = 1.4;
  double roughness =
      0.23;           ///< mean deviation of neighbourhoods from their planes, x radius, at most
  double gap = 1.25;  ///< distance from the nearest neighbour, x its spacing, at most
  // Where many stray points are far apart, some meet this by chance. So sets of core samples that
  // are far sparser than the rest, and nearly as rough as is allowed at all, hold nothing, unless
  // they are many:
  double part_of_hazes = 0.1;      ///< of all samples: these sets together less than
  double spacing_of_haze = 8.0;    ///< x median spacing, on average more than
  double roughness_of_haze = 0.2;  ///< as `roughness`, on average more than

  // A sample that nothing holds stays if it lies in the planes of its neighbours, or near enough in
  // that of the nearest one that stays.
  double slope = 0.25;  ///< height over the plane of a neighbour, x distance from it, at most
  double reach_going_on = 2.0;  ///< x spacing of that one; the slope is of this too
  double support = 0.6;         ///< part of the neighbours of which that is true, at least
  // All planes go on beyond the edge of a sheet. A sample in those of its neighbours that is
  // farther than `gap_at_edge` times the spacing of the nearest stays only if another, stray or
  // not, lies on its other side, no farther than `reach_beyond_edge` times that distance, and about
  // in that plane: surfaces turn on so long a way.
  double gap_at_edge = 3.0;
  double reach_beyond_edge = 2.0;
  double slope_beyond_edge = 0.5;  ///< as `slope`

  // A sample that is held is stray if it juts out of a patch that is flat without it and surrounds
  // it: where a plane ends, a wall may stand. It is no corner, which lies in the planes of some of
  // its neighbours, by `slope`.
  double height = 1.0;             ///< over the plane of its neighbours, x their spacing, more than
  double height_deviations = 8.0;  ///< x their own deviation from that plane, more than
  double planes_of_corner = 0.2;   ///< part of its neighbours, less than
  double widest_turn = 2.2;        ///< radians from one neighbour to the next around it, less than
  // Stray points among them lift and tilt that plane. So the same is asked, more carefully, of the
  // one of their own planes that is best by a quantile of their heights over it; not where they are
  // closer than most, as along edges, whose samples lie in planes that no face has.
  double quantile = 0.6;
  double robust_height = 2.0;         ///< as `height`
  double robust_deviations = 20.0;    ///< x the quantile, more than
  double least_robust_spacing = 0.6;  ///< of its neighbours, x median spacing

  /// Once there is a mesh through the others, outliers are samples again that are nearer to it than
  /// so many times their distance from the nearest sample (outliers_on_surface.h).
  double foot = 0.25;
  double widest_gap = 4.0;  ///< that distance, x the larger of median and local spacing, at most

  // The parametric surface shows more of them (outliers_off_surface.h): samples off it, and farther
  // from each other than those around, which lie on it. Not those that most around have in their
  // planes (more than `support`, by `slope`).
  double off_surface = 1.0;        ///< distance, x spacing around, more than; infinite: none
  double noise_off_surface = 3.0;  ///< and so many times the noise more
  double spacing_off_it = 1.05;    ///< own spacing, x that around, more than
  double on_surface = 0.15;        ///< others: x that distance, at most
  double part_on_surface = 0.8;    ///< of the 15 nearest, at least

  FarStrayOptions far_strays;  ///< which are found before the samples are prepared

  /// If more than this part of the samples seems stray, none is left out: what is so frequent is
  /// how the cloud was taken.
  double most = 0.2;
  /// What is left is searched again, since stray points hide others, until nothing more is found.
  int most_rounds = 6;
};

struct OutlierReport {
  std::vector<Index> input_index;  ///< of the samples left out, ascending
  /// That seemed stray, near copies not counted: those that are neither left out nor `on_surface`
  /// stay, since they are too many, or the others would lie in a plane.
  Index suspected = 0;
  int rounds = 0;        ///< of the search
  Index on_surface = 0;  ///< that were left out, and are samples again: not among `input_index`
  /// Of `input_index`, those that the parametric surface showed, but for near copies that the cloud
  /// knew of; ascending.
  std::vector<Index> off_surface;
};

/// Leaves near copies out too of samples that a report says were left out.
void leave_out_copies(PointCloud& cloud, OutlierReport& report);

/// The stray samples of a cloud, ascending, found in one round. None of fewer than 64. Pre:
/// the cloud has as many neighbours as are usual, or more. O(N) expected, parallel,
/// the same for any number of threads.
std::vector<Index> find_outliers(const PointCloud& cloud, const OutlierOptions& options,
                                 Progress& progress);

/// Leaves stray samples out of a cloud: it becomes what it would have been had the
/// points never been there, but for `conditioning` and `input_index`, which still speak of all
/// points. So the rest of the points alone gives the same cloud. Pre: `cloud` was prepared from
/// `points`, with any number of neighbours: the search has the usual number, or, where samples lie
/// on lines, the greater of both. A cloud is not to be used if it was being searched when the run
/// was cancelled. Where no cloud would be left that has a surface (fewer than 4
/// samples, all in one plane), nothing is left out but the `far_strays`, which were before: the
/// report names them too.
OutlierReport exclude_outliers(PointCloud& cloud, const std::vector<Vec3>& points,
                               const OutlierOptions& options, Progress& progress,
                               const FarStrays& far_strays = {});

}  // namespace shrinkwrap
