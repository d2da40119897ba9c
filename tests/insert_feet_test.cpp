// The feet of samples as vertices of the surface.
#include "complete_matching/insert_feet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

// `count` feet at one place of a face.
SampleFeet feet_at(const SurfaceMesh& surface, const SampleFoot& foot, Index count) {
  SampleFeet feet;
  feet.foot.assign(static_cast<std::size_t>(count), foot);
  for (Index i = 0; i < count; ++i) feet.by_face.push_back(i);
  for (Index f = 0; f <= surface.face_slots(); ++f)
    feet.begin.push_back(f <= foot.face ? 0 : count);
  return feet;
}

double least_area(const SurfaceMesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < mesh.face_slots(); ++f) least = std::min(least, mesh.area_vector(f).norm());
  return least;
}

TEST(InsertFeet, ManyAtOneCornerLeaveNoFaceWithoutAnArea) {
  constexpr Index kFeet = 2000;
  const SurfaceMesh surface = icosphere(0);
  for (const SampleFoot& foot : {SampleFoot{3, 0.0f, 0.0f}, SampleFoot{3, 1.0f, 0.0f},
                                 SampleFoot{3, 0.0f, 1.0f}, SampleFoot{3, 0.3f, 0.2f}}) {
    Progress silent;
    const SurfaceMesh mesh = insert_feet(surface, feet_at(surface, foot, kFeet), silent);
    expect_closed_manifold(mesh, 1, 0);
    EXPECT_EQ(mesh.vertex_count(), surface.vertex_count() + kFeet);
    EXPECT_GT(least_area(mesh), 0.0) << foot.weight_b << ' ' << foot.weight_c;
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
