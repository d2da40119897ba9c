#include "shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace shrinkwrap::testing {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTorusMajor = 0.75, kTorusMinor = 0.25;

double torus_distance(const Vec3& p, double major, double minor) {
  return length_of(length_of(p.x(), p.y()) - major, p.z()) - minor;
}

double smooth_minimum(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - 0.25 * width * h * h;
}

double bowl_distance(const Vec3& p) {
  constexpr double radius = 0.85, wall = 0.08;  // the wall is twice that thick
  const double across = length_of(p.x(), p.y());
  const double to_middle = p.z() <= 0.0 ? std::abs(length_of(across, p.z()) - radius)
                                        : length_of(across - radius, p.z());
  return to_middle - wall;
}

double blob_distance(const Vec3& p) {
  struct Bump {
    double x, y, z, height;
  };
  static constexpr Bump bumps[] = {
      {0.9, 0.3, 0.3, 0.17},  {-0.7, 0.6, 0.4, -0.15}, {0.1, -0.9, 0.4, 0.14},
      {-0.2, 0.3, -0.9, 0.2}, {0.5, 0.7, -0.5, -0.14}, {-0.8, -0.5, -0.3, 0.16},
      {0.2, 0.1, 1.0, -0.16}, {0.6, -0.6, -0.5, 0.12}, {-0.1, 0.95, 0.3, 0.13},
  };
  const double r = p.norm();
  if (r < 1e-9) return -0.6 * 0.8;
  double relief = 0.0;
  for (const Bump& bump : bumps) {
    const Vec3 axis(bump.x, bump.y, bump.z);
    const double t = (p.dot(axis) / (r * axis.norm()) - 0.65) / 0.35;
    if (t > 0.0) relief += bump.height * t * t * (3.0 - 2.0 * t);
  }
  // Well below the surface the relief fades, for there a small step turns the direction a lot.
  return 0.6 * (r - 0.8 - relief * std::min(r / 0.6, 1.0));
}

// Where the line from `begin` along `direction` meets the surface within `length`, in order.
template <class Visit>
void for_each_crossing(const ImplicitFunction& implicit, const Vec3& begin, const Vec3& direction,
                       double length, double least_step, const Visit& visit) {
  double t = 0.0, value = implicit(begin);
  while (t < length) {
    const double next_t = std::min(t + std::max(std::abs(value), least_step), length);
    const double next_value = implicit(begin + next_t * direction);
    if ((value < 0.0) != (next_value < 0.0)) {
      double low = t, high = next_t;
      double f_low = value, f_high = next_value;
      for (int i = 0; i < 60 && high - low > 1e-15 * length; ++i) {
        // The secant, and every third time the middle, which makes sure that the interval shrinks.
        const double secant = low + (high - low) * (f_low / (f_low - f_high));
        const bool inside = secant > low && secant < high;
        const double middle = i % 3 == 2 || !inside ? 0.5 * (low + high) : secant;
        const double f = implicit(begin + middle * direction);
        if (f == 0.0) {
          low = high = middle;
        } else if ((f < 0.0) == (f_low < 0.0)) {
          low = middle;
          f_low = f;
        } else {
          high = middle;
          f_high = f;
        }
      }
      visit(begin + 0.5 * (low + high) * direction);
    }
    t = next_t;
    value = next_value;
  }
}

// Points in cells of a fixed edge, found through a hash of the cell.
class PointGrid {
 public:
  PointGrid(Index expected, double cell) : cell_(cell) {
    std::size_t slots = 64;
    while (slots < static_cast<std::size_t>(expected) * 2) slots *= 2;
    head_.assign(slots, kNone);
  }
  bool is_free(const Vec3& p, double distance) const {
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          for (Index i = head_[slot(p, dx, dy, dz)]; i != kNone; i = next_[i])
            if ((point_[i] - p).squaredNorm() < distance * distance) return false;
    return true;
  }
  void insert(const Vec3& p) {
    Index& head = head_[slot(p, 0, 0, 0)];
    next_.push_back(head);
    head = static_cast<Index>(point_.size());
    point_.push_back(p);
  }
  std::vector<Vec3> take_points() { return std::move(point_); }
  Index size() const { return static_cast<Index>(point_.size()); }

