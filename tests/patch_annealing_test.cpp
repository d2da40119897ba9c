// Patches of spoilt meshes, annealed.
#include "edge_optimisation/patch_annealing.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <thread>

#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "mesh/face_patches.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_pairs;
using testing::crossing_spheres;
using testing::expect_closed_manifold;
using testing::icosphere;
using testing::Random;

constexpr std::int64_t kManyTests = 100000000;
constexpr FlipLimits kLimits{-1.0, 1e-3};

struct Annealed {
  bool has_helped;
  std::int64_t moves;  // that were made
};

Annealed anneal(SurfaceMesh& mesh, const std::vector<Index>& patch, Progress& progress,
                const std::vector<Index>& fixed = {}, std::int64_t moves = 1000000,
                const AnnealingOptions& options = {}) {
  FaceMeetings meetings(mesh, kManyTests, progress);
  HingeFlips hinges(mesh, meetings, fixed);
  const Index before = meetings.pair_count();
  std::int64_t left = moves;
  const bool has_helped = anneal_patch(hinges, patch, kLimits, options, left, progress, 0.0);
  EXPECT_EQ(meetings.pair_count(), count_pairs(mesh)) << "what is known of the pairs is right";
  EXPECT_EQ(has_helped, meetings.pair_count() < before);
  EXPECT_GE(left, 0);
  return {has_helped, moves - left};
}

// The faces with a corner above a height, ascending.
std::vector<Index> cap_of(const SurfaceMesh& mesh, double z) {
  std::vector<Index> cap;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    const Triangle t = mesh.triangle(f);
    if (std::any_of(t.begin(), t.end(), [&](Index v) { return mesh.position[v].z() > z; }))
      cap.push_back(f);
  }
  return cap;
}

// A sphere on whose cap vertices were shaken and edges flipped at random: a knot of meeting faces.
SurfaceMesh spoilt_sphere(unsigned seed, double shift = 0.1, int flips = 60) {
  Random random(seed);
  SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> cap = cap_of(mesh, 0.85);
  for (Vec3& p : mesh.position)
    if (p.z() > 0.85) p += shift * random.in_cube();
  while (flips > 0) {
    const Index h = 3 * cap[static_cast<std::size_t>(random.below(static_cast<Index>(cap.size())))];
    const bool is_inside =
        std::binary_search(cap.begin(), cap.end(), SurfaceMesh::face(mesh.twin(h)));
    if (!is_inside || !mesh.is_flip_legal(h)) continue;
    mesh.flip(h);
    --flips;
  }
  return mesh;
}

double bending_of(const SurfaceMesh& mesh) {
  double sum = 0.0;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
    const Vec3 edge = mesh.position[mesh.target(h)] - mesh.position[mesh.origin(h)];
    const double cosine = mesh.area_vector(SurfaceMesh::face(h))
                              .normalized()
                              .dot(mesh.area_vector(SurfaceMesh::face(mesh.twin(h))).normalized());
    sum += 0.5 * edge.norm() * (1.0 - cosine);
  }
  return sum;
}

TEST(PatchAnnealing, PartsAKnot) {
  Index at_first = 0, left = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SurfaceMesh mesh = spoilt_sphere(seed);
    const SurfaceMesh before = mesh;
    at_first += count_pairs(mesh);
    const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
    Progress progress;
    EXPECT_TRUE(anneal(mesh, patch, progress).has_helped);
    left += count_pairs(mesh);
    EXPECT_EQ(mesh.position, before.position);
    expect_closed_manifold(mesh, 1, 0);
    for (Index f = 0; f < mesh.face_slots(); ++f)
      EXPECT_TRUE(mesh.triangle(f) == before.triangle(f) ||
                  std::binary_search(patch.begin(), patch.end(), f))
          << "face " << f;
  }
  EXPECT_GT(at_first, 150);
  EXPECT_EQ(left, 0);
}

TEST(PatchAnnealing, ChanceAndRelocationsAreOfUse) {
  const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
  const auto left_with = [&](const AnnealingOptions& options) {
    Index left = 0;
    for (unsigned seed = 0; seed < 16; ++seed) {
      SurfaceMesh mesh = spoilt_sphere(seed, 0.3);
      Progress progress;
      anneal(mesh, patch, progress, {}, 1000000, options);
      left += count_pairs(mesh);
    }
    return left;
  };
  AnnealingOptions cold, only_flips;
  cold.first_temperature = cold.last_temperature = 1e-6;
  only_flips.relocations = 0.0;
  const Index left = left_with({});
  EXPECT_LT(left, 0.5 * left_with(cold));
  EXPECT_LT(left, 0.1 * left_with(only_flips));
}

