// The whole method: its promise over generated shapes, the tables of the paper, and what it
// refuses.
#include "reconstruct.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "expect_mesh.h"
#include "mesh/self_intersection.h"
#include "shapes.h"
#include "town.h"

namespace shrinkwrap::testing {
namespace {

Reconstruction reconstruct_silently(const std::vector<Vec3>& points,
                                    const ReconstructionOptions& options = {}) {
  Progress silent;
  return reconstruct(points, options, silent);
}

// Judged from the triangles alone: the mesh of these points, vertex i the i-th of them.
void expect_promise(const Reconstruction& result, const std::vector<Vec3>& points, Index components,
                    Index genus) {
  const ResultMesh& mesh = result.mesh;
  ASSERT_EQ(mesh.position.size(), points.size()) << "V = N";
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(mesh.position[i], points[i]);
    ASSERT_EQ(mesh.input_index[i], static_cast<Index>(i));
  }
  expect_closed_manifold(static_cast<Index>(points.size()), mesh.triangles, components, genus);
  double greatest = 0.0, volume = 0.0;
  for (const Vec3& p : points) greatest = std::max(greatest, p.cwiseAbs().maxCoeff());
  for (const Triangle& t : mesh.triangles)
    volume += (points[t[0]] / greatest)
                  .dot((points[t[1]] / greatest).cross(Vec3(points[t[2]] / greatest)));
  EXPECT_GT(volume, 0.0) << "not outward";
  EXPECT_TRUE(result.report.complete_matching());
}

struct PropertyCase {
  ShapeKind kind;
  bool evenly_spread;
};

class Property : public ::testing::TestWithParam<PropertyCase> {};

TEST_P(Property, ThePromiseHolds) {
  const Shape shape = shape_of(GetParam().kind);
  for (unsigned seed = 0; seed < 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Index count = 3500 + 700 * static_cast<Index>(seed);
    const SampleDefects defects{0.0, 0.0, seed % 2 == 1};
    const std::vector<Vec3> points = GetParam().evenly_spread
                                         ? sample_shape_blue_noise(shape.kind, count, seed, defects)
                                         : sample_shape(shape.kind, count, seed, defects);
    expect_promise(reconstruct_silently(points), points, shape.components, shape.genus);
  }
}

std::vector<PropertyCase> property_cases() {
  std::vector<PropertyCase> cases;
  for (const ShapeKind kind : closed_shapes())
    for (const bool evenly_spread : {false, true}) cases.push_back({kind, evenly_spread});
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Shapes, Property, ::testing::ValuesIn(property_cases()),
                         [](const auto& test) {
                           return shape_of(test.param.kind).name +
                                  (test.param.evenly_spread ? "_even" : "_random");
                         });

TEST(Reconstruct, AnOpeningIsClosedOrLeft) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::hemisphere, 4000, 1);
  const Reconstruction closed = reconstruct_silently(points);
  EXPECT_TRUE(closed.report.closed() && closed.report.manifold());
  EXPECT_EQ(closed.report.samples_matched, 4000);

  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  const Reconstruction open = reconstruct_silently(points, options);
  EXPECT_FALSE(open.report.closed());
  EXPECT_TRUE(open.report.manifold());
  EXPECT_EQ(open.report.border_loops, 1);
  EXPECT_EQ(open.report.samples_missing, 0);
}

// No point of the two openings of half a torus is much farther than four spacings from a sample: as
// the crow flies they are hardly told from places where samples are few.
TEST(Reconstruct, NarrowOpeningsShowAlongTheSurface) {
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  Index loops = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    SCOPED_TRACE(seed);
    std::vector<Vec3> points;
    for (const Vec3& p : sample_shape(ShapeKind::torus, 2800, seed))
      if (p.x() > 0.0) points.push_back(p);
    const Reconstruction half = reconstruct_silently(points, options);
    EXPECT_EQ(half.mesh.position.size(), points.size());
    EXPECT_EQ(half.report.components, 1);
    EXPECT_EQ(half.report.self_intersecting_faces, 0);
    loops += half.report.border_loops;
  }
  EXPECT_GT(loops, 9);
}

