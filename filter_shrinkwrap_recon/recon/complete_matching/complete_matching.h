// Section 2.5: every sample becomes a vertex, and every vertex a sample.
#pragma once

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct CompleteMatchingOptions {
  enum class Method {
    retile,  ///< insert the feet of all samples on the surface, remove what is no sample (Turk
             ///< 1992), lift
    snap_and_insert,  ///< the paper's: snap, eliminate, insert, swap - here by manifold-preserving
                      ///< operations only
  };
  Method method = Method::retile;
  /// What becomes of openings in the scan: places where the parametric surface is far from every
  /// sample.
  enum class Openings {
    close,       ///< faces between the samples around span them
    leave_open,  ///< border loops
    automatic,   ///< spanned up to a width, left open beyond (openings.h)
  };
  Openings openings = Openings::close;
  double widest_opening = 30.0;  ///< automatic: longest edge of the faces that span, x spacing
  double membrane_low = 2.0;     ///< x spacing: farther vertices belong to a membrane ...
  double membrane_high = 4.0;    ///< x spacing: ... if they are connected to one at least this far
  /// Distances are those from the samples of a vertex's own side: the back of a sheet, which no
  /// sample is on, is an opening however near the samples are. Thin walls whose two sides were not
  /// told apart then become sheets.
  bool backs_are_openings = false;
};

struct CompleteMatchingReport {
  double mean_foot_distance = 0.0;  ///< of the samples from the parametric surface, x spacing
  double max_foot_distance = 0.0;   ///< x spacing: above 2 the start was wrong somewhere
  Index membranes = 0;              ///< openings that were spanned or left open
  Index backs = 0;            ///< vertices of the surface on the back of sheets, and of no membrane
  Index notches_filled = 0;   ///< triangles that straighten the borders of those left open
  Index forced_removals = 0;  ///< removals that had to turn a face
  Index extra_vertices = 0;   ///< vertices that are no sample and could not be removed without harm
  Index cut_out = 0;  ///< such vertices that went in the end, with cuts that were parted again
};

/// A closed mesh whose vertices are the samples (then `extra_vertices` more, if any), at their
/// exact positions.
struct CompleteMatching {
  SurfaceMesh mesh;  ///< vertex i stands for sample_of_vertex[i]; retile: for sample i
  std::vector<SampleId>
      sample_of_vertex;  ///< SampleId::none for extra vertices; otherwise one to one
  /// Faces to be dropped in the end, ascending: where openings stay open (for `automatic` filled in
  /// by decide_openings).
  std::vector<Index> opening_faces;
  /// Faces that span openings, whether to be dropped or not, ascending: edge optimisation must
  /// leave them alone (a flip would spoil the border, or cut another face).
  std::vector<Index> spanning_faces;
  CompleteMatchingReport report;
};

/// Makes the complete matching from a parametric surface. The mesh is a closed 2-manifold after
/// every operation. Post: every sample is exactly one vertex; the topology is that of the surface,
/// but for components that hold no sample; bodies are the right side out unless they may be left
/// open. Throws ReconstructionFailed otherwise, InvalidInput if
/// the surface has no faces. O(N log N), for retile O(N) but for the tree search; parallel, the
/// same for any number of threads.
CompleteMatching match_samples(SurfaceMesh parametric, const PointCloud& cloud,
                               const CompleteMatchingOptions& options, Progress& progress);

}  // namespace shrinkwrap