TEST(PatchAnnealing, LeavesTheMeshSmooth) {
  SurfaceMesh mesh = spoilt_sphere(1);
  const double spoilt = bending_of(mesh);
  Progress progress;
  anneal(mesh, cap_of(icosphere(3), 0.85), progress);
  ASSERT_EQ(count_pairs(mesh), 0);
  EXPECT_LT(bending_of(mesh), 0.6 * spoilt);
}

TEST(PatchAnnealing, BendingMayBeTheGoal) {
  AnnealingOptions options;
  options.goal = AnnealingOptions::Goal::least_bending;
  const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
  Progress progress;
  const auto anneal_once = [&](SurfaceMesh& mesh, const AnnealingOptions& with) {
    FaceMeetings meetings(mesh, kManyTests, progress);
    const std::vector<Index> none;
    HingeFlips hinges(mesh, meetings, none);
    std::int64_t moves = 1000000;
    return anneal_patch(hinges, patch, kLimits, with, moves, progress, 0.0);
  };
  const double smooth = bending_of(icosphere(3));
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SurfaceMesh mesh = spoilt_sphere(seed, 0.0);  // the vertices are on the sphere
    const Index pairs = count_pairs(mesh);
    const double spoilt = bending_of(mesh);
    EXPECT_TRUE(anneal_once(mesh, options));
    EXPECT_LE(count_pairs(mesh), pairs);
    EXPECT_LT(bending_of(mesh) - smooth, 0.1 * (spoilt - smooth));
    expect_closed_manifold(mesh, 1, 0);
  }
  // Rough surfaces would bend less if faces met, and pairs count little while it is hot.
  AnnealingOptions hot = options;
  hot.first_temperature = hot.last_temperature = 10.0;
  hot.bending_weight = 20.0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    SurfaceMesh mesh = spoilt_sphere(seed, 0.3);
    anneal(mesh, patch, progress);
    const Index pairs = count_pairs(mesh);
    anneal_once(mesh, hot);
    EXPECT_LE(count_pairs(mesh), pairs) << "seed " << seed;
  }
  // There is nothing to be gained, and what was tried is taken back.
  SurfaceMesh mesh = icosphere(3);
  EXPECT_FALSE(anneal_once(mesh, options));
  EXPECT_EQ(mesh.triangles(), icosphere(3).triangles());
}

TEST(PatchAnnealing, WithoutSuccessThePatchIsAsBefore) {
  // No edges part them.
  SurfaceMesh mesh = crossing_spheres(1);
  std::vector<Index> patch(static_cast<std::size_t>(mesh.face_slots()));
  std::iota(patch.begin(), patch.end(), 0);
  Progress progress;
  for (int i = 0; i < 20; ++i)
    if (!anneal(mesh, patch, progress).has_helped) break;  // as few as there can be
  const std::vector<Triangle> before = mesh.triangles();
  AnnealingOptions hot;  // to the end, with pairs to be taken back
  hot.last_temperature = hot.first_temperature;
  const Annealed again = anneal(mesh, patch, progress, {}, 1000000, hot);
  EXPECT_FALSE(again.has_helped);
  EXPECT_EQ(mesh.triangles(), before);
  EXPECT_TRUE(mesh.is_consistent());
  EXPECT_GT(again.moves, 0);
}

TEST(PatchAnnealing, MakesNoMoreMovesThanItMay) {
  const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
  Progress progress;
  AnnealingOptions options;
  for (const std::int64_t moves : {0, 1, 100}) {
    SurfaceMesh mesh = spoilt_sphere(2);
    EXPECT_LE(anneal(mesh, patch, progress, {}, moves).moves, moves);
  }
  options.moves_per_face = 3;
  SurfaceMesh mesh = spoilt_sphere(2);
  EXPECT_LE(anneal(mesh, patch, progress, {}, 1000000, options).moves,
            static_cast<std::int64_t>(3 * patch.size()));
  EXPECT_FALSE(anneal(mesh, {}, progress).has_helped);
}

TEST(PatchAnnealing, FixedFacesStay) {
  SurfaceMesh mesh = spoilt_sphere(3);
  const SurfaceMesh before = mesh;
  const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
  const std::vector<Index> fixed(patch.begin(), patch.begin() + 10);
  Progress progress;
  anneal(mesh, patch, progress, fixed);
  for (const Index f : fixed) EXPECT_EQ(mesh.triangle(f), before.triangle(f));
  EXPECT_NE(mesh.triangles(), before.triangles());
}

TEST(PatchAnnealing, SameEveryTime) {
  const std::vector<Index> patch = cap_of(icosphere(3), 0.85);
  Progress progress;
  SurfaceMesh first = spoilt_sphere(4), second = spoilt_sphere(4);
  anneal(first, patch, progress);
  anneal(second, patch, progress);
  EXPECT_EQ(first.triangles(), second.triangles());
}