// The solid behind a sheet is as thin as the sheet is narrow: its back may be near the samples, and
// would cut the front. What is left open is found along the surface at once.
TEST(Reconstruct, ASheetHasOneSide) {
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  for (const Index width : {5, 10})
    for (const unsigned seed : {1u, 2u, 3u}) {
      SCOPED_TRACE(std::to_string(width) + " " + std::to_string(seed));
      const std::vector<Vec3> points = sample_strip(600, width, seed);
      const bool is_near = width == 5;
      const Reconstruction open = reconstruct_silently(points, options);
      EXPECT_FALSE(open.backs.is_taken);
      EXPECT_EQ(open.mesh.position, points);
      EXPECT_TRUE(open.report.manifold());
      EXPECT_EQ(open.report.border_loops, 1);
      EXPECT_EQ(open.report.components, 1);
      EXPECT_EQ(open.report.self_intersecting_faces, 0);

      const Reconstruction closed = reconstruct_silently(points);
      EXPECT_EQ(closed.backs.is_taken, is_near);
      if (is_near) {
        EXPECT_GT(closed.backs.first.weight(), 10);
        EXPECT_LT(closed.backs.second.weight(), closed.backs.first.weight());
      }
      EXPECT_TRUE(closed.report.closed() && closed.report.manifold());
      EXPECT_EQ(closed.report.samples_missing, 0);
      EXPECT_EQ(closed.report.self_intersecting_faces, 0);
      EXPECT_LT(closed.report.vertices_extra, is_near ? 9 : 6);
    }
}

// What a roof hides is spanned by a wall, or by ground below the roof; it is no hole through the
// slab that the ground would be.
TEST(Reconstruct, ShadowsAreNoTunnels) {
  for (const bool is_oblique : {false, true}) {
    SCOPED_TRACE(is_oblique);
    const std::vector<Vec3> points = make_town({false, false, is_oblique, 3}, 1).points;
    const Reconstruction town = reconstruct_silently(points);
    EXPECT_EQ(town.report.genus, 0);
    EXPECT_EQ(town.report.components, is_oblique ? 1 : 10);  // roofs without walls are in the air
    EXPECT_EQ(town.report.self_intersecting_faces, 0);
    EXPECT_EQ(town.report.samples_matched, static_cast<Index>(points.size()));
    // A closed mesh of the samples of one roof, which is flat, encloses nothing.
    EXPECT_LT(town.report.vertices_extra, is_oblique ? 6 : 14);

    // Shadows are spanned, the outline stays a border.
    ReconstructionOptions automatic;
    automatic.complete_matching.openings = CompleteMatchingOptions::Openings::automatic;
    const Index borders = reconstruct_silently(points, automatic).report.border_loops;
    EXPECT_GE(borders, 1);
    EXPECT_LT(borders, 5);

    ReconstructionOptions as_of_bodies;
    as_of_bodies.initial_mesh.level_of_sheets = as_of_bodies.initial_mesh.level;
    as_of_bodies.initial_mesh.level_ratio_for_shadows = 0.0;
    const Reconstruction slab = reconstruct_silently(points, as_of_bodies);
    EXPECT_GT(slab.report.genus, 5);
    EXPECT_GT(slab.report.vertices_extra, town.report.vertices_extra + 2);
  }
}

// Left where the membrane below the ground was, they would be 6 and more below it.
TEST(Reconstruct, VerticesThatCloseTheUndersideOfATownAreDrawnIn) {
  for (const bool is_oblique : {false, true}) {
    SCOPED_TRACE(is_oblique);
    const Reconstruction town =
        reconstruct_silently(make_town({false, false, is_oblique, 3}, 1).points);
    ASSERT_GT(town.report.vertices_extra, 0);
    for (std::size_t v = 0; v < town.mesh.position.size(); ++v)
      if (town.mesh.input_index[v] == kNone) {
        EXPECT_GT(town.mesh.position[v].z(), -1.0);
      }
  }
}

TEST(Reconstruct, ProgressGoesOnInASecondAttempt) {
  ReconstructionOptions options;
  options.denoising.from = 1e6;  // none of another kind
  std::vector<double> begins;    // of stages
  std::string stage;
  Progress progress(
      [&](double fraction, const char* current) {
        if (current != stage) begins.push_back(fraction);
        stage = current;
        return true;
      },
      stages_of(options));
  ASSERT_TRUE(reconstruct(sample_strip(600, 5, 1), options, progress).backs.is_made);
  // Matching and edges come twice. The weights of stages are the same, so every begin is later.
  ASSERT_EQ(begins.size(), stages_of(options).size() + 2);
  for (std::size_t i = 1; i < begins.size(); ++i) EXPECT_GT(begins[i], begins[i - 1]) << i;
  // Both attempts together take the room that one would have.
  const std::size_t first = begins.size() - 5, second = begins.size() - 3;
  EXPECT_NEAR(
      begins[first + 1] - begins[first] + begins[second + 1] - begins[second],
      progress.begin_of(Stage::edge_optimisation) - progress.begin_of(Stage::complete_matching),
      1e-9);
}

