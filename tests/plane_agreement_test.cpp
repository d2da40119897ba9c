// The share of a mesh that stands across the tangent planes of its samples.
#include "report/plane_agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "shapes.h"

namespace shrinkwrap {
namespace {

// Vertices and faces of a sphere, the vertices also as the samples of a cloud.
class PlaneAgreement : public ::testing::Test {
 protected:
  PlaneAgreement() {
    const SurfaceMesh sphere = testing::icosphere(3);
    mesh_.triangles = sphere.triangles();
    for (const Vec3& p : sphere.position) mesh_.position.push_back(1e3 * p + Vec3(5e4, 0, 0));
    mesh_.input_index.resize(mesh_.position.size());
    std::iota(mesh_.input_index.begin(), mesh_.input_index.end(), 0);
    cloud_ = prepare_samples(mesh_.position, {}, progress_);
    cloud_.normal.clear();
    for (const Index i : cloud_.input_index)
      cloud_.normal.push_back(sphere.position[i].normalized().cast<float>());
  }
  double area_across() {
    return area_across_planes(mesh_, cloud_.frame, normals_of_points(cloud_), progress_);
  }

  Progress progress_;
  ResultMesh mesh_;
  PointCloud cloud_;
};

TEST_F(PlaneAgreement, IsNoneOfASphere) {
  EXPECT_EQ(area_across(), 0.0);
}

TEST_F(PlaneAgreement, FacesTheOtherWayRoundStandAcross) {
  const std::size_t turned = mesh_.triangles.size() / 4;
  for (std::size_t f = 0; f < turned; ++f) std::swap(mesh_.triangles[f][0], mesh_.triangles[f][1]);
  EXPECT_NEAR(area_across(), 0.25, 0.01);
}

TEST_F(PlaneAgreement, FacesThatSpanOpeningsAreLeftOut) {
  const std::size_t turned = mesh_.triangles.size() / 4;
  mesh_.face_quality.assign(mesh_.triangles.size(), 0.0f);
  for (std::size_t f = 0; f < turned; ++f) {
    std::swap(mesh_.triangles[f][0], mesh_.triangles[f][1]);
    mesh_.face_quality[f] = 30.0f;
  }
  EXPECT_EQ(area_across(), 0.0);
}

// Points behind those that the cloud was made of, as if it had taken them for copies.
TEST_F(PlaneAgreement, NearCopiesHaveTheNormalsOfTheirOriginals) {
  for (Index& point : mesh_.input_index) {
    const Index copy = point + cloud_.size();
    cloud_.conditioning.near_copies.push_back({copy, point});
    point = copy;
  }
  EXPECT_EQ(area_across(), 0.0);
}

TEST_F(PlaneAgreement, VerticesThatAreNoSamplesTellNothing) {
  std::fill(mesh_.input_index.begin(), mesh_.input_index.end(), kNone);
  EXPECT_EQ(area_across(), 1.0);
}

TEST_F(PlaneAgreement, AMeshWithoutFacesHasNone) {
  mesh_.triangles.clear();
  EXPECT_EQ(area_across(), 0.0);
}

}  // namespace
}  // namespace shrinkwrap