 private:
  std::size_t slot(const Vec3& p, int dx, int dy, int dz) const {
    const auto cell = [&](int axis, int shift) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(p[axis] / cell_)) +
                                        shift);
    };
    std::uint64_t hash = cell(0, dx) * 0x9e3779b97f4a7c15ull;
    hash = (hash ^ cell(1, dy)) * 0xc2b2ae3d27d4eb4full;
    hash = (hash ^ cell(2, dz)) * 0x165667b19e3779f9ull;
    return static_cast<std::size_t>(hash >> 20) & (head_.size() - 1);
  }

  double cell_;
  std::vector<Vec3> point_;
  std::vector<Index> head_, next_;
};

std::vector<Vec3> with_defects(ImplicitSamples samples, double radius, const SampleDefects& defects,
                               Random& random) {
  std::vector<Vec3> points = std::move(samples.points);
  const double spacing =
      std::sqrt(samples.area / std::max(static_cast<double>(points.size()), 1.0));
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(0.83, 0.21, 0.34, 0.39).normalized().toRotationMatrix();
  for (Vec3& p : points) {
    if (defects.outliers > 0.0 && random.uniform() < defects.outliers)
      p = 1.5 * radius * random.in_cube();
    if (defects.noise > 0.0)
      for (int axis = 0; axis < 3; ++axis) p[axis] += defects.noise * spacing * random.gaussian();
    if (defects.rotated) p = rotation * p;
  }
  return points;
}

}  // namespace

double length_of(double x, double y) {
  return std::sqrt(x * x + y * y);
}

double box_distance(const Vec3& p, const Vec3& half_extent) {
  const Vec3 q = p.cwiseAbs() - half_extent;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Index Random::below(Index count) {
  return std::min(static_cast<Index>(uniform() * static_cast<double>(count)), count - 1);
}

double Random::gaussian() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

Vec3 Random::in_cube() {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = uniform(-1.0, 1.0);
  return p;
}

Vec3 Random::direction() {
  while (true) {
    const Vec3 p = in_cube();
    const double squared = p.squaredNorm();
    if (squared <= 1.0 && squared > 1e-4) return p / std::sqrt(squared);
  }
}

Vec3 outward_normal(const ImplicitFunction& implicit, const Vec3& p) {
  constexpr double step = 1e-5;
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 ahead = p, behind = p;
    ahead[axis] += step;
    behind[axis] -= step;
    gradient[axis] = implicit(ahead) - implicit(behind);
  }
  return gradient.normalized();
}

ImplicitSamples sample_implicit(const ImplicitFunction& implicit, const SamplingDomain& domain,
                                Index count, Random& random) {
  ImplicitSamples samples;
  samples.points.reserve(count);
  const double radius = domain.radius;
  std::uint64_t lines = 0, hits = 0;
  while (hits < static_cast<std::uint64_t>(count)) {
    ++lines;
    const Vec3 direction = random.direction();
    // The foot of the line, uniform in the disc across it.
    double x, y;
    do {
      x = random.uniform(-1.0, 1.0);
      y = random.uniform(-1.0, 1.0);
    } while (x * x + y * y >= 1.0);
    const Vec3 aside = direction.unitOrthogonal();
    const Vec3 foot = radius * (x * aside + y * direction.cross(aside));
    const double half_chord = radius * std::sqrt(1.0 - x * x - y * y);
    for_each_crossing(implicit, foot - half_chord * direction, direction, 2.0 * half_chord,
                      1e-3 * radius, [&](const Vec3& p) {
                        if (domain.keep && !domain.keep(p)) return;
                        ++hits;
                        if (static_cast<Index>(samples.points.size()) < count)
                          samples.points.push_back(p);
                      });
  }
  // A random line through the ball meets its sphere, of area 4 pi r^2, twice.
  samples.area = 2.0 * kPi * radius * radius * static_cast<double>(hits) /
                 static_cast<double>(std::max<std::uint64_t>(lines, 1));
  return samples;
}

ImplicitSamples sample_implicit_blue_noise(const ImplicitFunction& implicit,
                                           const SamplingDomain& domain, Index count,
                                           Random& random) {
  if (count <= 0) return {};
  constexpr Index candidates_per_sample = 8;
  const ImplicitSamples candidates =
      sample_implicit(implicit, domain, candidates_per_sample * count, random);
  // Starts a little below the distance of a hexagonal packing, which random darts never reach.
  double distance = 0.8 * std::sqrt(2.0 * candidates.area / (std::sqrt(3.0) * count));
  PointGrid grid(count, distance);
  std::vector<bool> taken(candidates.points.size(), false);
  for (; grid.size() < count; distance *= 0.97)
    for (std::size_t i = 0; i < taken.size() && grid.size() < count; ++i)
      if (!taken[i] && grid.is_free(candidates.points[i], distance)) {
        taken[i] = true;
        grid.insert(candidates.points[i]);
      }
  return {grid.take_points(), candidates.area};
}

