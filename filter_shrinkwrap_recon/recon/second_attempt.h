// Another mesh of the same samples where the first has faults: the better of the two is kept.
#pragma once

#include <functional>

#include "reconstruct.h"

namespace shrinkwrap {

/// A copy without the stages so far, which may hold meshes: what a second attempt begins with.
Reconstruction without_stages(Reconstruction& result);

/// Whether the repair of a mesh of so many faces tells of a wrong surface: faces still meet others,
/// or more than one in ten thousand did until they were annealed.
bool tells_of_wrong_surface(const RepairReport& repair, Index faces);

/// If `first` has faults (SecondAttempt), makes `second` by `make`, of the same samples, and keeps
/// the better of the two in `first`, with the time that both took; reports it as `which`. There is
/// a mesh already: that the second cannot be finished is no failure of the run. A cloud most of
/// whose faces are at fault shows no surface, and is left at that. Of the same surface
/// (`is_same_surface`) both have the genus, whatever openings then cut off: it is not compared, nor
/// how the meshes stand to the planes of the samples: they differ in what spans openings. `cloud`:
/// the samples; `make` may change their order and normals: both meshes are compared with the
/// normals from before. Pre: `second` has a stage only if `first` has one of that name.
void try_again(Reconstruction& first, Reconstruction& second, SecondAttempt Reconstruction::*which,
               bool is_same_surface, const PointCloud& cloud, Progress& progress,
               const std::function<void()>& make);

}  // namespace shrinkwrap