TEST(Reconstruct, BacksThatWereTakenForOpeningsAreSoInASecondSurfaceToo) {
  ReconstructionOptions options;
  options.denoising.from = options.noise.high = -1.0;  // every cloud counts as noisy
  int taken = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(seed);
    Index matchings = 0;
    std::string stage;
    Progress progress(
        [&](double, const char* current) {
          if (current != stage && stage_name(Stage::complete_matching) == std::string(current))
            ++matchings;
          stage = current;
          return true;
        },
        stages_of(options));
    const Reconstruction result = reconstruct(sample_strip(400, 5, seed), options, progress);
    if (!result.smoothing.is_made) continue;
    EXPECT_TRUE(result.backs.is_taken) << "which the second surface has to tell too";
    EXPECT_EQ(matchings, 3);
    if (result.smoothing.is_taken) ++taken;
  }
  EXPECT_GT(taken, 0) << "the strips show nothing";
}

TEST(Reconstruct, WhatIsSampledFarMoreCloselyThanTheRestIsNotLost) {
  for (const Index count : {500, 700, 1000}) {
    SCOPED_TRACE(count);
    const std::vector<Vec3> points = testing::sample_spiked_ball(count, 12.0);
    const Reconstruction result = reconstruct_silently(points, {});
    EXPECT_GE(result.detail.surfaces, 2);
    EXPECT_GT(result.detail.far_at_first, 0.1);
    EXPECT_LT(result.detail.far, 0.1 * result.detail.far_at_first);
    EXPECT_GT(result.control_mesh.vertices, static_cast<Index>(points.size()) / 8);
    EXPECT_EQ(result.report.self_intersecting_faces, 0);
    EXPECT_LT(result.intersection_repair.persistent_faces(), 10);
    EXPECT_EQ(result.report.genus, 0);
    EXPECT_EQ(result.report.components, 1);
    EXPECT_EQ(result.report.vertices_extra, 0);

    ReconstructionOptions once;
    once.most_samples_far = 1.0;
    const Reconstruction coarse = reconstruct_silently(points, once);
    EXPECT_EQ(coarse.detail.surfaces, 0);
    EXPECT_GT(coarse.intersection_repair.persistent_faces(), 25);
  }
}

TEST(Reconstruct, ASurfaceThatShowsEverythingIsMadeOnce) {
  for (const double noise : {0.0, 0.5}) {
    testing::SampleDefects defects;
    defects.noise = noise;
    const std::vector<Vec3> points = sample_shape(ShapeKind::torus, 2500, 3, defects);
    const Reconstruction result = reconstruct_silently(points, {});
    EXPECT_EQ(result.detail.surfaces, 1) << noise;
    EXPECT_LE(result.detail.far_at_first, 0.01);
  }
}

TEST(Reconstruct, MostFacesAtFaultAreMadeOnce) {
  // Points of all magnitudes, as in a damaged file, show no surface.
  testing::Random random(12);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i)
    points.push_back(rounded_to_single(std::pow(10.0, 24.0 * random.uniform()) * random.in_cube()));
  ReconstructionOptions options;
  options.outliers.exclude = false;
  const Reconstruction result = reconstruct_silently(points, options);
  EXPECT_GT(result.intersection_repair.remaining_faces.size(), result.mesh.triangles.size() / 2);
  EXPECT_FALSE(result.backs.is_made);
  EXPECT_FALSE(result.smoothing.is_made);
}

TEST(Reconstruct, TablesOfThePaper) {
  // Box, control mesh and parametric surface of tables 1 and 2 for their two sample counts.
  for (const auto& [samples, initial, control, parametric] :
       {std::array<Index, 4>{12321, 1538, 772, 12322},
        std::array<Index, 4>{34267, 6146, 2144, 34274}}) {
    const std::vector<Vec3> points = sample_shape(ShapeKind::blob, samples, 2);
    const Reconstruction result = reconstruct_silently(points, as_in_the_paper());
    expect_promise(result, points, 1, 0);
    const auto vertices_of = [&](Stage stage) {
      for (const StageRecord& record : result.stages)
        if (record.name == stage_name(stage)) return record.vertices;
      return kNone;
    };
    EXPECT_EQ(vertices_of(Stage::initial_mesh), initial);
    EXPECT_EQ(vertices_of(Stage::control_mesh), control);
    EXPECT_EQ(vertices_of(Stage::parametric_surface), parametric);
    EXPECT_EQ(vertices_of(Stage::complete_matching), samples);
  }
}