const std::vector<ShapeKind>& all_shapes() {
  static const std::vector<ShapeKind> kinds = {
      ShapeKind::sphere,      ShapeKind::torus,      ShapeKind::double_torus,
      ShapeKind::box,         ShapeKind::thin_plate, ShapeKind::bowl,
      ShapeKind::two_spheres, ShapeKind::blob,       ShapeKind::hemisphere};
  return kinds;
}

const std::vector<ShapeKind>& closed_shapes() {
  static const std::vector<ShapeKind> kinds(all_shapes().begin(), all_shapes().end() - 1);
  return kinds;
}

Shape shape_of(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::sphere:
      return {kind, "sphere", 0, 1, true, 1.05};
    case ShapeKind::torus:
      return {kind, "torus", 1, 1, true, 1.05};
    case ShapeKind::double_torus:
      return {kind, "double_torus", 2, 1, true, 1.45};
    case ShapeKind::box:
      return {kind, "box", 0, 1, true, 0.9};
    case ShapeKind::thin_plate:
      return {kind, "thin_plate", 0, 1, true, 0.8};
    case ShapeKind::bowl:
      return {kind, "bowl", 0, 1, true, 1.0};
    case ShapeKind::two_spheres:
      return {kind, "two_spheres", 0, 2, true, 1.1};
    case ShapeKind::blob:
      return {kind, "blob", 0, 1, true, 1.05};
    case ShapeKind::hemisphere:
      break;
  }
  return {ShapeKind::hemisphere, "hemisphere", 0, 1, false, 1.05};
}

double Shape::implicit(const Vec3& p) const {
  switch (kind) {
    case ShapeKind::sphere:
    case ShapeKind::hemisphere:
      return p.norm() - 1.0;
    case ShapeKind::torus:
      return torus_distance(p, kTorusMajor, kTorusMinor);
    case ShapeKind::double_torus:
      return smooth_minimum(torus_distance(p - Vec3(-0.62, 0.0, 0.0), 0.6, 0.17),
                            torus_distance(p - Vec3(0.62, 0.0, 0.0), 0.6, 0.17), 0.08);
    case ShapeKind::box:
      return box_distance(p, {0.6, 0.45, 0.35});
    case ShapeKind::thin_plate:
      return box_distance(p, {0.6, 0.45, 0.04});
    case ShapeKind::bowl:
      return bowl_distance(p);
    case ShapeKind::two_spheres:
      return std::min((p - Vec3(-0.55, 0.0, 0.0)).norm() - 0.5,
                      (p - Vec3(0.6, 0.1, 0.2)).norm() - 0.4);
    case ShapeKind::blob:
      break;
  }
  return blob_distance(p);
}

Vec3 Shape::normal(const Vec3& p) const {
  return outward_normal([this](const Vec3& q) { return implicit(q); }, p);
}

SamplingDomain Shape::domain() const {
  if (closed) return {radius, {}};
  return {radius, [](const Vec3& p) { return p.z() >= 0.0; }};
}

std::vector<Vec3> sample_shape(ShapeKind kind, Index count, unsigned seed,
                               const SampleDefects& defects) {
  const Shape shape = shape_of(kind);
  Random random(seed);
  ImplicitSamples samples = sample_implicit([&](const Vec3& p) { return shape.implicit(p); },
                                            shape.domain(), count, random);
  return with_defects(std::move(samples), shape.radius, defects, random);
}

std::vector<Vec3> sample_noisy_shape(ShapeKind kind, Index count, unsigned seed, double noise) {
  SampleDefects defects;
  defects.noise = noise;
  return sample_shape(kind, count, seed, defects);
}

std::vector<Vec3> sample_shape_blue_noise(ShapeKind kind, Index count, unsigned seed,
                                          const SampleDefects& defects) {
  const Shape shape = shape_of(kind);
  Random random(seed);
  ImplicitSamples samples = sample_implicit_blue_noise(
      [&](const Vec3& p) { return shape.implicit(p); }, shape.domain(), count, random);
  return with_defects(std::move(samples), shape.radius, defects, random);
}

