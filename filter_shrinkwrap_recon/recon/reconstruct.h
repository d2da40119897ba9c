// The whole pipeline: from points to a closed 2-manifold with every sample as a vertex.
#pragma once

#include <string>
#include <vector>

#include "complete_matching/complete_matching.h"
#include "complete_matching/openings.h"
#include "edge_optimisation/edge_optimisation.h"
#include "edge_optimisation/intersection_repair.h"
#include "initial_mesh/initial_mesh.h"
#include "orientation/denoising.h"
#include "orientation/orientation.h"
#include "parametric_surface/control_mesh.h"
#include "parametric_surface/parametric_surface.h"
#include "report/mesh_report.h"
#include "report/promise.h"
#include "report/result_mesh.h"
#include "samples/noise.h"
#include "samples/outliers.h"
#include "samples/point_cloud.h"
#include "stop_at_surface/intersection_relaxation.h"
#include "stop_at_surface/samples_on_surface.h"

namespace shrinkwrap {

struct ReconstructionOptions {
  SampleOptions samples;
  OutlierOptions outliers;
  OrientationOptions orientation;
  NoiseOptions noise;
  MoreNoiseOptions more_noise;
  DenoisingOptions denoising;
  InitialMeshOptions initial_mesh;
  ControlMeshOptions control_mesh;
  ParametricSurfaceOptions parametric_surface;
  SamplesOnSurfaceOptions samples_on_surface;  ///< where the run stops at the parametric surface
  CompleteMatchingOptions complete_matching;
  EdgeOptimisationOptions edge_optimisation;
  RepairOptions intersection_repair;  ///< runs at the end of edge optimisation
  RelaxationOptions relaxation;  ///< instead of it where the run stops before, if it is enabled
  MeshReportOptions report;
  /// A surface from which more than this part of the samples is farther than their own spacing (and
  /// the noise) has lost detail, such as parts that are sampled far more closely than the rest. It
  /// is made anew, from four times as many control vertices, and then from as many as there are
  /// samples, and stays if it leaves a quarter fewer of them so far. 1: never; nor if the number of
  /// control vertices is given.
  double most_samples_far = 0.03;
  /// Points that single precision cannot hold come from no host of that precision: double is used.
  HostScalar host_scalar = HostScalar::single_precision;
  bool stop_at_parametric_surface =
      false;  ///< for noisy clouds: a smooth surface near the samples, closed or with openings
  /// Return the mesh of every stage too, the box before them if it is the start; the vertices of
  /// the complete matching and of the result then carry a quality: their distance from the
  /// parametric surface (input length).
  bool keep_stages = false;
  std::uint64_t memory_limit =
      0;            ///< bytes; 0: what the machine has available. More is refused beforehand
  int threads = 0;  ///< 0: as many as the machine has; the result does not depend on it
};

/// The paper's own choices, made manifold-preserving: box start, nearest-sample fitting, snap and
/// insert, quadrics.
ReconstructionOptions as_in_the_paper();

/// Whether the start is not the paper's: what is asked of the surface beyond it, is of such a run.
bool is_robust(const ReconstructionOptions& options);

struct StageRecord {
  std::string name;
  Index vertices = 0;
  double seconds = 0.0;
  ResultMesh mesh;       ///< only if keep_stages
  bool is_timed = true;  ///< false: a mesh that is given along, and no stage
};

/// What nobody wants in a mesh through the samples, and what tells of a wrong surface.
struct MatchingFaults {
  Index meeting = 0;         ///< faces that meet others, or did until they were annealed
  Index still_meeting = 0;   ///< of these, in the end
  Index extra_vertices = 0;  ///< that are no samples
  Index cut_out = 0;         ///< such as went with cuts (CompleteMatchingReport)
  double across = 0.0;       ///< share of the area (plane_agreement.h), if it was asked for
  /// What breaks the promise counts for five faces that were annealed.
  Index weight() const { return meeting + 4 * still_meeting + 5 * (extra_vertices + cut_out); }
  bool break_promise() const { return still_meeting + extra_vertices > 0; }
};

/// A mesh that has faults may get a second attempt, unless most of its faces are faulty. If one of
/// the two alone keeps the promise, that stays. If both do, and were made on different surfaces,
/// the one with less area across the planes of the samples stays, unless a tenth of either stands
/// across. Otherwise the second stays if its faults weigh less, with no more faces that still meet
/// others. One of another surface with more handles never stays.
struct SecondAttempt {
  bool is_made = false;
  bool is_finished = false;  ///< false: no mesh came of it
  bool is_taken = false;
  MatchingFaults first, second;  ///< of either mesh; `second` only if finished
};

/// Whether a surface showed what the samples do: see `ReconstructionOptions::most_samples_far`.
struct DetailReport {
  double far_at_first = 0.0;  ///< part of the samples that are far from the first surface
  double far = 0.0;           ///< the same of the surface that stays, before it is finished
  int surfaces = 0;           ///< that were made; 0: not looked at
};

/// Where a run stops at a parametric surface that does not show what its samples do: edges and thin
/// parts, of which samples tell more than a smooth surface with as many vertices.
struct SurfaceDetail {
  double upper_fifth = 0.0;      ///< a fifth of the samples are farther from it (x local spacing)
  double upper_twentieth = 0.0;  ///< and a twentieth
  bool is_kept = false;  ///< the vertices are the samples, each moved by what noise explains; but
                         ///< for near copies, of which only the mesh through every sample has any
  double mean_displacement = 0.0, max_displacement = 0.0;  ///< of these, x spacing
};

struct Reconstruction {
  /// Faces that span an opening carry their longest edge (x spacing) as quality, others 0; none has
  /// a quality if none spans. Vertex i is the i-th distinct sample that is no outlier, in the
  /// caller's order.
  ResultMesh mesh;
  std::vector<StageRecord> stages;  ///< the rows of table 1, in order, and what is not timed
  ConditioningReport conditioning;
  OutlierReport outliers;  ///< the samples that the promise leaves out
  OrientationReport orientation;
  NoiseEstimate noise;        ///< of the samples
  DenoisingReport denoising;  ///< of a noisy run that stops at the parametric surface
  InitialMeshReport initial_mesh;
  ControlMeshReport control_mesh;  ///< of the surface that stays
  ParametricSurfaceReport parametric_surface;
  DetailReport detail;
  CompleteMatchingReport complete_matching;
  OpeningsReport openings;
  EdgeOptimisationReport edge_optimisation;
  RepairReport intersection_repair;  ///< `remaining_faces` are faces of `mesh`
  RelaxationReport relaxation;       ///< of a run that stops at the parametric surface
  SurfaceDetail surface_detail;      ///< of such a run
  SecondAttempt smoothing;           ///< with a surface smoothed for the noise
  SecondAttempt backs;               ///< of sheets: their backs are openings
  MeshReport report;
  double spacing = 0.0;  ///< median sample spacing, input length
};

/// Runs every stage and checks the promise. Noise gives a surface through the samples handles and
/// folds: samples that are put back onto a surface that was smoothed for it stand side by side,
/// and the mesh has the topology of the object. Of clean but uneven samples that surface, made of
/// quadrics in place of planes, is often the better one too. So noisy clouds and those whose faces
/// meet may get a second attempt, and so may sheets, whose backs are openings then (see
/// SecondAttempt). Throws InvalidInput, Cancelled or ReconstructionFailed, and then nothing was
/// made. The same input and options give the same bytes, whatever the number of threads.
Reconstruction reconstruct(const std::vector<Vec3>& points, const ReconstructionOptions& options,
                           Progress& progress);

/// The scalar to which intermediate meshes are rounded: the options', or double precision if single
/// cannot hold the points.
HostScalar host_scalar_for(const std::vector<Vec3>& points, const ReconstructionOptions& options);

/// What a run with these options promises of its mesh.
PromiseOptions promise_of(const ReconstructionOptions& options);

/// The stages that a run with these options passes, for the construction of its Progress.
std::vector<Stage> stages_of(const ReconstructionOptions& options);

}  // namespace shrinkwrap
