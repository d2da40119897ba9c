// Vocabulary shared by every stage: scalars, points, element indices, the frame, and the three
// kinds of error.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace shrinkwrap {

constexpr double kPi = 3.14159265358979323846;

using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;

/// Index of a vertex, half-edge or face of a SurfaceMesh, or of a sample in the order of a
/// PointCloud. 32 bits reach 10 million samples with room to spare (12 half-edges per sample while
/// re-tiling).
using Index = std::int32_t;
constexpr Index kNone = -1;

/// A sample named from the side of a mesh. A type of its own, so that a vertex index and the sample
/// that the vertex stands for cannot be mixed up: complete matching is a bijection between the two.
enum class SampleId : std::int32_t { none = -1 };
inline Index to_index(SampleId sample) {
  return static_cast<Index>(sample);
}
inline SampleId to_sample(Index index) {
  return static_cast<SampleId>(index);
}

/// The nearest point whose coordinates are at most `largest` in size, infinite ones too.
inline Vec3 clamped(const Vec3& p, double largest) {
  return p.cwiseMin(largest).cwiseMax(-largest);
}

/// The unit frame in which all stages work: moved to the origin and scaled by a power of two, so
/// that a cloud anywhere and of any size meets the same arithmetic. `unit_frame` chooses it so that
/// `to_unit` is exact.
struct Frame {
  Vec3 center = Vec3::Zero();
  double scale = 1.0;  ///< unit length per input length; a power of two
  Vec3 to_unit(const Vec3& p) const { return (p - center) * scale; }
  /// Back to the input's frame, on a lattice of 2^-44 of the unit: near zero a host's float is
  /// finer than what the way through the unit frame keeps, and without the lattice a second trip
  /// would give other bits than the first. Finite, also of a point beyond the largest doubles.
  Vec3 to_input(const Vec3& p) const {
    const double lattice = 0x1p-44 / scale;
    return clamped(((p / scale + center) / lattice).array().round() * lattice,
                   std::numeric_limits<double>::max());
  }
  double to_input_length(double length) const { return length / scale; }
};

/// The scalar in which the host stores mesh coordinates. Intermediate meshes are rounded to it when
/// one stage hands over to the next, so that stages run one by one through host layers and the
/// whole pipeline in one call give the same bytes.
enum class HostScalar { single_precision, double_precision };

/// The nearest doubles that single precision can hold, and finite. A function of its own because
/// GCC 12 vectorises a narrowing and the widening after it into nothing, whatever the language
/// says.
inline Vec3 rounded_to_single(const Vec3& p) {
  const Vec3 q = clamped(p, static_cast<double>(std::numeric_limits<float>::max()));
  const volatile float x = static_cast<float>(q.x()), y = static_cast<float>(q.y()),
                       z = static_cast<float>(q.z());
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

/// A point of the unit frame as it comes back from the host.
inline Vec3 rounded_to_host(const Vec3& p, const Frame& frame, HostScalar scalar) {
  const Vec3 input = frame.to_input(p);
  return frame.to_unit(scalar == HostScalar::single_precision ? rounded_to_single(input) : input);
}

/// Base of everything the library throws on purpose. `what()` names the problem and the remedy.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
/// The input or an option cannot be used; nothing was computed.
class InvalidInput : public Error {
 public:
  using Error::Error;
};
/// The caller's progress callback asked to stop.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled by the user") {}
};
/// The method ran but a guarantee does not hold; no mesh is returned.
class ReconstructionFailed : public Error {
 public:
  using Error::Error;
};

}  // namespace shrinkwrap
