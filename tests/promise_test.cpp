#include "report/promise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "shapes.h"

namespace shrinkwrap {
namespace {

ResultMesh sphere() {
  const SurfaceMesh surface = testing::icosphere(2);
  ResultMesh mesh;
  mesh.position = surface.position;
  mesh.triangles = surface.triangles();
  return mesh;
}

// What is said not to hold; empty if all does.
std::string broken(const ResultMesh& mesh, const std::vector<Vec3>& samples,
                   const PromiseOptions& options = {}) {
  Progress silent;
  try {
    check_promise(mesh, samples, kNone, options, silent);
  } catch (const ReconstructionFailed& failure) {
    return failure.what();
  }
  return "";
}

void expect_broken(const std::string& part, const ResultMesh& mesh,
                   const std::vector<Vec3>& samples, const PromiseOptions& options = {}) {
  const std::string message = broken(mesh, samples, options);
  EXPECT_NE(message.find("would not be " + part), std::string::npos) << part << ": " << message;
}

PromiseOptions of_an_open_mesh() {
  PromiseOptions options;
  options.may_be_open = true;
  return options;
}

PromiseOptions of_a_surface() {
  PromiseOptions options;
  options.matches_samples = false;
  return options;
}

TEST(Promise, HoldsOfASphereThroughItsSamples) {
  const ResultMesh mesh = sphere();
  EXPECT_EQ(broken(mesh, mesh.position), "");
}

TEST(Promise, AHoleBreaksItUnlessTheMeshMayBeOpen) {
  ResultMesh mesh = sphere();
  mesh.triangles.pop_back();
  expect_broken("closed", mesh, mesh.position);
  EXPECT_EQ(broken(mesh, mesh.position, of_an_open_mesh()), "");
}

// Whatever else is allowed.
TEST(Promise, AnEdgeOfThreeFacesBreaksIt) {
  ResultMesh mesh = sphere();
  const Triangle t = mesh.triangles.front();
  mesh.position.emplace_back(0.0, 0.0, 2.0);
  mesh.triangles.push_back({t[0], t[1], static_cast<Index>(mesh.position.size()) - 1});
  PromiseOptions options = of_an_open_mesh();
  options.matches_samples = false;
  expect_broken("a 2-manifold", mesh, mesh.position, options);
}

TEST(Promise, FacesThatTurnTheOtherWayBreakIt) {
  ResultMesh mesh = sphere();
  std::swap(mesh.triangles.front()[0], mesh.triangles.front()[1]);
  expect_broken("a 2-manifold", mesh, mesh.position);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  std::swap(mesh.triangles.front()[0], mesh.triangles.front()[1]);
  expect_broken("oriented outwards", mesh, mesh.position, of_a_surface());
}

TEST(Promise, AFlatMeshHasNoSideThatBreaksIt) {
  const SurfaceMesh flat = testing::flattened(testing::icosphere(2), Vec3(1, 2, 3));
  ResultMesh mesh;
  mesh.position = flat.position;
  mesh.triangles = flat.triangles();
  EXPECT_EQ(broken(mesh, mesh.position), "");
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(broken(mesh, mesh.position), "");
}

TEST(Promise, NoFacesBreakIt) {
  expect_broken("a 2-manifold", ResultMesh(), {Vec3::Zero()}, of_an_open_mesh());
}

// By the last bit of one coordinate.
TEST(Promise, AMovedSampleBreaksItUnlessTheMeshIsASurface) {
  const ResultMesh mesh = sphere();
  std::vector<Vec3> samples = mesh.position;
  samples[7].x() = std::nextafter(samples[7].x(), 9.0);
  expect_broken("complete (1 samples", mesh, samples);
  EXPECT_EQ(broken(mesh, samples, of_a_surface()), "");
}

TEST(Promise, ASampleThatIsTwoVerticesBreaksIt) {
  const ResultMesh one = sphere();
  ResultMesh mesh = one;
  // A second sphere within the first that touches it in one sample.
  const Vec3 centre = 0.5 * one.position.front();
  for (const Vec3& p : one.position) mesh.position.push_back(centre + 0.5 * p);
  const Index first = static_cast<Index>(one.position.size());
  mesh.position[first] = one.position.front();
  for (const Triangle& t : one.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  expect_broken("one to one", mesh, one.position);
}

TEST(Promise, FacesThatMeetAreCountedOrTakenAsKnown) {
  const ResultMesh mesh = sphere();
  PromiseOptions options;
  Progress silent;
  EXPECT_EQ(check_promise(mesh, mesh.position, kNone, options, silent).self_intersecting_faces, 0);
  EXPECT_EQ(check_promise(mesh, mesh.position, 3, options, silent).self_intersecting_faces, 3);
  options.report.count_self_intersections = false;
  EXPECT_EQ(check_promise(mesh, mesh.position, kNone, options, silent).self_intersecting_faces, -1);
}

}  // namespace
}  // namespace shrinkwrap
