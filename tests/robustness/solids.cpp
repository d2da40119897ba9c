#include "solids.h"

#include <algorithm>
#include <cmath>

namespace shrinkwrap::robustness {
namespace {

using testing::box_distance;
using testing::length_of;
using testing::ShapeKind;

// Outside and inside of two surfaces of revolution meet at sharp edges.
double pipe_distance(const Vec3& p, double middle, double half_wall, double half_length) {
  const double across = std::abs(length_of(p.x(), p.y()) - middle) - half_wall;
  const double along = std::abs(p.z()) - half_length;
  return length_of(std::max(across, 0.0), std::max(along, 0.0)) +
         std::min(std::max(across, along), 0.0);
}

double disc_distance(const Vec3& p, double flat_radius, double half_thickness) {
  return length_of(std::max(length_of(p.x(), p.y()) - flat_radius, 0.0), p.z()) - half_thickness;
}

double rod_distance(const Vec3& p, double half_length, double radius) {
  Vec3 q = p;
  q.x() = std::max(std::abs(q.x()) - half_length, 0.0);
  return q.norm() - radius;
}

// Balls in the middle of the cells of a cubic lattice of n x n x layers cells; the nearest is that
// of the own cell or of its neighbours, for they are alike.
double balls_distance(const Vec3& p, int n, int layers, double cell, double radius) {
  const std::array<int, 3> count = {n, n, layers};
  Vec3 nearest;
  for (int axis = 0; axis < 3; ++axis) {
    const int last = count[static_cast<std::size_t>(axis)] - 1;
    const double index = std::round(p[axis] / cell + 0.5 * last);
    nearest[axis] = cell * (std::clamp(index, 0.0, static_cast<double>(last)) - 0.5 * last);
  }
  return (p - nearest).norm() - radius;
}

// From `low` to `high`, evenly in the logarithm.
double between(double low, double high, double drawn) {
  return low * std::pow(high / low, drawn);
}

Solid of_unit_tests(ShapeKind kind, double least_feature) {
  const testing::Shape shape = testing::shape_of(kind);
  Solid solid;
  solid.name = shape.name;
  solid.genus = shape.genus;
  solid.components = shape.components;
  solid.closed = shape.closed;
  solid.least_feature = least_feature;
  solid.radius = shape.radius;
  solid.implicit = [shape](const Vec3& p) { return shape.implicit(p); };
  solid.domain = shape.domain();
  return solid;
}

Solid made(std::string name, double radius, double least_feature,
           testing::ImplicitFunction implicit) {
  Solid solid;
  solid.name = std::move(name);
  solid.radius = radius;
  solid.least_feature = least_feature;
  solid.implicit = std::move(implicit);
  solid.domain = {radius, {}};
  return solid;
}

Solid with_topology(Solid solid, int genus, int components) {
  solid.genus = genus;
  solid.components = components;
  return solid;
}

Solid with_level_faces(Solid solid) {
  solid.has_level_faces = true;
  return solid;
}

Solid balls(std::string name, int n, int layers, double radius) {
  const double cell = 1.0 / n, gap = cell - 2.0 * radius;
  Solid solid = made(std::move(name), 0.9, std::min(gap, 2.0 * radius),
                     [=](const Vec3& p) { return balls_distance(p, n, layers, cell, radius); });
  return with_topology(std::move(solid), 0, n * n * layers);
}

// Of the surface of a solid, what a scanner sees that is far away in some direction (of length 1).
Solid seen_from(const Vec3& direction, Solid solid) {
  const testing::ImplicitFunction implicit = solid.implicit;
  const testing::SamplingDomain all = solid.domain;
  solid.closed = false;
  solid.has_limbs = true;
  solid.domain.keep = [=](const Vec3& p) {
    constexpr double kStep = 0.01;
    if (all.keep && !all.keep(p)) return false;
    for (double way = kStep; way < 2.0 * all.radius; way += kStep)
      if (implicit(p + way * direction) < 0.0) return false;
    return true;
  };
  return solid;
}

// The ground reaches beyond the ball in which it is sampled: it has no sides.
double houses_distance(const Vec3& p) {
  constexpr double kHalfWidth = 0.2, kHeight = 0.3, kFromMiddle = 0.4;
  const Vec3 from_house(std::abs(p.x()) - kFromMiddle, std::abs(p.y()) - kFromMiddle, p.z());
  return std::min(p.z(), box_distance(from_house, {kHalfWidth, kHalfWidth, kHeight}));
}

}  // namespace

Solid solid_of(SolidKind kind, double drawn) {
  const double thickness = between(0.02, 0.3, drawn);
  switch (kind) {
    case SolidKind::sphere:
      return of_unit_tests(ShapeKind::sphere, 2.0);
    case SolidKind::torus:
      return of_unit_tests(ShapeKind::torus, 0.5);
    case SolidKind::double_torus:
      return of_unit_tests(ShapeKind::double_torus, 0.34);
    case SolidKind::box:
      return with_level_faces(of_unit_tests(ShapeKind::box, 0.7));
    case SolidKind::thin_plate:
      return with_level_faces(of_unit_tests(ShapeKind::thin_plate, 0.08));
    case SolidKind::bowl:
      return of_unit_tests(ShapeKind::bowl, 0.16);
    case SolidKind::two_spheres:
      return of_unit_tests(ShapeKind::two_spheres, 0.25);
    case SolidKind::blob:
      return of_unit_tests(ShapeKind::blob, 0.5);
    case SolidKind::hemisphere:
      return of_unit_tests(ShapeKind::hemisphere, 0.5);
    case SolidKind::wall:
      return with_level_faces(made("wall", 0.8, thickness, [=](const Vec3& p) {
        return box_distance(p, {0.6, 0.45, 0.5 * thickness});
      }));
    case SolidKind::slot:
      return with_level_faces(made("slot", 0.9, std::min(thickness, 0.5), [=](const Vec3& p) {
        const double block = box_distance(p, {0.6, 0.45, 0.35});
        const double cut = box_distance(p - Vec3(0.0, 0.0, 0.4), {0.5 * thickness, 0.7, 0.55});
        return std::max(block, -cut);
      }));
    case SolidKind::pipe: {
      Solid pipe = made("pipe", 1.0, thickness,
                        [=](const Vec3& p) { return pipe_distance(p, 0.5, 0.5 * thickness, 0.7); });
      return with_level_faces(with_topology(std::move(pipe), 1, 1));
    }
    case SolidKind::rod: {
      const double radius = 0.25 * thickness + 0.01;
      return made("rod", 1.0, 2.0 * radius,
                  [=](const Vec3& p) { return rod_distance(p, 0.98 - radius, radius); });
    }
    case SolidKind::disc:
      return with_level_faces(made("disc", 1.0, thickness, [=](const Vec3& p) {
        return disc_distance(p, 0.98 - 0.5 * thickness, 0.5 * thickness);
      }));
    case SolidKind::shell:
      return with_topology(made("shell", 1.05, thickness,
                                [=](const Vec3& p) {
                                  return std::abs(p.norm() - 1.0 + 0.5 * thickness) -
                                         0.5 * thickness;
                                }),
                           0, 2);
    case SolidKind::nested:
      return with_topology(made("nested", 1.05, 0.2,
                                [](const Vec3& p) {
                                  const double shell = std::abs(p.norm() - 0.9) - 0.1;
                                  return std::min(shell, p.norm() - 0.4);
                                }),
                           0, 3);
    case SolidKind::crowd:
      return balls("crowd", 4, 3, 0.06);
    case SolidKind::few_balls:
      return balls("few_balls", 2, 2, 0.17);
    case SolidKind::houses:
      return seen_from(Vec3(0.5, 0.2, 1.0).normalized(),
                       with_level_faces(made("houses", 1.0, 0.3, houses_distance)));
    case SolidKind::one_view:
      break;
  }
  Solid view = seen_from(Vec3(0.3, -1.0, 0.5).normalized(), of_unit_tests(ShapeKind::blob, 0.5));
  view.name = "one_view";
  return view;
}

}  // namespace shrinkwrap::robustness
