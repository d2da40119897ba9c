// Samples on the surface that was fitted to them, but for the detail that it does not show.
#pragma once

#include <vector>

#include "mesh/surface_mesh.h"
#include "samples/point_cloud.h"

namespace shrinkwrap {

struct SamplesOnSurfaceOptions {
  /// What denoising leaves of the noise around a sample, x that: `left`, and so many times the
  /// noise more. It is of one kind there, as the samples around were moved by the same others.
  double left = 0.3, left_per_noise = 6.0;
  /// A surface shows what its samples do unless a fifth of them are farther from it than so many
  /// times the noise, and a twentieth than this (x local spacing), in both cases less what the
  /// noise around them exceeds that of the others by.
  double farthest_fifth = 1.0, farthest_twentieth = 0.06;
};

struct SamplesOnSurface {
  std::vector<Vec3> position;    ///< one per sample, as the cloud's
  double upper_fifth = 0.0;      ///< a fifth of the samples were farther away (x local spacing)
  double upper_twentieth = 0.0;  ///< and a twentieth
  /// The same less what the noise around them exceeds that of the others by.
  double fifth_beyond_noise = 0.0, twentieth_beyond_noise = 0.0;
};

/// Moves the samples of a denoised cloud onto a surface that was fitted to them, along with which
/// what is left of their noise vanishes, and with it detail such as edges: smooth surfaces have
/// none. Therefore each moves by that part of the way which noise explains in the mean over the
/// samples around that face the same way (the empirical Wiener filter, as in denoising.h).
/// `noise`: `NoiseEstimate::of_others`. Pre: `is_denoised()`, a surface with faces. O(N log F),
/// parallel, the same for any number of threads. Throws Cancelled.
SamplesOnSurface move_onto_surface(const SurfaceMesh& surface, const PointCloud& cloud,
                                   double noise, const SamplesOnSurfaceOptions& options,
                                   Progress& progress);

/// Whether the surface shows what the samples do that were moved onto it, by these measures.
bool shows_its_samples(const SamplesOnSurface& samples, double noise,
                       const SamplesOnSurfaceOptions& options);

}  // namespace shrinkwrap