std::vector<Vec3> sample_sphere_on_scan_lines(Index count, unsigned seed) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, count, seed);
  const double distance = std::sqrt(3.0 * 4.0 * 3.14159265358979323846 / count);
  for (Vec3& p : points) {
    const double z = distance * (std::floor(p.z() / distance) + 0.5);
    const double part = std::sqrt(std::max(0.0, 1.0 - z * z) / (p.x() * p.x() + p.y() * p.y()));
    p = {part * p.x(), part * p.y(), z};
  }
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const Vec3& p) { return std::abs(p.z()) >= 1.0; }),
               points.end());
  return points;
}

std::vector<Vec3> cube_with_gaps(const std::vector<Vec3>& alone) {
  constexpr int kCells = 32;
  constexpr double kGap = 4.2 / kCells;
  std::vector<Vec3> points = alone;
  for (int i = 0; i <= kCells; ++i)
    for (int j = 0; j <= kCells; ++j)
      for (int k = 0; k <= kCells; ++k) {
        if (i % kCells != 0 && j % kCells != 0 && k % kCells != 0) continue;
        const Vec3 p = Vec3(i, j, k) / kCells;
        if (std::all_of(alone.begin(), alone.end(),
                        [&](const Vec3& a) { return (p - a).norm() > kGap; }))
          points.push_back(p);
      }
  return points;
}

std::vector<Vec3> cube_with_strays_beside_edges(Index per_face, unsigned seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int face = 0; face < 6; ++face)
    for (Index i = 0; i < per_face; ++i) {
      Vec3 p = 0.5 * (random.in_cube() + Vec3::Ones());
      p[face % 3] = face / 3;
      points.push_back(p);
    }
  for (int edge = 0; edge < 12; ++edge) {
    const double h = (1.2 + 0.05 * edge) / std::sqrt(per_face);
    Vec3 p = Vec3::Constant(0.5);
    p[(edge + 1) % 3] = edge % 2 == 0 ? -h : 1.0 + h;
    p[(edge + 2) % 3] = edge < 6 ? -h : 1.0 + h;
    points.push_back(p);
  }
  return points;
}

std::vector<Vec3> sample_cut_ring(Index count, double gap, unsigned seed) {
  constexpr double kMajor = 0.7, kMinor = 0.2, kArea = 4.0 * kPi * kPi * kMajor * kMinor;
  const double half_gap = 0.5 * gap * std::sqrt(kArea / count);
  const auto ring = [&](const Vec3& p) {
    const double to_circle = std::sqrt(p.x() * p.x() + p.y() * p.y()) - kMajor;
    const double tube = std::sqrt(to_circle * to_circle + p.z() * p.z()) - kMinor;
    const double slot = p.x() > 0.0 ? half_gap - std::abs(p.y()) : -1.0;
    return 0.8 * std::max(tube, slot);
  };
  Random random(seed);
  return sample_implicit(ring, {}, count, random).points;
}

std::vector<Vec3> sample_strip(Index count, Index width, unsigned seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (Index i = 0; i < count; ++i) {
    const double x = i / width + random.uniform(-0.3, 0.3),
                 y = i % width + random.uniform(-0.3, 0.3);
    points.push_back({x, y, 0.6 * std::sin(0.4 * x) * std::cos(0.5 * y)});
  }
  return points;
}

std::vector<Vec3> sample_spiked_ball(Index count, double finer) {
  constexpr double kFoot = 0.95, kLength = 0.6, kRadius = 0.1;
  // Along x, turned by the golden angle from one to the next.
  const auto spiral = [](Index samples, const auto& radius_and_height) {
    std::vector<Vec3> points;
    Eigen::Vector2d direction(1.0, 0.0);
    for (Index i = 0; i < samples; ++i) {
      const auto [radius, height] = radius_and_height((i + 0.5) / samples);
      points.push_back({height, radius * direction.x(), radius * direction.y()});
      constexpr double kCosine = -0.73736887807831968, kSine = 0.67549029426152375;
      direction = {kCosine * direction.x() - kSine * direction.y(),
                   kSine * direction.x() + kCosine * direction.y()};
    }
    return points;
  };
  using RadiusAndHeight = std::pair<double, double>;
  std::vector<Vec3> points;
  for (const Vec3& p : spiral(count, [](double part) {
         const double height = 1.0 - 2.0 * part;
         return RadiusAndHeight(std::sqrt(1.0 - height * height), height);
       }))
    if (std::hypot(p.y(), p.z()) > kRadius || p.x() < 0.0) points.push_back(p);
  const double of_sphere = count / (4.0 * kPi);  // samples per unit area
  const auto on_spike = static_cast<Index>(kPi * kRadius * kLength * finer * finer * of_sphere);
  for (const Vec3& p : spiral(on_spike, [&](double part) {
         const double from_tip = std::sqrt(part);
         return RadiusAndHeight(kRadius * from_tip, kFoot + kLength * (1.0 - from_tip));
       }))
    if (p.norm() > 1.0) points.push_back(p);
  return points;
}