// Spoilt spheres apart from each other.
SurfaceMesh spoilt_spheres(unsigned count) {
  std::vector<SurfaceMesh> spheres;
  for (unsigned i = 0; i < count; ++i)
    spheres.push_back(testing::placed(spoilt_sphere(i), 1.0, Vec3(3.0 * i, 0.0, 0.0)));
  return testing::joined(spheres);
}

struct AnnealedAround {
  SurfaceMesh mesh;
  std::vector<AnnealedPatch> better;
  std::int64_t moves_left, tests;
};

AnnealedAround anneal_all(SurfaceMesh mesh, const std::vector<std::vector<Index>>& sets, int rings,
                          int threads, std::int64_t moves = 10000000,
                          std::int64_t tests = kManyTests, const AnnealingOptions& options = {}) {
  AnnealedAround result{std::move(mesh), {}, moves, 0};
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Progress progress;
    FaceMeetings meetings(result.mesh, tests, progress);
    const std::vector<Index> none;
    HingeFlips hinges(result.mesh, meetings, none);
    result.better =
        anneal_around(hinges, sets, rings, kLimits, options, result.moves_left, progress, 0.0);
    EXPECT_EQ(meetings.pair_count(), count_pairs(result.mesh)) << "what is known is right";
    result.tests = meetings.tests();
  });
  return result;
}

// The faces that meet others, in sets that do not touch each other.
std::vector<std::vector<Index>> sets_of(const SurfaceMesh& mesh) {
  Progress progress;
  const FaceMeetings meetings(mesh, kManyTests, progress);
  return clusters_of(mesh, meetings.faces());
}

// A sphere with small knots all over, many of them close to others.
SurfaceMesh shaken_sphere(unsigned seed) {
  Random random(seed);
  SurfaceMesh mesh = icosphere(4);
  for (Vec3& p : mesh.position) p += 0.05 * random.in_cube();
  return mesh;
}

TEST(AnnealAround, IsAsOnePatchAfterTheOther) {
  for (const SurfaceMesh& mesh : {spoilt_spheres(12), shaken_sphere(1), shaken_sphere(2)}) {
    const std::vector<std::vector<Index>> sets = sets_of(mesh);
    ASSERT_GT(sets.size(), 12u);
    SurfaceMesh expected = mesh;
    std::size_t better = 0;
    std::int64_t moves = 0, most = 0;  // that all make, and that one may make
    {
      Progress progress;
      FaceMeetings meetings(expected, kManyTests, progress);
      const std::vector<Index> none;
      HingeFlips hinges(expected, meetings, none);
      for (const std::vector<Index>& set : sets) {
        if (meetings.pairs_of(set).empty()) continue;
        const std::vector<Index> patch = faces_near(expected, set, 1);
        std::int64_t left = 1000000;
        if (anneal_patch(hinges, patch, kLimits, {}, left, progress, 0.0)) ++better;
        moves += 1000000 - left;
        most = std::max(
            most, AnnealingOptions().moves_per_face * static_cast<std::int64_t>(patch.size()));
      }
    }
    ASSERT_LT(2 * count_pairs(expected), count_pairs(mesh));
    for (const int threads : {1, 2, 5}) {
      SCOPED_TRACE(threads);
      const AnnealedAround found = anneal_all(mesh, sets, 1, threads);
      EXPECT_EQ(found.mesh.triangles(), expected.triangles());
      EXPECT_TRUE(found.mesh.is_consistent());
      EXPECT_EQ(found.better.size(), better);
      EXPECT_EQ(found.moves_left, 10000000 - moves);
    }
    // Moves that some leave are of use to others.
    const AnnealedAround in_brief = anneal_all(mesh, sets, 1, 2, moves + most);
    EXPECT_EQ(in_brief.mesh.triangles(), expected.triangles());
    EXPECT_EQ(in_brief.moves_left, most);
  }
}

TEST(AnnealAround, TellsWhatHasChanged) {
  const SurfaceMesh mesh = spoilt_spheres(3);
  std::vector<std::vector<Index>> sets = sets_of(mesh);
  const AnnealedAround found = anneal_all(mesh, sets, 2, 2);
  std::vector<Index> changed;
  for (const AnnealedPatch& patch : found.better) {
    EXPECT_TRUE(std::includes(patch.faces.begin(), patch.faces.end(), patch.changed.begin(),
                              patch.changed.end()));
    changed.insert(changed.end(), patch.changed.begin(), patch.changed.end());
  }
  ASSERT_FALSE(changed.empty());
  for (Index f = 0; f < mesh.face_slots(); ++f)
    EXPECT_TRUE(found.mesh.triangle(f) == mesh.triangle(f) ||
                std::count(changed.begin(), changed.end(), f) > 0)
        << "face " << f;
}

