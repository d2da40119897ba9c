// Which components of a mesh are bodies, cavities or inside out, against nests whose sides are
// known.
#include "mesh/bodies.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::expect_closed_manifold;
using testing::icosphere;
using testing::torus_mesh;

class Nest {
 public:
  void add(const SurfaceMesh& mesh, double radius, const Vec3& centre, bool is_turned = false) {
    const Index first = static_cast<Index>(position_.size());
    for (const Vec3& p : mesh.position) position_.push_back(radius * p + centre);
    double volume = 0.0;
    for (Triangle t : mesh.triangles()) {
      if (is_turned) std::swap(t[1], t[2]);
      volume += mesh.position[t[0]].dot(mesh.position[t[1]].cross(mesh.position[t[2]])) / 6.0;
      for (Index& v : t) v += first;
      triangles_.push_back(t);
      component_of_face_.push_back(static_cast<Index>(volume_.size()));
    }
    volume_.push_back(volume * radius * radius * radius);
  }
  void add_ball(double radius, const Vec3& centre, bool is_turned = false) {
    add(icosphere(2), radius, centre, is_turned);
  }

  ComponentSides sides() const {
    Progress silent;
    return find_sides(position_, triangles_, component_of_face_, volume_, silent);
  }
  SurfaceMesh mesh() const { return SurfaceMesh::from_triangles(position_, triangles_); }
  std::vector<Index> faces_of(Index component) const {
    std::vector<Index> faces;
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      if (component_of_face_[f] == component) faces.push_back(static_cast<Index>(f));
    return faces;
  }

 private:
  std::vector<Vec3> position_;
  std::vector<Triangle> triangles_;
  std::vector<Index> component_of_face_;
  std::vector<double> volume_;
};

using Indices = std::vector<Index>;

void expect_turned(const Nest& nest, const Indices& turned, const Indices& opening_faces = {}) {
  Progress silent;
  const SurfaceMesh before = nest.mesh();
  SurfaceMesh mesh = before;
  EXPECT_EQ(turn_outward(mesh, opening_faces, silent), static_cast<Index>(turned.size()));
  EXPECT_EQ(mesh.position, before.position);
  std::vector<Triangle> expected = before.triangles();
  for (const Index component : turned)
    for (const Index f : nest.faces_of(component)) std::swap(expected[f][1], expected[f][2]);
  EXPECT_EQ(mesh.triangles(), expected);
  EXPECT_TRUE(mesh.is_consistent());
  EXPECT_EQ(turn_outward(mesh, opening_faces, silent), 0);
}

TEST(Bodies, OneBodyIsTurnedIfItIsInsideOut) {
  Nest outward, inward;
  outward.add(torus_mesh(20, 10), 1.0, Vec3(3, 0, 0));
  inward.add(torus_mesh(20, 10), 1.0, Vec3(3, 0, 0), true);
  expect_turned(outward, {});
  EXPECT_TRUE(outward.sides().inside_out.empty());
  expect_turned(inward, {0});
  EXPECT_EQ(inward.sides().inside_out, Indices{0});
}

TEST(Bodies, ABodyBesideAGreaterOneIsNoCavity) {
  Nest nest;
  nest.add_ball(10.0, Vec3::Zero());
  nest.add_ball(1.0, Vec3(12, 0, 0), true);
  nest.add_ball(1.0, Vec3(-12, 0.1, 0), true);  // its ray runs through the greater one
  nest.add_ball(1.0, Vec3(1, 2, 3), true);
  EXPECT_EQ(nest.sides().inside_out, (Indices{1, 2}));
  EXPECT_EQ(nest.sides().cavities, Indices{3});
  expect_turned(nest, {1, 2});
}

TEST(Bodies, ABodyWithinACavityIsABody) {
  Nest nest;
  nest.add_ball(1.0, Vec3::Zero(), true);  // in the cavity
  nest.add_ball(3.0, Vec3::Zero(), true);  // the cavity
  nest.add_ball(4.0, Vec3::Zero());
  EXPECT_EQ(nest.sides().inside_out, Indices{0});
  EXPECT_EQ(nest.sides().cavities, Indices{1});
  expect_turned(nest, {0});
}

TEST(Bodies, ACavityFacesInwards) {
  Nest nest;
  nest.add_ball(1.0, Vec3(0.1, 0, 0.1));  // a body in the next
  nest.add_ball(2.0, Vec3::Zero());       // should be a cavity
  nest.add_ball(0.5, Vec3(3, 0, 0));      // and so should this
  nest.add_ball(4.0, Vec3::Zero());
  EXPECT_EQ(nest.sides().inside_out, (Indices{1, 2}));
  EXPECT_EQ(nest.sides().cavities, (Indices{1, 2}));
  expect_turned(nest, {1, 2});
}

