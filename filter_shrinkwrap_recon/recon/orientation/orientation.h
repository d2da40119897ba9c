// Which side of each sample is outside: propagation over a spanning tree, then one visibility vote
// per component; once more where all was seen from one side of the ground.
#pragma once

#include "orientation/crease_planes.h"
#include "orientation/disputed_signs.h"
#include "orientation/inverted_patches.h"
#include "orientation/pole_normals.h"
#include "orientation/spanning_forest.h"
#include "orientation/station.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct OrientationOptions {
  int propagation_neighbours = 10;  ///< edges per sample of the graph that carries orientation
  int plane_neighbours = 14;  ///< of the Gaussian mean that makes a tangent plane, itself included
  int view_directions = 96;   ///< orthographic depth buffers that vote
  double pixel_size = 1.5;    ///< of a depth buffer, x spacing of the samples that are drawn
  double min_cosine =
      0.5;  ///< a view votes on a sample only if |normal . direction| is at least this
  Index drawn_samples = 16000;  ///< of larger clouds a part is drawn, more if the votes are close
  double least_vote = 0.02;     ///< undecided below this part of the votes there could have been
  double least_visible = 0.02;  ///< hidden if this part or less of the possible votes was cast, or
                                ///< nearly all of them through other components
  double least_ground = 0.1;    ///< of the samples, a flat sheet that may be ground has at least;
                                ///< flat pieces of bodies have less, mostly; above 1: no ground
  Index propagation_samples =
      64000;                        ///< drawn, at most, for the views that have a say in signs ...
  Index judging_samples = 2000000;  ///< ... and for those that judge what came of it, from
  int judging_directions = 24;      ///< so many directions
  StationOptions station;
  PoleNormalOptions poles;
  SignOptions signs;
  DisputeOptions disputes;
  InvertedPatchOptions inverted;
  CreasePlaneOptions creases;
  double most_noise_at_creases = 0.06;  ///< of clouds with more (NeighbourGraph::noise) the planes
                                        ///< at edges stay as they are; negative: of all
};

struct OrientationReport {
  bool is_view = false;  ///< from the origin of the input, which the normals face
  Index components = 0;  ///< of the neighbour graph
  Index enclosed_components =
      0;  ///< nobody sees them from outside, but through others: walls of cavities, and the like
  Index undecided_components =
      0;  ///< no view tells: open sheets seen alike from both sides, ground (which counts as one)
  Vec3 ground = Vec3::Zero();  ///< which way ground faces (unit), from where all was seen then;
                               ///< zero if there is none, or not all was
  Index turned = 0;            ///< samples of hidden patches that were inside out
  Index poled = 0;             ///< samples whose normals became the ways to their poles
  Index creased = 0;           ///< samples whose planes became those of faces at an edge
  double closedness = 1.0;     ///< of the whole cloud: PointCloud::closedness
};

/// Gives the normals of the cloud a consistent outward sign. Before that, those of thin parts
/// become the ways to the poles of their samples (pole_normals.h). Signs are found along the
/// spanning tree of the surest edges (Hoppe et al. 1992, with another measure of sureness:
/// neighbour_graph.h). Set by set, where too much goes against them, they are replaced by those on
/// which all edges and views agree best (sign_agreement.h, disputed_signs.h). Where all was seen
/// from the origin of the input, as one view of a depth camera is (station.h), each connected
/// component of the graph then faces it on the whole, and each sample that is seen steeply. Else
/// one sign per component comes from visibility: the side that more orthographic views see is
/// outside. Components that nobody sees, or that are seen only through others
/// (VisibilityVote::foremost), are drawn again without those that were seen: where the winding
/// number of these says that they lie within the body they bound a cavity, else a body of their
/// own, in a cavity or behind others. At last hidden patches that contradict what they lie in are
/// turned (inverted_patches.h).
///
/// Views are trusted as far as a component is closed (VisibilityVote::trust): what stands on an
/// open sheet, such as the ground, hides its front. Of a sheet it counts too how convex it is, seen
/// by itself. A large flat one (component_shape.h) is taken for ground, of which no view tells, nor
/// of other sheets by themselves then. Sheets that are neither closed nor convex face where the
/// other components do on the whole, unless these have few samples, or +z (or +y, +x if they stand
/// upright). What is left undecided keeps the sign of the majority, however small. If the largest
/// of the flat sheets of which no view tells faces where all of the cloud does on the whole, signs
/// are then found once more, of the neighbours and of the components, by views from that side alone
/// (sample_views.h): nobody was behind it.
///
/// Then normals at edges become those of faces (crease_planes.h), unless samples are noisy or lie
/// on lines. Then computes the tangent planes. O(N) expected time but for the union-find and, where
/// there is ground, a search tree of O(N log N); O(N) memory, the same for any number of threads.
OrientationReport orient_normals(PointCloud& cloud, const OrientationOptions& options,
                                 Progress& progress);

/// The tangent planes alone, Gaussian means over so many `neighbours`. Pre: the normals are
/// oriented. O(N), parallel.
void measure_tangent_planes(PointCloud& cloud, int neighbours, Progress& progress);

}  // namespace shrinkwrap
