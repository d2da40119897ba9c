#include "judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "attempt.h"
#include "shapes.h"

namespace shrinkwrap::robustness {
namespace {

struct Brick {
  Vec3 corner;
  Vec3 size = Vec3::Ones();
  bool is_inside_out = false;
};

// Bricks along the axes, scaled after they are moved.
ResultMesh mesh_of(const std::vector<Brick>& bricks, double scale, const Vec3& offset) {
  static constexpr Index kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  ResultMesh mesh;
  for (const Brick& brick : bricks) {
    const auto first = static_cast<Index>(mesh.position.size());
    for (int i = 0; i < 8; ++i) {
      const Vec3 place(i & 1, i >> 1 & 1, i >> 2 & 1);
      mesh.position.push_back(scale * (brick.corner + place.cwiseProduct(brick.size) + offset));
    }
    for (const auto& side : kSides)
      for (const int k : {1, 2}) {
        Triangle t = {first + side[0], first + side[k], first + side[k + 1]};
        if (brick.is_inside_out) std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
      }
  }
  return mesh;
}

TEST(Judge, FindsAComponentThatIsInsideOut) {
  for (const double scale : {1e-250, 1e-12, 1.0, 1e12, 1e250})
    for (const double offset : {0.0, 1.0, 1e9}) {
      SCOPED_TRACE(std::to_string(scale) + " " + std::to_string(offset));
      const Brick brick{Vec3::Zero()}, other{Vec3(3.0, 0.0, 0.0)};
      Brick turned = other;
      turned.is_inside_out = true;
      const Vec3 far = Vec3::Constant(offset);
      EXPECT_TRUE(bounds_a_volume(mesh_of({brick, other}, scale, far)));
      EXPECT_FALSE(bounds_a_volume(mesh_of({brick, turned}, scale, far)));
    }
}

// Of samples in one plane, rounded: nobody can tell the side.
TEST(Judge, KnowsACavityFarFromTheOrigin) {
  for (const double offset : {0.0, 1e6, 1e9}) {
    SCOPED_TRACE(offset);
    const Brick brick{Vec3::Zero()};
    Brick cavity{Vec3::Constant(0.25), Vec3::Constant(0.5)};
    const Vec3 far(offset, 0.0, -10.0 * offset);
    EXPECT_FALSE(bounds_a_volume(mesh_of({brick, cavity}, 1.0, far)));
    cavity.is_inside_out = true;
    EXPECT_TRUE(bounds_a_volume(mesh_of({brick, cavity}, 1.0, far)));
  }
}

TEST(Judge, AComponentAsThinAsRoundingHasNoSide) {
  for (const bool is_inside_out : {false, true}) {
    const Brick brick{Vec3::Zero()};
    Brick thin{Vec3(3.0, 0.0, 0.0), Vec3(1.0, 1.0, 1e-16)}, plate = thin;
    thin.is_inside_out = plate.is_inside_out = is_inside_out;
    plate.size.z() = 1e-12;
    EXPECT_TRUE(bounds_a_volume(mesh_of({brick, thin}, 1.0, Vec3::Zero())));
    EXPECT_EQ(bounds_a_volume(mesh_of({brick, plate}, 1.0, Vec3::Zero())), !is_inside_out);
  }
}

// A good mesh, and the samples that it is of.
class JudgeOfASphere : public ::testing::Test {
 protected:
  JudgeOfASphere() {
    const SurfaceMesh surface = testing::icosphere(2);
    mesh.position = samples = surface.position;
    mesh.triangles = surface.triangles();
    for (Index v = 0; v < surface.vertex_slots(); ++v) mesh.input_index.push_back(v);
  }
  Judgement judged(const std::vector<Index>& left_out = {}) const {
    return judge(samples, left_out, mesh, true);
  }
  void expect_matched(const Judgement& judgement, Index missing, Index extra, Index moved) const {
    EXPECT_EQ(judgement.missing, missing);
    EXPECT_EQ(judgement.extra, extra);
    EXPECT_EQ(judgement.moved, moved);
  }

