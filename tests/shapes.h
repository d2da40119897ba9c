// Shapes whose topology is known, to sample and to mesh: what the tests reconstruct.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/types.h"
#include "mesh/surface_mesh.h"

namespace shrinkwrap::testing {

/// Random numbers that are the same with every standard library and on every machine: the engine is
/// specified bit for bit, and what is made of its output needs no transcendental function.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }  ///< in [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  Index below(Index count);  ///< in [0, count)
  double gaussian();         ///< mean 0, deviation 1, within 6 (a sum of twelve uniforms)
  Vec3 in_cube();            ///< in [-1, 1)^3
  Vec3 direction();          ///< unit, uniform

 private:
  std::mt19937_64 engine_;
};

/// Negative inside, zero on the surface. Lipschitz constant at most 1, so that a ray may step on by
/// its absolute value.
using ImplicitFunction = std::function<double(const Vec3&)>;

/// Square roots are exact to the last bit everywhere; std::hypot is not.
double length_of(double x, double y);
/// Signed distance from a box about the origin.
double box_distance(const Vec3& p, const Vec3& half_extent);

/// Unit gradient at a point of the surface, by central differences.
Vec3 outward_normal(const ImplicitFunction& implicit, const Vec3& p);

/// Part of space in which a surface lies: a ball about the origin, of which `keep` may drop a part
/// (then the surface is open). No `keep`: everything.
struct SamplingDomain {
  double radius = 1.0;
  std::function<bool(const Vec3&)> keep;
};

struct ImplicitSamples {
  std::vector<Vec3> points;
  double area = 0.0;  ///< of the surface sampled, an estimate
};

/// Points uniformly distributed by area: where uniformly distributed random lines meet the surface
/// (Crofton). Any implicit surface will do; parts thinner than a thousandth of the radius may be
/// missed. Pre: the surface is not empty.
ImplicitSamples sample_implicit(const ImplicitFunction& implicit, const SamplingDomain& domain,
                                Index count, Random& random);

/// Points evenly spread over the surface: of many uniform samples, in random order, those that keep
/// a distance from all taken before; the distance falls until there are `count`.
ImplicitSamples sample_implicit_blue_noise(const ImplicitFunction& implicit,
                                           const SamplingDomain& domain, Index count,
                                           Random& random);

enum class ShapeKind {
  sphere,
  torus,
  double_torus,
  box,         ///< sharp edges, exactly planar faces along the axes
  thin_plate,  ///< a box of thickness 0.08 and width 1.2
  bowl,        ///< half a hollow sphere with a wall of 0.16 and a rounded rim: a deep cavity
  two_spheres,
  blob,        ///< a sphere with bumps and dents
  hemisphere,  ///< open: a cap of the unit sphere
};

/// Every kind, and every closed one.
const std::vector<ShapeKind>& all_shapes();
const std::vector<ShapeKind>& closed_shapes();

/// What is known about a shape. All lie within the ball of `radius` about the origin.
struct Shape {
  ShapeKind kind;
  std::string name;
  int genus;  ///< summed over the components
  int components;
  bool closed;
  double radius;

  double implicit(const Vec3& p) const;  ///< near the surface about the signed distance
  Vec3 normal(const Vec3& p) const;      ///< unit, outward
  SamplingDomain domain() const;
};
Shape shape_of(ShapeKind kind);

/// What happens to samples after they were taken; the defaults leave them on the surface.
struct SampleDefects {
  double noise = 0.0;     ///< deviation in every coordinate, x mean sample spacing
  double outliers = 0.0;  ///< fraction of the samples that are replaced by points of a box
                          ///< 1.5 times the bounding cube
  bool rotated = false;   ///< turned by a fixed rotation, so that nothing lies along an axis
};

/// `count` samples of a shape, uniform by area, in random order; the same for the same seed.
std::vector<Vec3> sample_shape(ShapeKind kind, Index count, unsigned seed,
                               const SampleDefects& defects = {});
/// Without outliers and not turned.
std::vector<Vec3> sample_noisy_shape(ShapeKind kind, Index count, unsigned seed, double noise);
/// As sample_shape, evenly spread.
std::vector<Vec3> sample_shape_blue_noise(ShapeKind kind, Index count, unsigned seed,
                                          const SampleDefects& defects = {});

/// The unit sphere sampled along lines of equal z, three times as far apart as the samples of a
/// line.
std::vector<Vec3> sample_sphere_on_scan_lines(Index count, unsigned seed);

/// The unit cube on a grid of 32 cells. The samples of `alone`, which come first, have no others
/// within 4.2 cells: close to an edge they are stray by all that distances tell, since many of the
/// samples around lie on the other face.
std::vector<Vec3> cube_with_gaps(const std::vector<Vec3>& alone);

/// The unit cube at random places, so many to a face, and after them twelve stray points, each
/// diagonally off the middle of an edge, 1.7 to 2.5 spacings away.
std::vector<Vec3> cube_with_strays_beside_edges(Index per_face, unsigned seed);

/// A ring that is cut open: genus 0. The gap between its ends measures so many sample spacings.
std::vector<Vec3> sample_cut_ring(Index count, double gap, unsigned seed);

/// A strip of uneven ground, `width` samples wide, seen from above: samples about one unit apart.
std::vector<Vec3> sample_strip(Index count, Index width, unsigned seed);

/// Evenly spread over a unit sphere, and `finer` times as closely over a spike on it, which is a
/// hundredth of the surface. `count`: of the sphere.
std::vector<Vec3> sample_spiked_ball(Index count, double finer = 10.0);

/// The unit sphere as an icosahedron whose faces were split into four `subdivisions` times:
/// 10 * 4^subdivisions + 2 vertices.
SurfaceMesh icosphere(int subdivisions);
/// Moved along the normal onto the plane through the origin: closed, and flat but for rounding.
SurfaceMesh flattened(SurfaceMesh mesh, const Vec3& normal);

/// Samples of a sphere about the origin, spread evenly along a spiral.
std::vector<Vec3> spiral_sphere(double radius, double spacing);
/// `scale` times as large, then moved.
SurfaceMesh placed(SurfaceMesh mesh, double scale, const Vec3& shift);
/// Meshes as one: its vertices and faces are theirs in turn.
SurfaceMesh joined(const std::vector<SurfaceMesh>& meshes);
/// Two unit spheres of which one cuts the other.
SurfaceMesh crossing_spheres(int subdivisions);
/// A mesh of the frame of the input in that of the samples.
SurfaceMesh in_frame(SurfaceMesh mesh, const Frame& frame);
/// The torus of `ShapeKind::torus` (radii 0.75 and 0.25, axis z), major x minor vertices. Pre: both
/// at least 3.
SurfaceMesh torus_mesh(int major_segments, int minor_segments);

}  // namespace shrinkwrap::testing