TEST(Reconstruct, StopsAtTheParametricSurface) {
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  const Reconstruction result =
      reconstruct_silently(sample_shape(ShapeKind::torus, 4000, 3, {0.3, 0.0, true}), options);
  expect_closed_manifold(static_cast<Index>(result.mesh.position.size()), result.mesh.triangles, 1,
                         1);
}

TEST(Reconstruct, LargerVoxelsRefuteTheHandlesOfNoise) {
  for (const unsigned seed : {1u, 2u}) {
    SampleDefects defects;
    defects.noise = 0.8;
    const std::vector<Vec3> points = sample_shape(ShapeKind::double_torus, 8000, seed, defects);
    ReconstructionOptions options;
    options.denoising.from = 1e6;  // no second attempt, which has no such handles in any case
    options.initial_mesh.false_handles.enabled = false;  // nor would most be left
    Progress silent;
    EXPECT_EQ(reconstruct(points, options, silent).report.genus, 2);
    options.noise.second_voxel_ratio = InitialMeshOptions().second_voxel_ratio;
    EXPECT_GT(reconstruct(points, options, silent).report.genus, 2);
  }
}

// Where lines of a grid meet the object, or scans overlap: three samples a hundred thousandth of a
// spacing apart, which leave but needles around them.
TEST(Reconstruct, SamplesNextToEachOtherMakeNoFacesMeet) {
  constexpr double kSpacing = 0.065;
  for (const unsigned seed : {2u, 3u}) {
    std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, 3000, seed);
    Random random(seed);
    for (std::size_t i = 0; i < 120; ++i)
      points.push_back((points[i / 2] + 1e-5 * kSpacing * random.in_cube()).normalized());
    const Reconstruction result = reconstruct_silently(points);
    EXPECT_GT(result.intersection_repair.faces_before, 50);
    EXPECT_EQ(result.report.self_intersecting_faces, 0);
    EXPECT_EQ(result.report.samples_matched, 3120);
    EXPECT_EQ(result.report.genus, 0);
  }
}

template <class Item>
bool have_same_bits(const std::vector<Item>& a, const std::vector<Item>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0);
}

void expect_same_bits(const Reconstruction& one, const Reconstruction& two) {
  EXPECT_TRUE(have_same_bits(one.mesh.position, two.mesh.position));
  EXPECT_TRUE(have_same_bits(one.mesh.triangles, two.mesh.triangles));
  EXPECT_EQ(one.mesh.input_index, two.mesh.input_index);
  EXPECT_EQ(one.mesh.data_index, two.mesh.data_index);
  EXPECT_TRUE(have_same_bits(one.mesh.face_quality, two.mesh.face_quality));
  EXPECT_EQ(one.outliers.input_index, two.outliers.input_index);
  EXPECT_EQ(one.intersection_repair.remaining_faces, two.intersection_repair.remaining_faces);
  EXPECT_EQ(one.openings.longest_edge, two.openings.longest_edge);
}

TEST(Reconstruct, SameBytesForAnyNumberOfThreads) {
  const tbb::global_control as_on_five_cores(tbb::global_control::max_allowed_parallelism, 5);
  const std::vector<Vec3> closed = sample_shape(ShapeKind::double_torus, 12000, 4);
  // Half of a noisy blob, with stray points.
  std::vector<Vec3> half;
  for (const Vec3& p : sample_noisy_shape(ShapeKind::blob, 12000, 5, 0.1))
    if (p.x() < 0.2) half.push_back(p);
  Random random(6);
  for (int i = 0; i < 40; ++i) half.push_back(2.0 * random.in_cube());
  for (const bool is_half : {false, true})
    for (const bool as_paper : {false, true}) {
      const std::vector<Vec3>& points = is_half ? half : closed;
      SCOPED_TRACE(std::to_string(points.size()) + (as_paper ? " as in the paper" : ""));
      ReconstructionOptions options = as_paper ? as_in_the_paper() : ReconstructionOptions();
      options.threads = 1;
      const Reconstruction one = reconstruct_silently(points, options);
      if (!as_paper) {
        EXPECT_EQ(one.mesh.face_quality.empty(), !is_half);
        EXPECT_EQ(one.outliers.input_index.empty(), !is_half);
      }
      for (const int threads : {2, 5}) {
        options.threads = threads;
        expect_same_bits(one, reconstruct_silently(points, options));
      }
    }
}

