// The objects whose surfaces are sampled: those of the unit tests, and others of a drawn thickness,
// many parts, hollows or extreme proportions.
#pragma once

#include <array>
#include <string>

#include "shapes.h"

namespace shrinkwrap::robustness {

/// A solid within the ball of `radius` about the origin, and what is known of its surface.
struct Solid {
  std::string name;
  int genus = 0;  ///< summed over the components
  int components = 1;
  bool closed = true;
  bool has_level_faces = false;  ///< faces z = const, between which scan lines pass
  bool has_limbs = false;  ///< seen from one side; beyond a limb a scan line may show its end alone
  double least_feature = 1.0;  ///< thinnest wall, gap or hole
  double radius = 1.0;
  testing::ImplicitFunction implicit;
  testing::SamplingDomain domain;
};

enum class SolidKind {
  sphere,
  torus,
  double_torus,
  box,
  thin_plate,
  bowl,
  two_spheres,
  blob,
  hemisphere,  ///< open
  wall,        ///< a plate with sharp edges of a drawn thickness
  slot,        ///< a block with a slot of a drawn width
  pipe,        ///< open at both ends, its wall of a drawn thickness: genus 1
  rod,         ///< very long: a capsule of a drawn radius
  disc,        ///< very flat: a rounded disc of a drawn thickness
  shell,       ///< a ball with a ball-shaped hollow: an inner and an outer surface
  nested,      ///< a ball in the hollow of another
  crowd,       ///< 48 balls, of which those in the middle are hidden
  few_balls,   ///< eight
  houses,      ///< open: flat ground with four flat houses, seen obliquely from above
  one_view,    ///< open: of the blob, what is seen from one side
};
constexpr int kSolidCount = 20;

/// `drawn` in [0, 1) says how thick the solids of a drawn thickness are, from thin to thick.
Solid solid_of(SolidKind kind, double drawn);

}  // namespace shrinkwrap::robustness