TEST(AnnealAround, MakesNoMoreMovesAndTestsThanItMay) {
  const SurfaceMesh mesh = spoilt_spheres(6);
  const std::vector<std::vector<Index>> sets = sets_of(mesh);
  for (const std::int64_t moves : {0, 1, 1000, 7001}) {
    const AnnealedAround one = anneal_all(mesh, sets, 1, 1, moves);
    const AnnealedAround two = anneal_all(mesh, sets, 1, 2, moves);
    EXPECT_GE(one.moves_left, 0);
    EXPECT_EQ(one.moves_left, two.moves_left);
    EXPECT_EQ(one.mesh.triangles(), two.mesh.triangles());
  }
  for (const std::int64_t tests : {0, 10, 20000}) {
    const AnnealedAround one = anneal_all(mesh, sets, 1, 1, 10000000, tests);
    const AnnealedAround two = anneal_all(mesh, sets, 1, 2, 10000000, tests);
    EXPECT_LE(one.tests, tests);
    EXPECT_EQ(one.tests, two.tests);
    EXPECT_EQ(one.mesh.triangles(), two.mesh.triangles());
  }
  AnnealingOptions hot;  // to the end
  hot.first_temperature = hot.last_temperature = 100.0;
  hot.moves_per_set_face = 3;
  std::int64_t most = 0;
  for (const std::vector<Index>& set : sets) most += 3 * static_cast<std::int64_t>(set.size());
  EXPECT_GE(anneal_all(mesh, sets, 1, 2, 10000000, kManyTests, hot).moves_left, 10000000 - most);
}

TEST(AnnealAround, PassesOverWhatItCannotHelp) {
  const SurfaceMesh sphere = icosphere(3), mesh = spoilt_sphere(1);
  const std::vector<Index> cap = cap_of(icosphere(3), 0.85);
  EXPECT_EQ(anneal_all(sphere, {cap}, 1, 1).moves_left, 10000000) << "nothing meets";
  std::vector<Index> all(static_cast<std::size_t>(mesh.face_slots()));
  std::iota(all.begin(), all.end(), 0);
  ASSERT_GT(all.size(), kLargestPatch);
  EXPECT_EQ(anneal_all(mesh, {all}, 0, 1).moves_left, 10000000) << "a heap";
  EXPECT_EQ(anneal_all(mesh, {all, cap}, 0, 1).better.size(), 1u);
  const std::vector<Index> most = cap_of(icosphere(3), 0.35);
  ASSERT_LT(most.size(), kLargestPatch);
  EXPECT_LT(anneal_all(mesh, {most}, 0, 1).moves_left, 10000000);
  ASSERT_GT(faces_near(mesh, most, 1).size(), kLargestPatch);
  EXPECT_EQ(anneal_all(mesh, {most}, 1, 1).moves_left, 10000000);
  AnnealingOptions bending;
  bending.goal = AnnealingOptions::Goal::least_bending;
  EXPECT_TRUE(anneal_all(mesh, {{}}, 1, 1, 10000000, kManyTests, bending).better.empty());
  AnnealingOptions off;
  off.moves_per_face = 0;
  EXPECT_TRUE(anneal_all(mesh, {cap}, 0, 1, 10000000, kManyTests, off).better.empty());
}

TEST(PatchAnnealing, CanBeCancelled) {
  SurfaceMesh mesh = spoilt_sphere(5);
  Progress progress([](double, const char*) { return false; }, {Stage::edge_optimisation});
  Progress silent;
  FaceMeetings meetings(mesh, kManyTests, silent);
  const std::vector<Index> none;
  HingeFlips hinges(mesh, meetings, none);
  EXPECT_THROW(progress.begin(Stage::edge_optimisation), Cancelled);
  std::int64_t moves = 1000;
  EXPECT_THROW(anneal_patch(hinges, cap_of(icosphere(3), 0.85), kLimits, {}, moves, progress, 0.0),
               Cancelled);
}

TEST(AnnealAround, CanBeCancelledWithinAPatch) {
  SurfaceMesh mesh = spoilt_spheres(6);
  const std::vector<Triangle> before = mesh.triangles();
  Progress silent;
  FaceMeetings meetings(mesh, kManyTests, silent);
  const std::vector<Index> none;
  HingeFlips hinges(mesh, meetings, none);
  int calls = 0;
  const auto stop_at_third_call = [&](double, const char*) {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));  // so that the next one is due
    return ++calls < 3;
  };
  Progress progress(stop_at_third_call, {Stage::edge_optimisation});
  progress.begin(Stage::edge_optimisation);
  tbb::task_arena arena(1);
  std::int64_t moves = 10000000;
  EXPECT_THROW(arena.execute([&] {
    anneal_around(hinges, sets_of(mesh), 1, kLimits, {}, moves, progress, 0.0);
  }),
               Cancelled);
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(mesh.triangles(), before) << "before the first move";
}

}  // namespace
}  // namespace shrinkwrap
