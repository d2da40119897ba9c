// Generated clouds: everything about a case follows from its number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "attempt.h"
#include "json_line.h"
#include "solids.h"

namespace shrinkwrap::robustness {

enum class Sampling {
  random,
  blue_noise,
  scan_lines,  ///< on parallel planes, three times as far apart as the samples within one
  quantised,   ///< random, rounded to a lattice
  grid,        ///< where the lines of a cubic grid meet the surface
};
constexpr int kSamplingCount = 5;
const char* sampling_name(Sampling sampling);

/// What is asked of the reconstruction.
enum class Variant {
  standard,
  leave_open,
  stop_at_surface,
  as_in_the_paper,
  stop_and_leave_open,
  automatic_openings,
  genus_zero,    ///< imposed, whatever the genus of the solid
  every_sample,  ///< strays too are part of the surface
  keep_stages,
};
constexpr int kVariantCount = 9;
const char* variant_name(Variant variant);

struct Case {
  std::uint64_t number = 0;
  SolidKind solid = SolidKind::sphere;
  double drawn_thickness = 0.0;  ///< of solid_of
  Sampling sampling = Sampling::random;
  Variant variant = Variant::standard;
  Index count = 0;             ///< of samples aimed at
  double quantum = 0.0;        ///< of quantised samples, x spacing
  double noise = 0.0;          ///< deviation in each coordinate, x spacing
  double density_ratio = 1.0;  ///< of the densest to the thinnest side
  double detail_ratio = 1.0;   ///< of the density in a ball about a sample to that elsewhere
  double outliers = 0.0;       ///< fraction of the samples
  bool clustered = false;      ///< these lie together, several at a time
  bool rotated = false;        ///< nothing lies along an axis
  int scale_exponent = 0;      ///< scaled by ten to this
  Vec3 offset = Vec3::Zero();  ///< x size of the object
  bool single_precision = false;
};
Case case_of(std::uint64_t number);
ReconstructionOptions options_of(const Case& generated);

struct CaseCloud {
  std::vector<Vec3> points;
  Expectation expectation;
  double least_feature = 0.0;  ///< x spacing where the samples are farthest apart
};
/// A case is resolved if its samples lie within a tenth of a spacing of the surface (rounding
/// included), are at least 200, and if the thinnest wall, gap or hole measures at least 3 spacings
/// (4 unless they are spread evenly), where they are farthest apart; unless the run is that of the
/// paper, keeps strays, or may not show the solid's genus. Strays must be left out that are farther
/// than 4 of these spacings from every sample.
CaseCloud cloud_of(const Case& generated);

benchmarking::JsonLine describe(const Case& generated);

}  // namespace shrinkwrap::robustness
