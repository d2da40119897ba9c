// make_truth SHAPE OUTPUT.ply: the surface that a cloud was sampled from, as a fine mesh to measure
// reconstructions against. SHAPE: ball_joint (of sample_clouds) or a closed shape of the tests.
//
// Marching cubes of vcglib, then every vertex is moved onto the surface, so that only the flatness
// of the faces is left as an error: about 1e-4 of the size where the surface curves most. Shares no
// code with the reconstruction.
//
// What follows needs the first:
// clang-format off
#include <vcg/complex/complex.h>
#include <vcg/space/index/grid_util.h>
#include <vcg/complex/algorithms/create/marching_cubes.h>
#include <vcg/complex/algorithms/create/mc_trivial_walker.h>
#include <wrap/io_trimesh/export_ply.h>
// clang-format on

#include <cstdio>
#include <exception>
#include <string>
#include <wrap/ply/plylib.cpp>

#include "ball_joint.h"
#include "shapes.h"

namespace {

using shrinkwrap::Vec3;
using shrinkwrap::testing::ImplicitFunction;

class Vertex;
class Face;
struct Types : vcg::UsedTypes<vcg::Use<Vertex>::AsVertexType, vcg::Use<Face>::AsFaceType> {};
class Vertex : public vcg::Vertex<Types, vcg::vertex::Coord3f, vcg::vertex::BitFlags> {};
class Face : public vcg::Face<Types, vcg::face::VertexRef, vcg::face::BitFlags> {};
class Mesh : public vcg::tri::TriMesh<std::vector<Vertex>, std::vector<Face>> {};

using Volume = vcg::SimpleVolume<vcg::SimpleVoxel<float>>;
using Walker = vcg::tri::TrivialWalker<Mesh, Volume>;

constexpr int kCells = 240;  // along each axis

struct Solid {
  ImplicitFunction implicit;
  double radius = 0.0;
};

Solid solid_of(const std::string& name) {
  using namespace shrinkwrap;
  if (name == "ball_joint") return {sample_clouds::ball_joint, sample_clouds::kBallJointRadius};
  std::string known = " ball_joint";
  for (const testing::ShapeKind kind : testing::closed_shapes()) {
    const testing::Shape shape = testing::shape_of(kind);
    if (shape.name == name)
      return {[shape](const Vec3& p) { return shape.implicit(p); }, shape.radius};
    known += " " + shape.name;
  }
  throw InvalidInput("no closed shape '" + name + "'; there are:" + known);
}

// Newton's steps along the gradient, by central differences.
Vec3 on_surface(const ImplicitFunction& implicit, Vec3 p) {
  constexpr double h = 1e-6;
  for (int step = 0; step < 3; ++step) {
    Vec3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 aside = h * Vec3::Unit(axis);
      gradient[axis] = (implicit(p + aside) - implicit(p - aside)) / (2.0 * h);
    }
    const double steepness = gradient.squaredNorm();
    if (steepness < 0.01) break;  // on a ridge between two parts: stay
    p -= implicit(p) / steepness * gradient;
  }
  return p;
}

void make_mesh(const Solid& solid, Mesh& mesh) {
  // The walker leaves out the last layer of cells, so that there must be nothing in it.
  const float reach = static_cast<float>(1.05 * solid.radius);
  Volume volume;
  volume.Init({kCells, kCells, kCells}, {{-reach, -reach, -reach}, {reach, reach, reach}});
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j)
      for (int k = 0; k < kCells; ++k) {
        vcg::Point3f corner;
        volume.IPiToPf({i, j, k}, corner);
        volume.Val(i, j, k) = static_cast<float>(solid.implicit({corner[0], corner[1], corner[2]}));
      }
  Walker walker;
  vcg::tri::MarchingCubes<Mesh, Walker> extractor(mesh, walker);
  walker.BuildMesh(mesh, volume, extractor, 0.0f);
  for (Vertex& vertex : mesh.vert) {
    const auto& q = vertex.cP();
    const Vec3 p = on_surface(solid.implicit, {q[0], q[1], q[2]});
    vertex.P() = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: make_truth SHAPE OUTPUT.ply\n");
    return 2;
  }
  try {
    Mesh mesh;
    make_mesh(solid_of(argv[1]), mesh);
    const int error = vcg::tri::io::ExporterPLY<Mesh>::Save(mesh, argv[2]);
    if (error == 0) return 0;
    std::fprintf(stderr, "make_truth: %s: %s\n", argv[2],
                 vcg::tri::io::ExporterPLY<Mesh>::ErrorMsg(error));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_truth: %s\n", error.what());
  }
  return 1;
}
