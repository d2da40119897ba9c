// The clouds that are measured: sampled shapes, and real clouds thinned out or densified.
#pragma once

#include <string>
#include <vector>

#include "common/types.h"

namespace shrinkwrap::benchmarking {

/// What the command line says of the cloud: `--shape NAME --samples N` or
/// `--cloud FILE.ply [--samples N]`.
struct CloudChoice {
  std::string shape;
  std::string file;
  Index samples = 0;  ///< 0: all points of the file

  /// Takes over option `name` with its value; false if it is none of the above.
  /// Throws InvalidInput if the value cannot be used.
  bool take(const std::string& name, const std::string& value);
  std::string name() const;
};

/// The points of the choice, rounded to single precision as a host that stores floats would hand
/// them over. The same for the same choice. Throws InvalidInput if there is no such shape or file.
std::vector<Vec3> make_cloud(const CloudChoice& choice);

/// `count` points of the same object: a random part of the points or, if there are fewer, points
/// uniform by area on the parametric surface that is reconstructed from them.
std::vector<Vec3> resample(const std::vector<Vec3>& points, Index count);

/// Points of a PLY file with coordinates x, y, z in front of all other properties of its vertices:
/// binary little-endian or ASCII, float or double. Throws InvalidInput.
std::vector<Vec3> read_ply(const std::string& file);
/// Binary little-endian PLY; `as_double`: coordinates to the bit. Throws InvalidInput.
void write_ply(const std::string& file, const std::vector<Vec3>& points, bool as_double = false);

}  // namespace shrinkwrap::benchmarking
