#include "gallery.h"

#include <cmath>
#include <limits>
#include <utility>

#include "shapes.h"

namespace shrinkwrap::robustness {
namespace {

using testing::Random;
using testing::ShapeKind;
using Points = std::vector<Vec3>;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;

const Expectation kInvalid = {true, false, false, 0, 1, {}, {}};
const Expectation kSphere = {false, true, false, 0, 1, {}, {}};  // must succeed
const Expectation kHalfSphere = {false, true, true, 0, 1, {}, {}};

template <class Generate>
Points generated(Index count, const Generate& generate) {
  Points points;
  points.reserve(count);
  for (Index i = 0; i < count; ++i) points.push_back(generate(i));
  return points;
}

template <class Change>
Points changed(Points points, const Change& change) {
  for (Vec3& p : points) change(p);
  return points;
}

Points joined(Points a, const Points& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Points moved(Points points, double scale, const Vec3& offset) {
  return changed(std::move(points), [&](Vec3& p) { p = scale * p + offset; });
}

Points lattice(int nx, int ny, int nz) {
  Points points;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) points.emplace_back(i, j, k);
  return points;
}

bool on_shell(const Vec3& p, int n) {
  return p.minCoeff() == 0.0 || p.maxCoeff() == n - 1;
}

Points cube_shell(int n) {
  Points shell;
  for (const Vec3& p : lattice(n, n, n))
    if (on_shell(p, n)) shell.push_back(p);
  return shell;
}

class Builder {
 public:
  explicit Builder(unsigned seed) : seed_(seed), random_(seed) {}

  std::vector<Exhibit> build() {
    too_few();
    flat();
    repeated();
    tiny();
    lattices();
    clusters();
    not_numbers();
    extreme_coordinates();
    surfaces_of_no_solid();
    uneven();
    laborious();
    return std::move(exhibits_);
  }

 private:
  void add(std::string name, Points points, const Expectation& expectation = {}) {
    exhibits_.push_back({std::move(name), std::move(points), expectation});
  }
  Points sphere(Index count) { return testing::sample_shape(ShapeKind::sphere, count, seed_); }
  Points in_cube(Index count) {
    return generated(count, [&](Index) { return random_.in_cube(); });
  }
  Points in_plane(Index count, const Vec3& u, const Vec3& v) {
    return generated(count, [&](Index) {
      return Vec3(random_.uniform(-1.0, 1.0) * u + random_.uniform(-1.0, 1.0) * v);
    });
  }

  void too_few() {
    add("nothing", {}, kInvalid);
    for (Index count = 1; count < 4; ++count)
      add("few_" + std::to_string(count), in_cube(count), kInvalid);
    add("three_of_four_equal", joined(in_cube(3), Points(1, Vec3::Zero())));
  }

  void flat() {
    add("collinear_along_axis", generated(100, [](Index i) { return Vec3(i, 0, 0); }), kInvalid);
    add("collinear_dyadic", generated(100, [](Index i) { return Vec3(i * Vec3(1.0, 0.5, -0.25)); }),
        kInvalid);
    add("collinear_rounded",
        generated(100, [&](Index) { return Vec3(random_.uniform() * Vec3(0.3, 0.7, -0.1)); }));
    add("collinear_but_one",
        joined(generated(100, [](Index i) { return Vec3(i, 0, 0); }), {{50, 1, 0}}), kInvalid);
    add("collinear_but_two",
        joined(generated(100, [](Index i) { return Vec3(i, 0, 0); }), {{50, 1, 0}, {50, 0, 1}}));
    add("coplanar_lattice", lattice(30, 30, 1), kInvalid);
    add("coplanar_random", in_plane(500, Vec3::UnitX(), Vec3::UnitY()), kInvalid);
    add("coplanar_tilted", in_plane(500, Vec3(0.3, 0.7, 0.2), Vec3(-0.5, 0.1, 0.9)));
    for (const double thickness : {1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2})
      add("nearly_coplanar_" + std::to_string(-static_cast<int>(std::log10(thickness) - 0.5)),
          changed(in_plane(2000, Vec3::UnitX(), Vec3::UnitY()),
                  [&](Vec3& p) { p.z() = thickness * random_.uniform(); }));
    add("coplanar_but_one", joined(lattice(20, 20, 1), {{10, 10, 5}}));
    add("two_planes", joined(lattice(20, 20, 1), moved(lattice(20, 20, 1), 1.0, {0, 0, 8})));
    add("two_close_planes",
        joined(lattice(20, 20, 1), moved(lattice(20, 20, 1), 1.0, {0, 0, 0.01})));
    add("crossing_planes",
        joined(lattice(21, 21, 1), moved(lattice(21, 1, 21), 1.0, {0, 10, -10})));
  }

