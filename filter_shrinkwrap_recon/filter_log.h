// What filters say: lines of the log, and warnings where the result keeps the promise but may not
// be what the user wants.
#pragma once

#include <string>
#include <vector>

#include "filter_runs.h"

namespace shrinkwrap {

/// "1 face", "3 faces"; the second form for nouns with another plural.
std::string count_of(Index count, const std::string& noun);
std::string count_of(Index count, const std::string& one, const std::string& several);

/// One number by a printf format of less than 64 characters.
std::string formatted(const char* format, double value);

// Lines.
std::string table_row(const std::string& stage, Index vertices, double seconds);
std::string conditioning_line(const ConditioningReport& report, double spacing);

/// Where single precision has taken digits from the coordinates that tell at this spacing, and what
/// to do; empty elsewhere.
std::string coordinate_step_line(const ConditioningReport& report, double spacing);
std::string detail_line(const InitialMeshReport& report);
std::string dense_parts_line(const InitialMeshReport& report);
std::string repair_line(const RepairReport& report);
std::string folds_line(const FoldReport& report);
std::string relaxation_line(const RelaxationReport& report);
std::string openings_line(const OpeningsReport& report);

// Parts of lines.
std::string notches_filled(Index count);
std::string verdict_of(const MeshReport& report);
/// Of a surface near the samples, which need not be vertices of it.
std::string verdict_on_surface(const MeshReport& report);
std::string but_outliers(const OutlierReport& report);

/// The verdict of a stage that makes a surface.
std::string surface_verdict(const char* what, const SurfaceMesh& mesh);
/// Of a surface whose detail is kept, so that it is the mesh of samples.
std::string detail_verdict(const char* what, const ResultMesh& mesh);

void warn_of(const OrientationReport& report, std::vector<std::string>& warnings);
void warn_of(const InitialMeshReport& report, std::vector<std::string>& warnings);
void warn_of(const CompleteMatchingReport& report, std::vector<std::string>& warnings);
void warn_of_intersections(Index faces_left, std::vector<std::string>& warnings);
/// Of a choice for openings that the paper's method cannot follow.
void warn_of_openings(const ReconstructionOptions& options, std::vector<std::string>& warnings);
/// Of a mesh that has vertices enough already.
void warn_of_subdivision(const ParametricSurfaceReport& report, Index samples,
                         std::vector<std::string>& warnings);

/// How noisy the samples are, what was done about it, and what would suit them better, as far as
/// `filter` can do it.
void tell_of_noise(Filter filter, const NoiseEstimate& noise, const DenoisingReport& denoising,
                   const ReconstructionOptions& options, FilterOutcome& outcome);
/// That the mesh faces the origin, if all was seen from there.
void tell_of_view(const OrientationReport& report, FilterOutcome& outcome);
/// Which choice for openings suits an open sheet, where all were closed.
void tell_of_sheet(const OrientationReport& report, const ReconstructionOptions& options,
                   FilterOutcome& outcome);
/// What came of second attempts, if any were made.
void tell_of_attempts(const Reconstruction& result, FilterOutcome& outcome);
/// If the surface was made again because it had lost detail, with which control mesh; warns if the
/// surface that stays has lost much.
void tell_of_detail(const Reconstruction& result, FilterOutcome& outcome);
/// If the vertices of a surface that missed detail are the samples, how far these have moved.
void tell_of(const SurfaceDetail& detail, FilterOutcome& outcome);
/// How many samples were left out as outliers.
void tell_of(const OutlierReport& report, FilterOutcome& outcome);

}  // namespace shrinkwrap
