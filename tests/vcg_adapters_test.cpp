// The adapters on meshes of a user's own types, judged by vcglib itself.
#include <gtest/gtest.h>
#include <vcg/complex/algorithms/clean.h>
#include <vcg/complex/algorithms/create/platonic.h>

#include <set>
#include <tuple>

#include "mesh_to_vcg.h"
#include "shapes.h"
#include "shrinkwrap_reconstruct.h"
#include "surface_mesh_from_vcg.h"

namespace {

using namespace shrinkwrap;
using shrinkwrap::testing::sample_shape;
using shrinkwrap::testing::ShapeKind;

// A mesh with everything in place, single precision.
class FloatVertex;
class FloatFace;
struct FloatTypes
    : vcg::UsedTypes<vcg::Use<FloatVertex>::AsVertexType, vcg::Use<FloatFace>::AsFaceType> {};
class FloatVertex : public vcg::Vertex<FloatTypes, vcg::vertex::Coord3f, vcg::vertex::Normal3f,
                                       vcg::vertex::Color4b, vcg::vertex::Qualityf,
                                       vcg::vertex::BitFlags, vcg::vertex::Mark> {};
class FloatFace : public vcg::Face<FloatTypes, vcg::face::VertexRef, vcg::face::Normal3f,
                                   vcg::face::FFAdj, vcg::face::BitFlags, vcg::face::Mark> {};
class FloatMesh : public vcg::tri::TriMesh<std::vector<FloatVertex>, std::vector<FloatFace>> {
 public:
  ~FloatMesh() { ClearAttributes(); }  // which vcglib's own destructor leaves to the user
};

// As little as possible, optional components, double precision.
class DoubleVertex;
class DoubleFace;
struct DoubleTypes
    : vcg::UsedTypes<vcg::Use<DoubleVertex>::AsVertexType, vcg::Use<DoubleFace>::AsFaceType> {};
class DoubleVertex
    : public vcg::Vertex<DoubleTypes, vcg::vertex::InfoOcf, vcg::vertex::Coord3d,
                         vcg::vertex::BitFlags, vcg::vertex::RadiusfOcf, vcg::vertex::Mark> {};
class DoubleFace
    : public vcg::Face<DoubleTypes, vcg::face::InfoOcf, vcg::face::VertexRef, vcg::face::FFAdjOcf,
                       vcg::face::QualityfOcf, vcg::face::BitFlags, vcg::face::Mark> {};
class DoubleMesh : public vcg::tri::TriMesh<vcg::vertex::vector_ocf<DoubleVertex>,
                                            vcg::face::vector_ocf<DoubleFace>> {
 public:
  ~DoubleMesh() { ClearAttributes(); }
};

// Normals of the vertices alone. (Faces without normals name the type of these for theirs.)
class ShadedVertex;
class ShadedFace;
struct ShadedTypes
    : vcg::UsedTypes<vcg::Use<ShadedVertex>::AsVertexType, vcg::Use<ShadedFace>::AsFaceType> {};
class ShadedVertex : public vcg::Vertex<ShadedTypes, vcg::vertex::Coord3f, vcg::vertex::Normal3f,
                                        vcg::vertex::BitFlags, vcg::vertex::Mark> {};
class ShadedFace : public vcg::Face<ShadedTypes, vcg::face::VertexRef, vcg::face::FFAdj,
                                    vcg::face::BitFlags, vcg::face::Mark> {};
class ShadedMesh : public vcg::tri::TriMesh<std::vector<ShadedVertex>, std::vector<ShadedFace>> {};

// Normals of the faces alone.
class FacetedVertex;
class FacetedFace;
struct FacetedTypes
    : vcg::UsedTypes<vcg::Use<FacetedVertex>::AsVertexType, vcg::Use<FacetedFace>::AsFaceType> {};
class FacetedVertex : public vcg::Vertex<FacetedTypes, vcg::vertex::Coord3f, vcg::vertex::BitFlags,
                                         vcg::vertex::Mark> {};
class FacetedFace : public vcg::Face<FacetedTypes, vcg::face::VertexRef, vcg::face::Normal3f,
                                     vcg::face::FFAdj, vcg::face::BitFlags, vcg::face::Mark> {};
class FacetedMesh : public vcg::tri::TriMesh<std::vector<FacetedVertex>, std::vector<FacetedFace>> {
};

// Optional normals of both.
class OptionalVertex;
class OptionalFace;
struct OptionalTypes
    : vcg::UsedTypes<vcg::Use<OptionalVertex>::AsVertexType, vcg::Use<OptionalFace>::AsFaceType> {};
class OptionalVertex
    : public vcg::Vertex<OptionalTypes, vcg::vertex::InfoOcf, vcg::vertex::Coord3f,
                         vcg::vertex::Normal3fOcf, vcg::vertex::BitFlags, vcg::vertex::Mark> {};
class OptionalFace : public vcg::Face<OptionalTypes, vcg::face::InfoOcf, vcg::face::VertexRef,
                                      vcg::face::Normal3fOcf, vcg::face::FFAdjOcf,
                                      vcg::face::BitFlags, vcg::face::Mark> {};
class OptionalMesh : public vcg::tri::TriMesh<vcg::vertex::vector_ocf<OptionalVertex>,
                                              vcg::face::vector_ocf<OptionalFace>> {};

template <class Mesh>
void enable_adjacency(Mesh&) {}
template <>
void enable_adjacency(DoubleMesh& mesh) {
  mesh.face.EnableFFAdjacency();
}
template <>
void enable_adjacency(OptionalMesh& mesh) {
  mesh.face.EnableFFAdjacency();
}

template <class Mesh>
void fill(Mesh& mesh, const std::vector<Vec3>& points) {
  using Scalar = typename Mesh::ScalarType;
  vcg::tri::Allocator<Mesh>::AddVertices(mesh, points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      mesh.vert[i].P()[axis] = static_cast<Scalar>(points[i][axis]);
}

template <class Mesh>
std::set<std::tuple<double, double, double>> positions(const Mesh& mesh) {
  std::set<std::tuple<double, double, double>> result;
  for (const auto& vertex : mesh.vert)
    if (!vertex.IsD()) result.emplace(vertex.cP()[0], vertex.cP()[1], vertex.cP()[2]);
  return result;
}

template <class Mesh>
double volume(const Mesh& mesh) {
  double six_volumes = 0.0;
  for (const auto& face : mesh.face) {
    const auto a = vcg::Point3d::Construct(face.cP(0)), b = vcg::Point3d::Construct(face.cP(1)),
               c = vcg::Point3d::Construct(face.cP(2));
    six_volumes += a * (b ^ c);
  }
  return six_volumes / 6.0;
}

template <class Mesh>
class Adapters : public ::testing::Test {};
using MeshTypes = ::testing::Types<FloatMesh, DoubleMesh, ShadedMesh, FacetedMesh, OptionalMesh>;
TYPED_TEST_SUITE(Adapters, MeshTypes);

TYPED_TEST(Adapters, ReconstructionIsClosedManifoldForVcglib) {
  TypeParam cloud, mesh;
  fill(cloud, sample_shape(ShapeKind::torus, 3000, 1));
  const Reconstruction result = shrinkwrap_reconstruct(cloud, mesh);
  enable_adjacency(mesh);
  vcg::tri::UpdateTopology<TypeParam>::FaceFace(mesh);

  EXPECT_EQ(mesh.VN(), 3000);
  EXPECT_EQ(vcg::tri::Clean<TypeParam>::CountNonManifoldEdgeFF(mesh), 0);
  EXPECT_EQ(vcg::tri::Clean<TypeParam>::CountNonManifoldVertexFF(mesh), 0);
  EXPECT_TRUE(vcg::tri::Clean<TypeParam>::IsWaterTight(mesh));
  EXPECT_TRUE(vcg::tri::Clean<TypeParam>::IsCoherentlyOrientedMesh(mesh));
  EXPECT_EQ(vcg::tri::Clean<TypeParam>::CountConnectedComponents(mesh), 1);
  EXPECT_EQ(vcg::tri::Clean<TypeParam>::MeshGenus(mesh), 1);
  EXPECT_GT(volume(mesh), 0.0) << "not oriented outwards";
  EXPECT_EQ(positions(mesh), positions(cloud)) << "the vertices are not the samples";
  EXPECT_EQ(result.report.samples_matched, 3000);
  EXPECT_FALSE(mesh.bbox.IsNull());
}

TYPED_TEST(Adapters, LeavesTheMeshAloneWhenItFails) {
  TypeParam cloud, mesh;
  fill(cloud, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  fill(mesh, {{7, 8, 9}});
  EXPECT_THROW(shrinkwrap_reconstruct(cloud, mesh), InvalidInput);
  EXPECT_EQ(mesh.VN(), 1);
  // A cloud that is to be its own mesh would lose what its points have.
  TypeParam both;
  fill(both, sample_shape(ShapeKind::sphere, 100, 1));
  EXPECT_THROW(shrinkwrap_reconstruct(both, both), InvalidInput);
  EXPECT_EQ(both.FN(), 0);
}

TEST(VcgAdapters, ReadsLiveAndSelectedVerticesOnly) {
  FloatMesh cloud;
  fill(cloud, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  vcg::tri::Allocator<FloatMesh>::DeleteVertex(cloud, cloud.vert[1]);
  cloud.vert[1].SetS();
  cloud.vert[3].SetS();
  EXPECT_EQ(points_from_vcg(cloud).vertex_index, (std::vector<std::size_t>{0, 2, 3}));
  const VcgPoints selected = points_from_vcg(cloud, true);
  EXPECT_EQ(selected.vertex_index, (std::vector<std::size_t>{3}));
  EXPECT_EQ(selected.points.front(), Vec3(3, 0, 0));
}

TEST(VcgAdapters, ReadsLiveFacesOverLiveVertices) {
  FloatMesh mesh;
  vcg::tri::Tetrahedron(mesh);
  const auto extra = vcg::tri::Allocator<FloatMesh>::AddVertices(mesh, 1);
  vcg::tri::Allocator<FloatMesh>::DeleteVertex(mesh, *extra);
  vcg::tri::Allocator<FloatMesh>::DeleteFace(mesh, mesh.face[0]);
  const ResultMesh triangles = triangles_from_vcg(mesh);
  EXPECT_EQ(triangles.position.size(), 4u);
  EXPECT_EQ(triangles.triangles.size(), 3u);
  EXPECT_TRUE(triangles.face_quality.empty());
}

TEST(VcgAdapters, ReadsTheFaceQualityIfThereIsOne) {
  DoubleMesh mesh;
  vcg::tri::Tetrahedron(mesh);
  EXPECT_TRUE(triangles_from_vcg(mesh).face_quality.empty()) << "not enabled";
  mesh.face.EnableQuality();
  for (std::size_t f = 0; f < mesh.face.size(); ++f) mesh.face[f].Q() = 0.5f * f;
  vcg::tri::Allocator<DoubleMesh>::DeleteFace(mesh, mesh.face[1]);
  EXPECT_EQ(triangles_from_vcg(mesh).face_quality, (std::vector<float>{0.0f, 1.0f, 1.5f}));
}

TEST(VcgAdapters, SamplesKeepWhatTheyCarry) {
  FloatMesh cloud, mesh;
  fill(cloud, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {9, 9, 9}});
  auto weight = vcg::tri::Allocator<FloatMesh>::AddPerVertexAttribute<float>(cloud, "weight");
  auto label = vcg::tri::Allocator<FloatMesh>::AddPerVertexAttribute<int>(cloud, "label");
  auto time = vcg::tri::Allocator<FloatMesh>::AddPerVertexAttribute<double>(cloud, "time");
  for (int i = 0; i < 5; ++i) {
    cloud.vert[i].C() = vcg::Color4b(10 * i, 0, 0, 255);
    cloud.vert[i].Q() = 0.5f * i;
    cloud.vert[i].SetS();
    weight[i] = 1.5f * i;
    label[i] = 100 + i;
    time[i] = 0.25 * i;
  }
  vcg::tri::Allocator<FloatMesh>::DeleteVertex(cloud, cloud.vert[0]);

  // Points are vertices 1 to 4; the result uses them in reverse, and one vertex that is no sample.
  ResultMesh result;
  result.position = {{9, 9, 9}, {0, 0, 1}, {0, 1, 0}, {5, 5, 5}};
  result.input_index = {3, 2, 1, kNone};
  result.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  mesh_to_vcg(result, cloud, points_from_vcg(cloud), mesh, {2});

  EXPECT_EQ(mesh.vert[0].C()[0], 40);
  EXPECT_EQ(mesh.vert[2].C()[0], 20);
  EXPECT_EQ(mesh.vert[1].Q(), 1.5f);
  EXPECT_EQ(mesh.vert[3].Q(), 0.0f);
  EXPECT_FALSE(mesh.vert[0].IsS());
  EXPECT_FALSE(mesh.face[1].IsS());
  EXPECT_TRUE(mesh.face[2].IsS());
  using Allocator = vcg::tri::Allocator<FloatMesh>;
  auto weight_out = Allocator::FindPerVertexAttribute<float>(mesh, "weight");
  auto label_out = Allocator::FindPerVertexAttribute<int>(mesh, "label");
  auto time_out = Allocator::FindPerVertexAttribute<double>(mesh, "time");
  ASSERT_TRUE(Allocator::IsValidHandle(mesh, weight_out));
  ASSERT_TRUE(Allocator::IsValidHandle(mesh, label_out));
  ASSERT_TRUE(Allocator::IsValidHandle(mesh, time_out));
  EXPECT_EQ(weight_out[1], 4.5f);
  EXPECT_EQ(label_out[0], 104);
  EXPECT_EQ(label_out[3], 0);
  EXPECT_EQ(time_out[2], 0.5);
  EXPECT_EQ(mesh.vert_attr.size(), 3u) << "an attribute was copied under a second type";
  EXPECT_NEAR(mesh.vert[0].N().Norm(), 1.0f, 1e-5f);
}

TEST(VcgAdapters, NothingIsLeftOfWhatWasInTheMesh) {
  const SurfaceMesh sphere = shrinkwrap::testing::icosphere(1);
  DoubleMesh cloud;
  fill(cloud, sphere.position);
  const VcgPoints points = points_from_vcg(cloud, false);
  ResultMesh result;
  result.position = sphere.position;
  result.triangles = sphere.triangles();
  result.input_index.assign(result.position.size(), kNone);

  DoubleMesh mesh;
  fill(mesh, sphere.position);
  vcg::tri::Allocator<DoubleMesh>::AddFaces(mesh, result.triangles.size());
  mesh.vert.EnableRadius();
  mesh.face.EnableQuality();
  for (auto& vertex : mesh.vert) vertex.R() = 7.0f;
  for (auto& face : mesh.face) face.Q() = 7.0f;
  // An attribute of another type than the cloud has under this name, and one that it has not.
  using Allocator = vcg::tri::Allocator<DoubleMesh>;
  Allocator::AddPerVertexAttribute<float>(mesh, "flow");
  Allocator::AddPerVertexAttribute<float>(mesh, "weight");
  Allocator::AddPerFaceAttribute<int>(mesh, "part");
  auto flow = Allocator::AddPerVertexAttribute<vcg::Point3d>(cloud, "flow");
  flow[0] = vcg::Point3d(1, 2, 3);
  result.input_index[0] = 0;
  mesh.textures.push_back("wood.png");
  mesh_to_vcg(result, cloud, points, mesh);
  EXPECT_EQ(mesh.vert_attr.size(), 1u);
  EXPECT_TRUE(mesh.face_attr.empty());
  EXPECT_TRUE(mesh.textures.empty());
  auto flow_out = Allocator::FindPerVertexAttribute<vcg::Point3d>(mesh, "flow");
  ASSERT_TRUE(Allocator::IsValidHandle(mesh, flow_out));
  EXPECT_EQ(flow_out[0], vcg::Point3d(1, 2, 3));
  EXPECT_EQ(flow_out[1], vcg::Point3d(0, 0, 0));
  ASSERT_EQ(mesh.VN(), static_cast<int>(result.position.size()));
  for (const auto& vertex : mesh.vert) EXPECT_NE(vertex.cR(), 7.0f);
  for (const auto& face : mesh.face) EXPECT_NE(face.cQ(), 7.0f);
}

// A tetrahedron with its corner at the origin, the first face in the plane z = 0.
template <class Mesh>
void reconstruct_corner(Mesh& mesh) {
  Mesh cloud;
  fill(cloud, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  ResultMesh result;
  result.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  result.input_index = {0, 1, 2, 3};
  result.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  mesh_to_vcg(result, cloud, points_from_vcg(cloud), mesh);
}

template <class Element>
void expect_normal(const Element& element, const vcg::Point3f& expected) {
  EXPECT_LT(vcg::Distance(element.cN(), expected), 1e-6f);
}

TEST(VcgAdapters, NormalsOfVerticesAndOfFacesAreComputedWhereTheyAre) {
  const vcg::Point3f corner = vcg::Point3f(-1, -1, -1).Normalize(), side(0, 0, -1);
  FloatMesh both;
  reconstruct_corner(both);
  expect_normal(both.vert[0], corner);
  expect_normal(both.face[0], side);
  ShadedMesh of_vertices;
  reconstruct_corner(of_vertices);
  expect_normal(of_vertices.vert[0], corner);
  FacetedMesh of_faces;
  reconstruct_corner(of_faces);
  expect_normal(of_faces.face[0], side);
}

TEST(VcgAdapters, OptionalNormalsAreComputedOnceEnabled) {
  OptionalMesh mesh;
  mesh.vert.EnableNormal();
  reconstruct_corner(mesh);
  expect_normal(mesh.vert[0], vcg::Point3f(-1, -1, -1).Normalize());
  mesh.face.EnableNormal();
  reconstruct_corner(mesh);
  expect_normal(mesh.face[0], vcg::Point3f(0, 0, -1));
}

TEST(VcgAdapters, ProgressCallbackMayBeNullAndMayCancel) {
  EXPECT_FALSE(progress_from_vcg(nullptr));
  FloatMesh cloud, mesh;
  fill(cloud, sample_shape(ShapeKind::sphere, 500, 1));
  static int calls = 0;
  const auto refuse = [](const int percent, const char* stage) {
    EXPECT_TRUE(percent >= 0 && percent <= 100 && stage != nullptr);
    return ++calls < 2;
  };
  EXPECT_THROW(shrinkwrap_reconstruct(cloud, mesh, {}, refuse), Cancelled);
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(mesh.VN(), 0);
}

}  // namespace