  void repeated() {
    add("all_equal", Points(1000, Vec3(0.1, 0.2, 0.3)), kInvalid);
    Points corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    add("tetrahedron_repeated",
        generated(4000, [&](Index i) { return corners[static_cast<std::size_t>(i % 4)]; }));
    add(
        "sphere_each_five_times",
        [&] {
          Points points = sphere(1000), all;
          for (int i = 0; i < 5; ++i) all = joined(all, points);
          return all;
        }(),
        kSphere);
    add("sphere_and_one_repeated", joined(sphere(1000), Points(50000, Vec3(0.0, 0.0, 1.0))),
        kSphere);
    add("sphere_of_signed_zeros", changed(cube_shell(9), [&](Vec3& p) {
          for (int axis = 0; axis < 3; ++axis)
            if (p[axis] == 0.0 && random_.uniform() < 0.5) p[axis] = -0.0;
        }));
    add("pairs_in_the_last_bit", [&] {
      Points points = sphere(1500);
      Points twins = changed(points, [](Vec3& p) { p.x() = std::nextafter(p.x(), 2.0); });
      return joined(points, twins);
    }());
    add("pairs_in_the_last_bit_of_a_float", [&] {
      Points points = changed(sphere(1500), [](Vec3& p) { p = rounded_to_single(p); });
      Points twins =
          changed(points, [](Vec3& p) { p.x() = std::nextafter(static_cast<float>(p.x()), 2.0f); });
      return joined(points, twins);
    }());
  }

  void tiny() {
    add("tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    add("flat_tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1e-12}});
    add("octahedron", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
    add("cube_corners", lattice(2, 2, 2));
    for (const Index count :
         {4, 5, 6, 7, 8, 10, 12, 15, 16, 17, 20, 25, 30, 31, 40, 60, 100, 150}) {
      add("sphere_of_" + std::to_string(count), sphere(count));
      add("volume_of_" + std::to_string(count), in_cube(count));
    }
  }

  void lattices() {
    add("solid_lattice", lattice(12, 12, 12));
    add("solid_lattice_long", lattice(3, 3, 300));
    add("cube_shell", cube_shell(16), kSphere);
    add("cube_shell_tilted",
        changed(cube_shell(16),
                [](Vec3& p) { p = Eigen::Quaterniond(0.83, 0.21, 0.34, 0.39).normalized() * p; }),
        kSphere);
    add("lattice_of_pairs",
        joined(lattice(10, 10, 10), moved(lattice(10, 10, 10), 1.0, {1e-9, 0, 0})));
    add("sphere_on_lattice",
        changed(sphere(4000), [](Vec3& p) { p = (p * 24.0).array().round().matrix(); }));
  }

  void clusters() {
    add("clusters", [&] {
      Points points;
      for (int i = 0; i < 40; ++i)
        points = joined(points, moved(in_cube(50), 0.01, random_.in_cube()));
      return points;
    }());
    add("clusters_of_one_place", [&] {
      Points points;
      for (int i = 0; i < 20; ++i)
        points = joined(points, moved(in_cube(100), 1e-14, random_.in_cube()));
      return points;
    }());
    add("two_spheres_far_apart", joined(sphere(1000), moved(sphere(1000), 1.0, {1e6, 0, 0})));
    add("two_spheres_very_far_apart", joined(sphere(1000), moved(sphere(1000), 1.0, {1e15, 0, 0})));
    add("spheres_of_all_sizes", [&] {
      Points points;
      for (int i = 0; i < 8; ++i)
        points = joined(
            points, moved(sphere(400), std::pow(10.0, -i), Vec3(3.0 * std::pow(10.0, -i), 0, 0)));
      return points;
    }());
    add("sphere_and_far_point", joined(sphere(1000), {{1e3, 0, 0}}));
    add("sphere_and_very_far_point", joined(sphere(1000), {{1e30, 1e30, 0}}));
    add("many_small_spheres", [&] {
      Points points;
      for (int i = 0; i < 60; ++i)
        points = joined(points, moved(sphere(60), 0.03, random_.in_cube()));
      return points;
    }());
    add("nested_spheres", joined(sphere(3000), moved(sphere(1500), 0.5, Vec3::Zero())));
    add("touching_spheres", joined(sphere(2000), moved(sphere(2000), 1.0, {2.0, 0, 0})));
    add("overlapping_spheres", joined(sphere(2000), moved(sphere(2000), 1.0, {1.0, 0, 0})));
  }

