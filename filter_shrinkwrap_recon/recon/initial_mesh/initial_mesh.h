// Section 2.2: the initial mesh, a closed manifold around the samples, shrunk towards them.
#pragma once

#include "initial_mesh/false_handles.h"
#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct InitialMeshOptions {
  enum class Start {
    winding_number,  ///< boundary of a voxel solid: genus, cavities and components of the sampled
                     ///< object
    bounding_box,    ///< the paper's: a subdivided box, genus 0
  };
  Start start = Start::winding_number;

  // winding_number; lengths in median spacings s
  double voxel_size = 1.75;  ///< x s, 0.25 or more; but see `voxel_ratio_for_detail`
  /// Each sample stands for a square of its spacing (at most 16 s). Where these are more than so
  /// many squares of s for each sample, and `many_squares` in all, the boundary would be many times
  /// the samples: then s is wider here, so that they are as many.
  double squares_per_sample = 3.0;
  double many_squares = 8e5;
  double level =
      0.4;  ///< solid where the field exceeds it (0.5 makes false handles, 0.3 suits half scans)
  /// The same of open sheets, if it is lower; the less closed the cloud is
  /// (PointCloud::closedness), the nearer the level comes to this one. The winding number is a half
  /// just behind a sheet and falls from there, and is less behind its holes: the solid of a higher
  /// level is a thin slab, and shadows are holes through it.
  double level_of_sheets = 0.25;
  /// The boundary of a sheet may have tunnels, from what lies in shadow to its back. Levels each so
  /// many times as high are asked then, down to 0.08, as long as no more handles go than there are
  /// tunnels, and one that shows fewer handles, and as many bodies, is taken. 0: none is.
  double level_ratio_for_shadows = 0.7;
  double blend_begin =
      1.2;  ///< x local spacing: up to here from the samples the plane field alone decides
  double blend_end = 2.5;  ///< x local spacing: from here on the winding number alone decides
  double sideways = 0.0;   ///< distances along planes count more: see PlaneFieldOptions
  /// Parts whose samples are closer than this, x s, get voxels of half the size if the samples bear
  /// out what these show (voxel_refinement.h). 0: never.
  double dense_spacing = 0.65;
  FalseHandleOptions false_handles;
  /// Where the first solid has handles, false or not, a second one with voxels of this many times
  /// the size is made; the first stays unless the second has fewer that are left, or as many and
  /// fewer false ones, and as many parts (of larger voxels: as many bodies, as cavities between
  /// noisy layers are refuted too). 0: never.
  double second_voxel_ratio = 0.85;
  /// x voxel size, where close sheets have grown together: if more bodies are told apart then, at
  /// no more handles, as many cavities, and fewer samples have lost the solid behind them, on
  /// balance, than there are new bodies, that boundary is taken, and voxels are made smaller once
  /// more, down to 0.4 s. Not for sheets (PointCloud::closedness), whose gaps are to be bridged,
  /// nor where voxels of the usual size were taken as these show fewer handles. 0: never.
  double voxel_ratio_for_bodies = 0.7;
  double sideways_for_bodies = 2.0;  ///< `sideways` of these
  /// x voxel size, where samples are few for the shape: where more than `least_sharp` of them are
  /// sharp, as one of the six nearest faces another way by more than 45 degrees (an edge, a wall as
  /// thin as the samples are apart, a finger of a few samples around). The larger voxels are asked
  /// too if there are handles, and taken if they show fewer of them, also than are left once those
  /// in doubt were cut (cut_doubtful_handles) unless they show more bodies, and no fewer bodies.
  /// Not for sheets (PointCloud::closedness), whose gaps are to be bridged, nor for noise, which
  /// turns normals (`orient_and_smooth` sets this to 0). 0: never.
  double voxel_ratio_for_detail = 0.7;
  double least_sharp = 0.01;  ///< part of the samples
  Index maximum_genus = -1;   ///< handles beyond are cut (genus_limit.h); -1: as many as there are
  /// Solids and cavities supported by fewer samples are dropped. Not above the default, a hundredth
  /// of the samples is enough (4 at least), and in any case a quarter of what is typical.
  Index min_component_samples = 30;
  int shrink_iterations = 4;
  double step = 0.5;             ///< part of the way to the target per iteration
  double max_step = 0.7;         ///< x s
  int smoothing_iterations = 3;  ///< of the first iterations: full Laplacian of weight `smoothing`
  double smoothing = 0.5;
  double relaxation = 0.3;  ///< tangential weight of the later iterations

  // bounding_box: eq. 3 to 8
  int levels = -1;  ///< 1-to-4 subdivisions of the box; -1: the largest with at most N/4 vertices
  double projection = 0.85;     ///< xi of eq. 5
  double box_relaxation = 0.2;  ///< eta of eq. 8
  int iterations_per_level = 5;
};

struct InitialMeshReport {
  Index components = 0;  ///< of the solid
  Index cavities = 0;
  Index dropped = 0;  ///< solids and cavities with too few samples
  double samples_with_solid_behind =
      1.0;  ///< fraction that has solid 1 to 3 s behind it: below 0.999 is suspect
  /// Part of the samples with solid 1.5 or 2 s before them, where the nearest sample to the point
  /// 2 or 3.5 s before them faces them.
  double grown_together = 0.0;
  double voxel_size = 0.0;         ///< x s, of the solid that was taken; 0: none was made
  double spacing = 1.0;            ///< s as voxels suit it, x that of the cloud
  double sharp = 0.0;              ///< part of the samples: see `voxel_ratio_for_detail`
  bool is_of_detail_size = false;  ///< the voxels are smaller for these
  Index refined_parts = 0;         ///< dense parts with voxels of half that
  bool voxels_are_larger = false;  ///< than asked for, for that: see make_voxel_solid
  Index genus = 0;                 ///< of the mesh, summed over the components
  Index false_handles = 0;         ///< cut, as no samples bear them out
  Index false_mouths = 0;          ///< closed: the same, of tunnels into cavities
  Index bodies_parted = 0;         ///< by smaller voxels, that had grown together
  Index handles_refuted = 0;       ///< that one of several solids shows, and left out
  Index handles_cut = 0;           ///< to keep to `maximum_genus`
  int levels = 0;                  ///< bounding_box only
};

struct InitialMesh {
  SurfaceMesh mesh;  ///< closed 2-manifold, no removed slots
  InitialMeshReport report;
};

/// Makes the initial mesh. Pre: `orient_normals` was called on the cloud (winding_number only).
/// Post: closed, 2-manifold, consistently oriented outwards; for bounding_box genus 0.
/// Throws ReconstructionFailed if the surface over the openings of the cloud would be far larger
/// than what the samples show, and InvalidInput for voxels that are too small. O(N) expected.
InitialMesh make_initial_mesh(const PointCloud& cloud, const InitialMeshOptions& options,
                              Progress& progress);

}  // namespace shrinkwrap