  std::vector<Vec3> samples;
  ResultMesh mesh;
};

TEST_F(JudgeOfASphere, FindsNothingWrong) {
  const Judgement good = judged();
  expect_matched(good, 0, 0, 0);
  EXPECT_TRUE(good.closed() && good.manifold && good.outward);
  EXPECT_EQ(good.genus, 0);
  EXPECT_EQ(good.components, 1);
  EXPECT_EQ(good.repeated + good.unused + good.intersecting + good.degenerate, 0);
  EXPECT_EQ(good.samples, good.vertices);
}

TEST_F(JudgeOfASphere, FindsAVertexThatMovedByOneBit) {
  mesh.position[5].z() = std::nextafter(mesh.position[5].z(), 9.0);
  expect_matched(judged(), 1, 1, 1);
}

TEST_F(JudgeOfASphere, FindsASampleThatIsNoVertexUnlessItWasLeftOut) {
  samples.emplace_back(3.0, 0.0, 0.0);
  expect_matched(judged(), 1, 0, 0);
  expect_matched(judged({static_cast<Index>(samples.size()) - 1}), 0, 0, 0);
}

TEST_F(JudgeOfASphere, FindsAVertexThatIsNoSample) {
  samples.pop_back();
  mesh.input_index.back() = kNone;
  expect_matched(judged(), 0, 1, 0);
}

TEST_F(JudgeOfASphere, FindsAVertexAtThePlaceOfAnother) {
  mesh.position[9] = mesh.position[8];
  const Judgement judgement = judged();
  EXPECT_EQ(judgement.repeated, 1);
  expect_matched(judgement, 1, 0, 1);
}

TEST_F(JudgeOfASphere, FindsAHole) {
  mesh.triangles.pop_back();
  const Judgement judgement = judged();
  EXPECT_FALSE(judgement.closed());
  EXPECT_EQ(judgement.border_edges, 3);
  EXPECT_TRUE(judgement.manifold);
}

TEST_F(JudgeOfASphere, FindsTwoHolesWithOneVertexInCommon) {
  // Every other face around a vertex of six: each has two border edges there.
  Index hub = 0;
  const auto faces_around = [&] {
    std::vector<std::size_t> faces;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const Triangle& t = mesh.triangles[f];
      if (std::count(t.begin(), t.end(), hub) > 0) faces.push_back(f);
    }
    return faces;
  };
  while (faces_around().size() != 6) ++hub;
  const std::size_t first = faces_around().front();
  const auto shares_edge = [&](std::size_t f) {
    return std::count_if(mesh.triangles[f].begin(), mesh.triangles[f].end(), [&](Index v) {
             const Triangle& t = mesh.triangles[first];
             return std::count(t.begin(), t.end(), v) > 0;
           }) == 2;
  };
  std::size_t second = mesh.triangles.size();
  for (const std::size_t f : faces_around())
    if (f != first && !shares_edge(f)) second = f;
  ASSERT_LT(second, mesh.triangles.size());
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first));
  EXPECT_TRUE(judged().manifold);
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(second) - 1);
  EXPECT_EQ(judged().border_edges, 6);
  EXPECT_FALSE(judged().manifold);
}

TEST_F(JudgeOfASphere, FindsAnEdgeOfThreeFaces) {
  const Triangle t = mesh.triangles.front();
  mesh.triangles.push_back({t[0], t[1], mesh.triangles.back()[2]});
  EXPECT_FALSE(judged().manifold);
}

TEST_F(JudgeOfASphere, FindsAFaceThatTurnsTheOtherWay) {
  std::swap(mesh.triangles.front()[0], mesh.triangles.front()[1]);
  EXPECT_FALSE(judged().manifold);
}

TEST_F(JudgeOfASphere, FindsThatItIsInsideOut) {
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(judged().manifold);
  EXPECT_FALSE(judged().outward);
}

TEST_F(JudgeOfASphere, FindsFacesThatCutOthers) {
  const SurfaceMesh crossing = testing::crossing_spheres(2);
  mesh.position = samples = crossing.position;
  mesh.triangles = crossing.triangles();
  mesh.input_index.clear();
  const Judgement closed = judged();
  EXPECT_GT(closed.intersecting, 10);
  EXPECT_EQ(closed.components, 2);
  // However open the mesh is elsewhere.
  mesh.triangles.erase(mesh.triangles.begin());
  const Judgement open = judged();
  EXPECT_TRUE(open.manifold && !open.closed());
  EXPECT_GE(open.intersecting, closed.intersecting - 1);
}

// Of a mesh that is said to be what a run made of the samples of the sphere.
class VerdictsOnASphere : public JudgeOfASphere {
 protected:
  std::vector<Verdict> verdicts() {
    Progress progress;
    result.mesh = mesh;
    result.report = measure_mesh(mesh.position, mesh.triangles, samples, {}, progress);
    return verdicts_on(judged(), result, samples.size(), options, expectation);
  }

  Reconstruction result;
  ReconstructionOptions options;
  Expectation expectation;
};

TEST_F(VerdictsOnASphere, TellOfStagesThatAreNotClosed) {
  result.stages.resize(2);
  result.stages[1].mesh = mesh;
  EXPECT_TRUE(verdicts().empty());
  result.stages[1].mesh.triangles.pop_back();
  EXPECT_EQ(verdicts(), std::vector<Verdict>{Verdict::bad_stage_mesh});
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  EXPECT_TRUE(verdicts().empty());
}

TEST_F(VerdictsOnASphere, TellOfMoreHandlesThanWereAskedFor) {
  const SurfaceMesh torus = testing::torus_mesh(24, 12);
  mesh.position = samples = torus.position;
  mesh.triangles = torus.triangles();
  mesh.input_index.clear();
  expectation.genus = 1;
  for (const Index greatest : {kNone, 1, 0}) {
    options.initial_mesh.maximum_genus = greatest;
    const auto wrong = verdicts();
    EXPECT_EQ(std::count(wrong.begin(), wrong.end(), Verdict::genus_beyond), greatest == 0);
  }
}