// Of zero both signs.
TEST(Reconstruct, TheBitsOfTheInputAreKept) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 2000, 12);
  for (std::size_t i = 0; i < points.size(); ++i) {
    double& x = points[i][static_cast<Eigen::Index>(i % 3)];
    if (std::abs(x) < 0.02) x = i % 2 == 0 ? 0.0 : -0.0;
  }
  const ResultMesh mesh = reconstruct_silently(points).mesh;
  ASSERT_EQ(mesh.position.size(), points.size());
  EXPECT_TRUE(have_same_bits(mesh.position, points));
  Index negative_zeros = 0;
  for (const Vec3& p : mesh.position)
    for (const double x : {p.x(), p.y(), p.z()}) negative_zeros += x == 0.0 && std::signbit(x);
  EXPECT_GT(negative_zeros, 3);
}

TEST(Reconstruct, PromisesWhatTheOptionsAllow) {
  using Openings = CompleteMatchingOptions::Openings;
  for (const Openings openings : {Openings::close, Openings::leave_open, Openings::automatic})
    for (const bool stops : {false, true}) {
      ReconstructionOptions options;
      options.complete_matching.openings = openings;
      options.stop_at_parametric_surface = stops;
      const PromiseOptions promise = promise_of(options);
      EXPECT_EQ(promise.may_be_open, openings != Openings::close);
      EXPECT_EQ(promise.matches_samples, !stops);
      EXPECT_TRUE(promise.report.count_self_intersections);
    }
}

TEST(Reconstruct, AnyPlaceAndAnyScale) {
  const std::vector<Vec3> shape = sample_shape(ShapeKind::torus, 3000, 5);
  for (const double scale : {1e-300, 1e-100, 1e-12, 1e-3, 1e5, 1e12, 1e150, 1e300})
    for (const double offset : {0.0, 1000.0}) {
      SCOPED_TRACE(::testing::Message() << "scale " << scale << ", offset " << offset);
      std::vector<Vec3> points = shape;
      for (Vec3& p : points) p = scale * (p + Vec3(offset, -2.0 * offset, 0.5 * offset));
      expect_promise(reconstruct_silently(points), points, 1, 1);
    }
}

// The surface of such samples lies beyond the largest number in places.
TEST(Reconstruct, StaysFiniteBesideTheLargestNumbers) {
  for (const double largest :
       {std::numeric_limits<double>::max(), double{std::numeric_limits<float>::max()}}) {
    std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 1000, 18);
    double farthest = 0.0;
    for (const Vec3& p : points) farthest = std::max(farthest, p.cwiseAbs().maxCoeff());
    for (Vec3& p : points) {
      p = largest * Vec3(p / farthest);
      if (largest < 1e300) p = rounded_to_single(p);
    }
    for (const bool stops : {false, true}) {
      SCOPED_TRACE(::testing::Message() << largest << (stops ? ", stopped" : ""));
      ReconstructionOptions options;
      options.stop_at_parametric_surface = stops;
      const Reconstruction result = reconstruct_silently(points, options);
      EXPECT_TRUE(result.report.closed() && result.report.manifold());
      EXPECT_EQ(result.report.genus, 0);
      Index beyond = 0;
      for (const Vec3& p : result.mesh.position) beyond += !(p.cwiseAbs().maxCoeff() <= largest);
      EXPECT_EQ(beyond, 0);
      if (!stops) expect_promise(result, points, 1, 0);
    }
  }
}

TEST(Reconstruct, FewPointsWillDo) {
  for (Index count = 4; count <= 40; ++count) {
    SCOPED_TRACE(count);
    const std::vector<Vec3> points = sample_shape(ShapeKind::sphere, count, 6);
    const Reconstruction result = reconstruct_silently(points);
    EXPECT_TRUE(result.report.closed() && result.report.manifold());
    EXPECT_EQ(result.report.samples_matched, count);
  }
}