  void not_numbers() {
    const Points bad = {{kNotANumber, 0, 0},
                        {0, kInfinity, 0},
                        {0, 0, -kInfinity},
                        {kNotANumber, kNotANumber, 1},
                        {kInfinity, kNotANumber, kInfinity}};
    add("nothing_finite", joined(bad, bad), kInvalid);
    add("three_finite", joined(bad, in_cube(3)), kInvalid);
    add(
        "sphere_among_not_finite",
        [&] {
          Points points;
          for (const Vec3& p : sphere(1500)) {
            points.push_back(p);
            if (random_.uniform() < 0.5)
              points.push_back(bad[static_cast<std::size_t>(random_.below(5))]);
          }
          return points;
        }(),
        kSphere);
  }

  void extreme_coordinates() {
    for (const int exponent : {-320, -310, -300, -200, -100, -40, 40, 100, 150, 200, 300, 307})
      add("sphere_1e" + std::to_string(exponent),
          moved(sphere(1000), std::pow(10.0, exponent), Vec3::Zero()));
    add("sphere_of_the_largest",
        moved(sphere(1000), std::numeric_limits<double>::max() / 1.001, Vec3::Zero()));
    add("sphere_of_the_largest_floats",
        changed(
            moved(sphere(1000), double{std::numeric_limits<float>::max()} / 1.001, Vec3::Zero()),
            [](Vec3& p) { p = rounded_to_single(p); }));
    add("denormal", generated(200, [&](Index) {
          return Vec3(in_cube(1)[0] * 50 * std::numeric_limits<double>::denorm_min());
        }));
    add("huge_and_denormal",
        joined(moved(sphere(500), 1e300, Vec3::Zero()), moved(sphere(500), 1e-310, Vec3::Zero())));
    for (const double offset : {1e3, 1e6, 1e9, 1e12, 1e15, 1e16})
      add("sphere_at_1e" + std::to_string(static_cast<int>(std::log10(offset) + 0.5)),
          moved(sphere(2000), 1.0, {offset, -offset, 0.3 * offset}));
    add("needle", changed(sphere(2000), [](Vec3& p) { p.x() *= 1e6; }));
    add("needle_in_two_axes", changed(sphere(2000), [](Vec3& p) { p *= 1e-9, p.x() *= 1e9; }));
    add("pancake", changed(sphere(2000), [](Vec3& p) { p.z() *= 1e-6; }));
  }

  void surfaces_of_no_solid() {
    add("volume", in_cube(3000));
    add("ball", generated(3000, [&](Index) {
          return Vec3(random_.direction() * std::cbrt(random_.uniform()));
        }));
    add("helix", generated(1000, [](Index i) {
          return Vec3(std::cos(0.05 * i), std::sin(0.05 * i), 0.003 * i);
        }));
    add("circle", generated(500, [](Index i) {
          return Vec3(std::cos(i * 2 * kPi / 500), std::sin(i * 2 * kPi / 500), 0.0);
        }));
    add("moebius_band", generated(4000, [&](Index) {
          const double u = random_.uniform(0.0, 2.0 * kPi), v = random_.uniform(-0.4, 0.4);
          const double across = 1.0 + v * std::cos(0.5 * u);
          return Vec3(across * std::cos(u), across * std::sin(u), v * std::sin(0.5 * u));
        }));
    add("klein_bottle", generated(6000, [&](Index) {
          const double u = random_.uniform(0.0, 2.0 * kPi), v = random_.uniform(0.0, 2.0 * kPi);
          const double across =
              2.0 + std::cos(0.5 * u) * std::sin(v) - std::sin(0.5 * u) * std::sin(2.0 * v);
          return Vec3(across * std::cos(u), across * std::sin(u),
                      std::sin(0.5 * u) * std::sin(v) + std::cos(0.5 * u) * std::sin(2.0 * v));
        }));
    add("wavy_sheet", changed(in_plane(4000, Vec3::UnitX(), Vec3::UnitY()), [](Vec3& p) {
          p.z() = 0.1 * std::sin(6.0 * p.x()) * std::cos(5.0 * p.y());
        }));
    add("cylinder_without_ends", generated(3000, [&](Index) {
          const double u = random_.uniform(0.0, 2.0 * kPi);
          return Vec3(std::cos(u), std::sin(u), random_.uniform(-1.0, 1.0));
        }));
    add("cone", generated(3000, [&](Index) {
          const double u = random_.uniform(0.0, 2.0 * kPi), r = random_.uniform();
          return Vec3(r * std::cos(u), r * std::sin(u), r);
        }));
    add("hemisphere", testing::sample_shape(ShapeKind::hemisphere, 3000, seed_), kHalfSphere);
  }