std::vector<Vec3> spiral_sphere(double radius, double spacing) {
  const int count = static_cast<int>(4.0 * kPi * radius * radius / (spacing * spacing));
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, angle = i * (3.0 - std::sqrt(5.0)) * kPi;
    const double ring = std::sqrt(1.0 - z * z);
    points.emplace_back(radius * Vec3(ring * std::cos(angle), ring * std::sin(angle), z));
  }
  return points;
}

SurfaceMesh icosphere(int subdivisions) {
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vec3> position;
  for (double one : {-1.0, 1.0})
    for (double phi : {-golden, golden}) {
      position.push_back({0.0, one, phi});
      position.push_back({one, phi, 0.0});
      position.push_back({phi, 0.0, one});
    }
  // Neighbours lie at distance 2; counter-clockwise is away from the centre.
  std::vector<Triangle> faces;
  const auto adjacent = [&](Index a, Index b) {
    return (position[a] - position[b]).squaredNorm() < 4.1;
  };
  for (Index a = 0; a < 12; ++a)
    for (Index b = a + 1; b < 12; ++b)
      for (Index c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(c, a)) continue;
        const bool outward = position[a].dot(position[b].cross(position[c])) > 0.0;
        faces.push_back(outward ? Triangle{a, b, c} : Triangle{a, c, b});
      }
  for (Vec3& p : position) p.normalize();
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<Index, Index>, Index> middle_of_edge;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] = middle_of_edge.try_emplace({std::min(a, b), std::max(a, b)},
                                                              static_cast<Index>(position.size()));
      if (is_new) position.push_back((position[a] + position[b]).normalized());
      return entry->second;
    };
    std::vector<Triangle> finer;
    finer.reserve(4 * faces.size());
    for (const auto& [a, b, c] : faces) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.push_back({a, ab, ca});
      finer.push_back({b, bc, ab});
      finer.push_back({c, ca, bc});
      finer.push_back({ab, bc, ca});
    }
    faces = std::move(finer);
  }
  return SurfaceMesh::from_triangles(std::move(position), faces);
}

SurfaceMesh flattened(SurfaceMesh mesh, const Vec3& normal) {
  for (Vec3& p : mesh.position) p -= normal * (normal.dot(p) / normal.squaredNorm());
  return mesh;
}

SurfaceMesh placed(SurfaceMesh mesh, double scale, const Vec3& shift) {
  for (Vec3& p : mesh.position) p = scale * p + shift;
  return mesh;
}

SurfaceMesh joined(const std::vector<SurfaceMesh>& meshes) {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  for (const SurfaceMesh& mesh : meshes) {
    const Index first = static_cast<Index>(positions.size());
    positions.insert(positions.end(), mesh.position.begin(), mesh.position.end());
    for (const Triangle& t : mesh.triangles())
      triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return SurfaceMesh::from_triangles(positions, triangles);
}

SurfaceMesh crossing_spheres(int subdivisions) {
  const SurfaceMesh sphere = icosphere(subdivisions);
  return joined({sphere, placed(sphere, 1.0, Vec3(0.9, 0.3, 0.2))});
}

SurfaceMesh in_frame(SurfaceMesh mesh, const Frame& frame) {
  for (Vec3& p : mesh.position) p = frame.to_unit(p);
  return mesh;
}

SurfaceMesh torus_mesh(int major_segments, int minor_segments) {
  std::vector<Vec3> position;
  std::vector<Triangle> faces;
  const auto vertex = [&](int i, int j) {
    return (i % major_segments) * minor_segments + j % minor_segments;
  };
  for (int i = 0; i < major_segments; ++i)
    for (int j = 0; j < minor_segments; ++j) {
      const double u = 2.0 * kPi * i / major_segments, v = 2.0 * kPi * j / minor_segments;
      const double across = kTorusMajor + kTorusMinor * std::cos(v);
      position.push_back({across * std::cos(u), across * std::sin(u), kTorusMinor * std::sin(v)});
      faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      faces.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return SurfaceMesh::from_triangles(std::move(position), faces);
}

}  // namespace shrinkwrap::testing