TEST(Reconstruct, BadPointsAreLeftOutAndCounted) {
  std::vector<Vec3> points = sample_shape(ShapeKind::sphere, 500, 7);
  const std::vector<Vec3> good = points;
  points.insert(points.begin() + 10, Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  points.push_back(Vec3(0, std::numeric_limits<double>::infinity(), 0));
  points.push_back(good[3]);
  const Reconstruction result = reconstruct_silently(points);
  EXPECT_EQ(result.conditioning.not_finite, 2u);
  EXPECT_EQ(result.conditioning.duplicates, 1u);
  EXPECT_EQ(result.mesh.position, good);
  EXPECT_EQ(result.mesh.input_index[10], 11);
}

TEST(Reconstruct, RefusesWhatHasNoSurface) {
  const auto grid = [](int dimensions) {
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i)
      for (int j = 0; j < (dimensions > 1 ? 20 : 1); ++j)
        points.emplace_back(0.1 * i, 0.1 * j, 0.3 * i + 0.2 * j);
    return points;
  };
  EXPECT_THROW(reconstruct_silently({}), InvalidInput);
  EXPECT_THROW(reconstruct_silently({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), InvalidInput);
  EXPECT_THROW(reconstruct_silently(std::vector<Vec3>(50, Vec3(1, 2, 3))), InvalidInput);
  EXPECT_THROW(reconstruct_silently(grid(1)), InvalidInput) << "collinear";
  EXPECT_THROW(reconstruct_silently(grid(2)), InvalidInput) << "coplanar";
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(reconstruct_silently(std::vector<Vec3>(50, Vec3(nan, nan, nan))), InvalidInput);
}

TEST(Reconstruct, TellsWhatToDoAboutWhatItRefuses) {
  const auto message_for = [](const std::vector<Vec3>& points) -> std::string {
    try {
      reconstruct_silently(points);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  const auto expect_words = [](const std::string& message, const std::vector<std::string>& words) {
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << word << ": " << message;
  };
  std::vector<Vec3> line, plane;
  for (int i = 0; i < 400; ++i) {
    line.emplace_back(0.1 * i, 0.2 * i, 0.0);
    plane.emplace_back(i % 20, i / 20, 0.5);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_words(message_for({}), {"Load or select more points"});
  expect_words(message_for({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}),
               {"at least 4", "Load or select more points"});
  expect_words(message_for(std::vector<Vec3>(50, Vec3(1, 2, 3))), {"at least 4", "more points"});
  expect_words(message_for(std::vector<Vec3>(50, Vec3(nan, nan, nan))),
               {"no finite coordinates", "more points"});
  expect_words(message_for(line), {"line", "Add points off it"});
  expect_words(message_for(plane), {"plane", "Add points off it"});
}

TEST(Reconstruct, CanBeCancelledInEveryStage) {
  const std::vector<Vec3> points = sample_shape(ShapeKind::blob, 8000, 8);
  for (const Stage stage : stages_of(ReconstructionOptions())) {
    const std::string name = stage_name(stage);
    Progress progress([&](double, const char* current) { return current != name; },
                      stages_of(ReconstructionOptions()));
    EXPECT_THROW(reconstruct(points, {}, progress), Cancelled) << name;
  }
}

// Beside coordinates of 1e300 those of 1e-310 vanish in the unit frame, where the repair counts.
TEST(Reconstruct, ReportsTheIntersectionsOfTheMeshAsItIs) {
  const std::vector<Vec3> shape = sample_shape(ShapeKind::sphere, 300, 15);
  std::vector<Vec3> points;
  for (const double scale : {1e300, 1e-310})
    for (const Vec3& p : shape) points.push_back(scale * p);
  const Reconstruction result = reconstruct_silently(points);
  Progress silent;
  const std::vector<Index> meeting =
      self_intersecting_faces(result.mesh.position, result.mesh.triangles, silent);
  EXPECT_FALSE(meeting.empty());
  EXPECT_EQ(result.report.self_intersecting_faces, static_cast<Index>(meeting.size()));
  EXPECT_EQ(result.intersection_repair.remaining_faces, meeting);
}

TEST(Reconstruct, RefusesWhatDoesNotFitInMemory) {
  ReconstructionOptions options;
  options.memory_limit = 100000;
  EXPECT_THROW(reconstruct_silently(sample_shape(ShapeKind::sphere, 5000, 9), options),
               InvalidInput);
}

}  // namespace
}  // namespace shrinkwrap::testing