TEST(Bodies, WhatEnclosesIsTurnedFirst) {
  Nest nest;
  nest.add_ball(1.0, Vec3::Zero(), true);  // a cavity once the body around it is turned
  nest.add_ball(2.0, Vec3::Zero(), true);
  EXPECT_EQ(nest.sides().inside_out, Indices{1});
  EXPECT_EQ(nest.sides().cavities, Indices{0});
  expect_turned(nest, {1});
}

TEST(Bodies, TheHoleOfARingIsOutside) {
  Nest nest;
  nest.add(torus_mesh(40, 20), 1.0, Vec3::Zero());
  nest.add_ball(0.1, Vec3::Zero(), true);
  nest.add_ball(0.05, Vec3(0, 0, 0.3), true);
  EXPECT_EQ(nest.sides().inside_out, (Indices{1, 2}));
}

TEST(Bodies, RaysAlongFacesCountOnce) {
  // Balls cut off at the height of the same lattice planes, in rows along the rays: these run in
  // the planes of their caps.
  SurfaceMesh ball = icosphere(3);
  for (Vec3& p : ball.position)
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = std::clamp(std::round(8.0 * p[axis]) / 8.0, -0.5, 0.5);
  Nest nest, turned;
  Indices all;
  for (int i = 0; i < 27; ++i) {
    const Vec3 centre(3 * (i % 3), 3 * (i / 3 % 3), 3 * (i / 9));
    nest.add(ball, 1.0, centre);
    turned.add(ball, 1.0, centre, true);
    all.push_back(i);
  }
  EXPECT_TRUE(nest.sides().inside_out.empty());
  EXPECT_TRUE(nest.sides().cavities.empty());
  EXPECT_EQ(turned.sides().inside_out, all);
}

TEST(Bodies, RaysThroughVerticesAndEdgesCountOnce) {
  // Cubes on a lattice, in each of which the corners of the next smaller one share its planes of
  // symmetry: rays meet diagonals and corners more often than not.
  const std::vector<Triangle> faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                       {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                       {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::vector<Vec3> corners;
  for (int v = 0; v < 8; ++v)
    corners.emplace_back(2 * (v & 1) - 1, 2 * (v >> 1 & 1) - 1, 2 * (v >> 2 & 1) - 1);
  const SurfaceMesh cube = SurfaceMesh::from_triangles(corners, faces);
  Nest nest;
  Indices cavities;
  for (int k = 8; k >= 1; --k) {
    nest.add(cube, k, Vec3::Zero(), k % 2 == 1);
    if (k % 2 == 1) cavities.push_back(8 - k);
  }
  EXPECT_EQ(nest.sides().cavities, cavities);
  expect_turned(nest, {});
}

TEST(Bodies, ComponentsLeftOpenKeepTheirSide) {
  Nest nest;
  nest.add_ball(2.0, Vec3::Zero(), true);
  nest.add_ball(1.0, Vec3(5, 0, 0), true);
  expect_turned(nest, {1}, {nest.faces_of(0).front()});
}

TEST(Bodies, WhatAComponentLeftOpenEnclosesKeepsItsSide) {
  for (const bool is_turned : {false, true}) {
    Nest nest;
    nest.add_ball(2.0, Vec3::Zero(), is_turned);
    nest.add_ball(1.0, Vec3::Zero());
    nest.add_ball(0.5, Vec3(0, 1.5, 0), true);
    nest.add_ball(0.5, Vec3(0, 3, 0), true);
    expect_turned(nest, {3}, {nest.faces_of(0).front()});
  }
}

TEST(Bodies, WhatReachesBeyondABodyIsNoCavityOfIt) {
  for (int i = 0; i < 20; ++i) {
    const Vec3 direction(std::cos(i), std::sin(i), std::sin(3 * i));
    Nest nest;
    nest.add_ball(2.0, Vec3::Zero());
    nest.add_ball(1.0, 3.0 * direction / direction.cwiseAbs().maxCoeff() * 0.5);
    EXPECT_TRUE(nest.sides().cavities.empty());
    expect_turned(nest, {});
  }
}

TEST(Bodies, AreTheSameForAnyNumberOfThreads) {
  Nest nest;
  nest.add(icosphere(5), 60.0, Vec3::Zero());
  for (int i = 0; i < 200; ++i)
    nest.add_ball(1.0 + 0.001 * i, Vec3(i % 10 * 15 - 67, i / 10 % 10 * 15 - 67, i / 100 * 15),
                  i % 3 > 0);
  const ComponentSides both = nest.sides();
  EXPECT_GT(both.cavities.size(), 40u);
  EXPECT_GT(both.inside_out.size(), 10u);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(nest.sides().cavities, both.cavities);
  EXPECT_EQ(nest.sides().inside_out, both.inside_out);
}

}  // namespace
}  // namespace shrinkwrap