TEST_F(VerdictsOnASphere, TellOfPointsLeftOutThatNobodyGave) {
  const auto given = static_cast<Index>(samples.size());
  for (const std::vector<Index>& left_out :
       {std::vector<Index>{given}, {-1}, {given - 1, given - 2}, {given - 1, given - 1}}) {
    result.outliers.input_index = left_out;
    EXPECT_EQ(verdicts(), std::vector<Verdict>{Verdict::dishonest_report});
  }
  result.outliers.input_index = {given - 2, given - 1};
  EXPECT_TRUE(verdicts().empty());
}

std::vector<Verdict> verdicts_of(const std::vector<Vec3>& points, const Expectation& expectation,
                                 const ReconstructionOptions& options = {}) {
  return attempt(points, options, expectation, {}).verdicts;
}

TEST(Attempt, TellsAMeshOfWhatMustBeRefused) {
  const std::vector<Vec3> points = testing::sample_shape(testing::ShapeKind::sphere, 500, 1);
  Expectation expectation;
  EXPECT_TRUE(verdicts_of(points, expectation).empty());
  expectation.invalid = true;
  EXPECT_EQ(verdicts_of(points, expectation), std::vector<Verdict>{Verdict::accepted_invalid});
  EXPECT_TRUE(verdicts_of({Vec3::Zero()}, expectation).empty());
}

TEST(Attempt, TellsAnOpeningWhereTheObjectHasNone) {
  std::vector<Vec3> points = testing::sample_shape(testing::ShapeKind::sphere, 2000, 1);
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  Expectation expectation;
  expectation.resolved = true;
  EXPECT_TRUE(verdicts_of(points, expectation, options).empty());
  const auto end = std::remove_if(points.begin(), points.end(),
                                  [](const Vec3& p) { return p.z() > 0.5 * p.norm(); });
  points.erase(end, points.end());
  EXPECT_EQ(verdicts_of(points, expectation, options),
            std::vector<Verdict>{Verdict::false_opening});
  expectation.open = true;
  EXPECT_TRUE(verdicts_of(points, expectation, options).empty());
}

TEST(Judge, AsksNoSideOfFlatComponents) {
  const SurfaceMesh flat = testing::flattened(testing::icosphere(2), Vec3(1, 2, 3));
  const Index first = flat.vertex_slots();
  std::vector<Vec3> samples = flat.position;
  for (const Vec3& p : flat.position) samples.push_back(p + Vec3(3, 0, 0));
  for (const int turned : {0, 1, 2}) {
    ResultMesh mesh;
    mesh.position = samples;
    mesh.triangles = flat.triangles();
    for (const Triangle& t : flat.triangles())
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    for (std::size_t f = 0; f < static_cast<std::size_t>(turned) * flat.triangles().size(); ++f)
      std::swap(mesh.triangles[f][0], mesh.triangles[f][1]);
    for (Index v = 0; v < 2 * first; ++v) mesh.input_index.push_back(v);
    const Judgement judgement = judge(samples, {}, mesh, false);
    EXPECT_EQ(judgement.components, 2);
    EXPECT_TRUE(judgement.manifold && judgement.outward);
    EXPECT_TRUE(bounds_a_volume(mesh));
  }
}

TEST(Attempt, TellsStraysFromSamples) {
  std::vector<Vec3> points = testing::sample_shape(testing::ShapeKind::sphere, 1000, 1);
  const auto last = static_cast<Index>(points.size());
  points.emplace_back(0.0, 0.0, 3.0);
  Expectation expectation;
  expectation.resolved = true;
  EXPECT_EQ(verdicts_of(points, expectation), std::vector<Verdict>{Verdict::sample_left_out});
  expectation.strays = expectation.far_strays = {last};
  EXPECT_TRUE(verdicts_of(points, expectation).empty());
  expectation.strays = expectation.far_strays = {0, last};
  EXPECT_EQ(verdicts_of(points, expectation), std::vector<Verdict>{Verdict::stray_kept});
  // Where the run is asked to keep them, they are samples like others.
  points.pop_back();
  expectation.strays = expectation.far_strays = {0};
  ReconstructionOptions options;
  options.outliers.exclude = false;
  EXPECT_TRUE(verdicts_of(points, expectation, options).empty());
}

// On a slow machine time is no promise.
TEST(Attempt, IsTooSlowOnlyByTheLimitAskedFor) {
  const std::vector<Vec3> points = testing::sample_shape(testing::ShapeKind::sphere, 500, 1);
  const auto is_too_slow = [&](const Checks& checks) {
    const Attempt made = attempt(points, {}, {}, checks);
    return std::count(made.verdicts.begin(), made.verdicts.end(), Verdict::too_slow) > 0;
  };
  Checks checks;
  EXPECT_FALSE(is_too_slow(checks));
  checks.time_limit = 100.0;
  EXPECT_FALSE(is_too_slow(checks));
  checks.time_limit = 1e-6;
  EXPECT_TRUE(is_too_slow(checks));
}

}  // namespace
}  // namespace shrinkwrap::robustness