  void uneven() {
    add("sphere_with_dense_pole", joined(sphere(1000), [&] {
          return changed(sphere(4000), [](Vec3& p) {
            p = (Vec3(0, 0, 20) + Vec3(p.x(), p.y(), 0)).normalized();
          });
        }()));
    add("spiral_to_a_point",
        generated(2000, [&](Index i) { return Vec3(std::exp(-0.01 * i) * random_.direction()); }));
    add("cantor_dust", generated(3000, [&](Index) {
          Vec3 p = Vec3::Zero();
          for (double third = 2.0 / 3.0; third > 1e-12; third /= 3.0)
            for (int axis = 0; axis < 3; ++axis)
              if (random_.uniform() < 0.5) p[axis] += third;
          return p;
        }));
    add("sphere_with_far_outliers", joined(sphere(2000), moved(in_cube(20), 100.0, Vec3::Zero())));
    add("stripes", changed(sphere(4000), [](Vec3& p) {
          p.z() = std::round(p.z() * 8.0) / 8.0;
          const double across = std::sqrt(p.x() * p.x() + p.y() * p.y());
          const double wanted = std::sqrt(std::max(0.0, 1.0 - p.z() * p.z()));
          if (across > 0.0) {
            p.x() *= wanted / across;
            p.y() *= wanted / across;
          }
        }));
  }

  // No surface, and much to do: wide openings, heaps of faces, faces all equally far.
  void laborious() {
    for (const double distance : {1.0, 0.05})
      add("two_circles_" + std::to_string(static_cast<int>(100.0 * distance)),
          generated(5000, [&](Index i) {
            const double u = random_.uniform(0.0, 2.0 * kPi);
            return Vec3(std::cos(u), std::sin(u), i % 2 == 0 ? 0.0 : distance);
          }));
    add("radii_over_30_decades", generated(5000, [&](Index) {
          const Vec3 direction = random_.direction();
          return Vec3(direction * std::pow(10.0, 30.0 * random_.uniform()));
        }));
    for (const double decades : {8.0, 20.0})
      add("cone_dense_over_" + std::to_string(static_cast<int>(decades)) + "_decades",
          generated(5000, [&](Index) {
            const double u = random_.uniform(0.0, 2.0 * kPi),
                         r = std::pow(10.0, -decades * random_.uniform());
            return Vec3(r * std::cos(u), r * std::sin(u), 2.0 * r);
          }));
    add("sphere_around_a_cluster", joined(sphere(5000), generated(5000, [&](Index) {
                                            const Vec3 direction = random_.direction();
                                            return Vec3(1e-3 * random_.uniform() * direction);
                                          })));
    add("sphere_around_a_small_sphere",
        joined(sphere(5000), moved(sphere(5000), 0.01, Vec3::Zero())));
    add("sphere_of_clumps", [&] {
      const Points centres = sphere(500);
      return joined(sphere(1000), generated(9000, [&](Index i) {
                      const Vec3& centre = centres[static_cast<std::size_t>(i) % centres.size()];
                      return Vec3(centre + 1e-4 * random_.in_cube());
                    }));
    }());
  }

  unsigned seed_;
  Random random_;
  std::vector<Exhibit> exhibits_;
};

}  // namespace

std::vector<Exhibit> gallery(unsigned seed) {
  return Builder(seed).build();
}

}  // namespace shrinkwrap::robustness
