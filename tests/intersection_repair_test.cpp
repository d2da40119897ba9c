// Meshes spoilt on purpose, and what the repair makes of them.
#include "edge_optimisation/intersection_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "expect_mesh.h"
#include "meeting_pairs.h"
#include "mesh/self_intersection.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::count_pairs;
using testing::crossing_spheres;
using testing::expect_closed_manifold;
using testing::expect_same_mesh;
using testing::icosphere;
using testing::Random;
using testing::torus_mesh;

RepairReport repair(SurfaceMesh& mesh, const RepairOptions& options = {}) {
  Progress progress;
  return repair_self_intersections(mesh, options, progress);
}

// The whole promise, but for how much is healed.
void expect_honest(const RepairReport& report, const SurfaceMesh& before, const SurfaceMesh& after,
                   Index components, Index genus) {
  EXPECT_EQ(report.before, count_pairs(before));
  EXPECT_EQ(report.after, count_pairs(after));
  EXPECT_LE(report.after, report.before);
  EXPECT_EQ(after.position, before.position) << "samples may not move";
  EXPECT_EQ(after.vertex_count(), before.vertex_count());
  expect_closed_manifold(after, components, genus);
}

void flip_at_random(SurfaceMesh& mesh, Index count, Random& random) {
  while (count > 0) {
    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_flip_legal(h)) continue;
    mesh.flip(h);
    --count;
  }
}

void shake(SurfaceMesh& mesh, double part_of_edge, Random& random) {
  const double edge = (mesh.position[mesh.target(0)] - mesh.position[mesh.origin(0)]).norm();
  for (Vec3& p : mesh.position) p += part_of_edge * edge * random.in_cube();
}

TEST(IntersectionRepair, LeavesAGoodMeshAlone) {
  SurfaceMesh mesh = torus_mesh(40, 20);
  const SurfaceMesh before = mesh;
  const RepairReport report = repair(mesh);
  EXPECT_EQ(report.before, 0);
  EXPECT_EQ(report.after, 0);
  EXPECT_EQ(report.flips, 0);
  expect_same_mesh(mesh, before);
}

// Repairs a mesh in which more than so many pairs of faces meet.
RepairReport expect_healed(SurfaceMesh mesh, Index pairs, Index genus) {
  const SurfaceMesh before = mesh;
  const RepairReport report = repair(mesh);
  EXPECT_GT(report.before, pairs);
  EXPECT_EQ(report.after, 0);
  expect_honest(report, before, mesh, 1, genus);
  return report;
}

TEST(IntersectionRepair, HealsRandomFlips) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = torus_mesh(60, 24);
    shake(mesh, 0.1, random);
    flip_at_random(mesh, 500, random);
    EXPECT_GT(expect_healed(mesh, 10, 1).flips, 0);
  }
}

TEST(IntersectionRepair, HealsShakenVertices) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = icosphere(4);
    shake(mesh, 0.5, random);
    expect_healed(mesh, 10, 0);
  }
}

TEST(IntersectionRepair, RelocatesSamplesThatChangedPlaces) {
  // The mesh joins each vertex to the neighbours of another, some edges away: flips alone leave
  // dozens of pairs.
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = icosphere(4);
    shake(mesh, 0.2, random);
    for (int i = 0; i < 20; ++i) {
      Index h = random.below(mesh.halfedge_slots());
      const Index v = mesh.origin(h);
      for (int step = 0; step < 3; ++step)
        h = mesh.rotate(mesh.rotate(mesh.rotate(mesh.twin(h))));  // straight on
      std::swap(mesh.position[v], mesh.position[mesh.origin(h)]);
    }
    EXPECT_GT(expect_healed(mesh, 200, 0).relocated, 10);
  }
}

TEST(IntersectionRepair, AnnealsWhatNothingElseParts) {
  // Samples that lie up to an edge and a half from where they were.
  Index left = 0, left_without = 0;
  int annealed = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    Random random(seed);
    SurfaceMesh mesh = icosphere(3);
    shake(mesh, 1.5, random);
    SurfaceMesh other = mesh, third = mesh;
    const RepairReport report = repair(mesh);
    RepairOptions options;
    options.annealing.moves_per_face = 0;
    const RepairReport without = repair(other, options);
    options = {};
    options.max_annealed_rings = 0;
    EXPECT_EQ(repair(third, options).faces_after, without.faces_after);
    expect_same_mesh(third, other);
    EXPECT_EQ(without.annealed, 0);
    EXPECT_EQ(without.faces_before_annealing, without.faces_after);
    EXPECT_EQ(report.faces_before_annealing, without.faces_after);
    EXPECT_EQ(report.after, count_pairs(mesh));
    left += report.faces_after;
    left_without += without.faces_after;
    annealed += report.annealed;
  }
  EXPECT_GT(left_without, 20) << "the cases are too easy";
  EXPECT_LT(left, 0.3 * left_without);
  EXPECT_GT(annealed, 5);
}

// By annealing so brief that some patches come out of it with faces that meet.
TEST(IntersectionRepair, InsistsWhereLittleIsLeft) {
  Index left = 0, left_without = 0, worse = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    Random random(seed);
    SurfaceMesh mesh = icosphere(3);
    shake(mesh, 1.6, random);
    SurfaceMesh other = mesh;
    RepairOptions options;
    options.annealing.moves_per_face = 5;
    const RepairReport report = repair(mesh, options);
    options.insists = false;
    const RepairReport without = repair(other, options);
    EXPECT_EQ(report.after, count_pairs(mesh));
    left += report.faces_after;
    left_without += without.faces_after;
    worse += report.after > without.after;
  }
  EXPECT_GE(left_without, 9) << "the cases are too easy";
  EXPECT_LT(2 * left, left_without);
  EXPECT_EQ(worse, 0);
}

TEST(IntersectionRepair, DoesWhatItCanOnAHopelessMesh) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = icosphere(2);
    for (Vec3& p : mesh.position) p = random.in_cube();
    const SurfaceMesh before = mesh;
    RepairOptions options;
    options.max_trials = 5000;
    const RepairReport report = repair(mesh, options);
    EXPECT_GT(report.after, 0);
    EXPECT_LT(report.after, report.before);
    EXPECT_EQ(report.annealed, 0) << "nor what it could not";
    expect_honest(report, before, mesh, 1, 0);
  }
}

TEST(IntersectionRepair, FacesArePersistentThatWereAnnealedOrAreLeft) {
  RepairReport report;
  report.faces_before_annealing = 7;
  EXPECT_EQ(report.persistent_faces(), 0) << "what annealing did not change";
  report.faces_after = 3;
  EXPECT_EQ(report.persistent_faces(), 3);
  report.annealed = 1;
  EXPECT_EQ(report.persistent_faces(), 7);
  report.faces_after = 8;
  EXPECT_EQ(report.persistent_faces(), 8);
}

TEST(IntersectionRepair, AFurtherRepairMayFindMoreThanTheFirst) {
  RepairReport report, further;
  further.before = 5;
  further.faces_before = 8;
  further.faces_after = 2;
  further.folds.faces_before = 6;
  further.folds.faces_after = 3;
  report.add(further);
  EXPECT_EQ(report.before, 5);
  EXPECT_EQ(report.faces_before, 8);
  EXPECT_EQ(report.faces_after, 2);
  EXPECT_EQ(report.folds.faces_before, 6);
  EXPECT_EQ(report.folds.faces_after, 3);
}

// What one left to annealing that could not be, the other may have parted by flips.
TEST(IntersectionRepair, FacesArePersistentOnlyByARepairThatAnnealed) {
  RepairReport nothing_annealed, annealed;
  nothing_annealed.faces_before_annealing = nothing_annealed.faces_after = 500;
  annealed.faces_before_annealing = 4;
  annealed.annealed = 1;
  RepairReport report = nothing_annealed;
  report.add(annealed);
  EXPECT_EQ(report.persistent_faces(), 4);
  report = annealed;
  report.add(nothing_annealed);
  EXPECT_EQ(report.persistent_faces(), 500) << "which are left";
  nothing_annealed.faces_after = 0;
  report = annealed;
  report.add(nothing_annealed);
  EXPECT_EQ(report.persistent_faces(), 4);
}

TEST(IntersectionRepair, CannotPartTwoSpheresButStops) {
  SurfaceMesh mesh = crossing_spheres(2);
  const SurfaceMesh before = mesh;
  RepairOptions options;
  options.max_trials_per_face = 100;
  const RepairReport report = repair(mesh, options);
  EXPECT_GT(report.after, 0);
  expect_honest(report, before, mesh, 2, 0);
}

TEST(IntersectionRepair, AHeapOfFacesCostsNoMoreThanItMay) {
  // Every face meets hundreds: the trials that are allowed would test 77 million pairs, and there
  // are more pairs than are kept.
  Random random(4);
  SurfaceMesh mesh = icosphere(3);
  for (Vec3& p : mesh.position) p = random.in_cube();
  const SurfaceMesh before = mesh;
  const RepairReport report = repair(mesh);
  EXPECT_GT(report.before, 50000);
  EXPECT_LT(report.before, count_pairs(before));
  EXPECT_LT(report.after, report.before);
  EXPECT_LT(count_pairs(mesh), count_pairs(before)) << "of the pairs that are not known as well";
  EXPECT_EQ(report.tests, 200000 + 20 * mesh.face_count()) << "to the test";
  const auto faces_that_meet = [](const SurfaceMesh& m) {
    Progress progress;
    return self_intersecting_faces(m.position, m.triangles(), progress);
  };
  EXPECT_EQ(report.faces_before, static_cast<Index>(faces_that_meet(before).size()));
  EXPECT_EQ(report.remaining_faces, faces_that_meet(mesh));
  EXPECT_EQ(report.faces_after, static_cast<Index>(report.remaining_faces.size()));
  EXPECT_EQ(mesh.position, before.position);
  expect_closed_manifold(mesh, 1, 0);
}

TEST(IntersectionRepair, AKnotTooLargeToBeAnnealedTakesNothingThatIsForThat) {
  Random random(1);
  SurfaceMesh mesh = icosphere(5);
  for (Vec3& p : mesh.position)
    if (p.z() > 0.9) p += 0.4 * random.in_cube();
  Progress progress;
  const RepairReport report = repair_self_intersections(mesh, {}, progress);
  ASSERT_LT(report.faces_before, kMostMeeting * mesh.face_count());
  ASSERT_GT(report.faces_after, static_cast<Index>(kLargestPatch));
  EXPECT_EQ(report.annealed, 0);
  EXPECT_EQ(report.tests, 1000000 + 20 * mesh.face_count());
}

TEST(IntersectionRepair, NoTrialsNoFlips) {
  Random random(1);
  SurfaceMesh mesh = icosphere(3);
  shake(mesh, 0.5, random);
  const SurfaceMesh before = mesh;
  RepairOptions options;
  options.max_trials_per_face = 0;
  const RepairReport report = repair(mesh, options);
  EXPECT_EQ(report.flips, 0);
  EXPECT_TRUE(report.ran_short);
  EXPECT_EQ(report.after, report.before);
  expect_same_mesh(mesh, before);
}

TEST(IntersectionRepair, TellsWhetherAllWasTried) {
  Random random(1);
  SurfaceMesh mesh = icosphere(3);
  shake(mesh, 1.5, random);
  SurfaceMesh other = mesh, third = mesh;
  const RepairReport report = repair(mesh);
  EXPECT_GT(report.faces_before_annealing, 0);
  EXPECT_FALSE(report.ran_short);
  RepairOptions options;
  options.max_rounds = 2;
  EXPECT_TRUE(repair(other, options).ran_short);
  options = {};
  options.max_trials = 20000;
  const RepairReport in_brief = repair(third, options);
  EXPECT_GT(in_brief.annealed, 0) << "which is not what it ran short of";
  EXPECT_TRUE(in_brief.ran_short);
}

TEST(IntersectionRepair, TriesNothingAgainWhereNothingHasChanged) {
  Random random(1);
  SurfaceMesh mesh = torus_mesh(60, 24);
  shake(mesh, 0.1, random);
  flip_at_random(mesh, 2000, random);
  const SurfaceMesh before = mesh;
  Progress silent;
  const auto meeting = [&] {
    return self_intersecting_faces(mesh.position, mesh.triangles(), silent);
  };
  RepairOptions options;
  options.folds.most_folded = 0.0;
  options.tried = surroundings(mesh, meeting());
  EXPECT_EQ(repair(mesh, options).flips, 0);
  expect_same_mesh(mesh, before);

  // As if all had changed on one side.
  const auto side_of = [&](const Triangle& t) {
    double least = mesh.position[t[0]].x(), most = least;
    for (const Index v : t) {
      least = std::min(least, mesh.position[v].x());
      most = std::max(most, mesh.position[v].x());
    }
    return least > 0.0 ? 1 : most < 0.0 ? -1 : 0;
  };
  const auto meeting_on_side = [&](int side) {
    const std::vector<Index> faces = meeting();
    return std::count_if(faces.begin(), faces.end(),
                         [&](Index f) { return side_of(mesh.triangle(f)) == side; });
  };
  const auto here = meeting_on_side(1), there = meeting_on_side(-1);
  EXPECT_GT(here, 50);
  EXPECT_GT(there, 50);
  options.tried.erase(std::remove_if(options.tried.begin(), options.tried.end(),
                                     [&](const Triangle& t) { return side_of(t) >= 0; }),
                      options.tried.end());
  repair(mesh, options);
  EXPECT_EQ(meeting_on_side(1), 0);
  EXPECT_GT(meeting_on_side(-1), there / 2) << "but what changes spreads";
}

TEST(IntersectionRepair, OpeningFacesStayAndDoNotCount) {
  // Every seventh face, so that most patches that are annealed have some.
  const auto is_open = [](Index f) { return f % 7 == 0; };
  const auto pairs_that_count = [&](const SurfaceMesh& mesh) {
    std::vector<Triangle> faces;
    for (Index f = 0; f < mesh.face_slots(); ++f)
      if (!is_open(f)) faces.push_back(mesh.triangle(f));
    Progress silent;
    return static_cast<Index>(self_intersections(mesh.position, faces, silent).size());
  };
  int annealed = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = icosphere(3);
    shake(mesh, 1.5, random);
    const SurfaceMesh before = mesh;
    std::vector<Index> opening_faces;
    for (Index f = 0; f < mesh.face_slots(); ++f)
      if (is_open(f)) opening_faces.push_back(f);
    Progress progress;
    const RepairReport report = repair_self_intersections(mesh, {}, progress, opening_faces);
    EXPECT_GT(report.flips, 0);
    for (const Index f : opening_faces) EXPECT_EQ(mesh.triangle(f), before.triangle(f));
    EXPECT_EQ(report.before, pairs_that_count(before));
    EXPECT_EQ(report.after, pairs_that_count(mesh));
    EXPECT_LT(report.after, report.before);
    EXPECT_GT(count_pairs(mesh), report.after);
    for (const Index f : report.remaining_faces) EXPECT_FALSE(is_open(f));
    expect_closed_manifold(mesh, 1, 0);
    annealed += report.annealed;
  }
  EXPECT_GT(annealed, 5);
}

TEST(IntersectionRepair, SameEveryTimeAndAfterRemovals) {
  Random random(7);
  SurfaceMesh mesh = icosphere(4);
  // Removed faces leave free slots, which must not matter.
  for (int i = 0; i < 200; ++i) {
    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_removed_face(SurfaceMesh::face(h)) && mesh.is_collapse_legal(h)) mesh.collapse(h);
  }
  shake(mesh, 0.5, random);
  SurfaceMesh again = mesh;
  const RepairReport first = repair(mesh), second = repair(again);
  EXPECT_GT(first.before, 0);
  EXPECT_EQ(first.flips, second.flips);
  EXPECT_EQ(mesh.triangles(), again.triangles());
  EXPECT_EQ(first.after, count_pairs(mesh));
  EXPECT_TRUE(mesh.is_consistent());
}

TEST(IntersectionRepair, MakesNoFaceDegenerate) {
  // On a lattice collinear and coplanar corners abound, and degenerate faces would meet nothing.
  Random random(3);
  SurfaceMesh mesh = icosphere(3);
  for (Vec3& p : mesh.position) p = (8.0 * p).array().round().matrix();
  const auto count_degenerate = [](const SurfaceMesh& m) {
    Index count = 0;
    for (Index f = 0; f < m.face_slots(); ++f) count += m.area_vector(f).isZero(0.0) ? 1 : 0;
    return count;
  };
  flip_at_random(mesh, 200, random);
  const Index degenerate_before = count_degenerate(mesh);
  const SurfaceMesh before = mesh;
  const RepairReport report = repair(mesh);
  EXPECT_GT(report.before, 0);
  EXPECT_LE(count_degenerate(mesh), degenerate_before);
  expect_honest(report, before, mesh, 1, 0);
}

TEST(IntersectionRepair, PartsSamplesThatNearlyCoincide) {
  // On a flat a vertex a thousandth of an edge from its neighbour has come to lie across an edge.
  // Only a needle between the two mends it.
  SurfaceMesh sphere = icosphere(4);
  constexpr double kFlat = 0.8;
  for (Vec3& p : sphere.position) p[2] = std::min(p[2], kFlat);
  const auto is_inside_flat = [&](Index v) {
    bool inside = true;
    sphere.for_each_outgoing(
        v, [&](Index h) { inside = inside && sphere.position[sphere.target(h)][2] == kFlat; });
    return inside;
  };
  int tried = 0;
  for (Index h = 0; h < sphere.halfedge_slots() && tried < 5; h += 7) {
    const Index a = sphere.origin(h), b = sphere.target(h), c = sphere.opposite(h);
    const Index d = sphere.opposite(sphere.twin(h));
    if (!is_inside_flat(a) || !is_inside_flat(b) || !is_inside_flat(c) || !is_inside_flat(d))
      continue;
    ++tried;
    SCOPED_TRACE("half-edge " + std::to_string(h));
    std::vector<Vec3> positions = sphere.position;
    const Index x = static_cast<Index>(positions.size());
    const Vec3 towards_d = positions[d] - positions[a], along = positions[b] - positions[a];
    positions.push_back(positions[a] + 1e-3 * towards_d + 5e-5 * along);
    std::vector<Triangle> triangles = sphere.triangles();
    triangles[SurfaceMesh::face(h)] = {a, b, x};
    triangles.push_back({b, c, x});
    triangles.push_back({c, a, x});
    SurfaceMesh mesh = SurfaceMesh::from_triangles(positions, triangles);
    const SurfaceMesh before = mesh;
    const RepairReport report = repair(mesh);
    EXPECT_GT(report.before, 0);
    EXPECT_EQ(report.after, 0);
    expect_honest(report, before, mesh, 1, 0);
  }
  EXPECT_EQ(tried, 5);
}

TEST(IntersectionRepair, CanBeCancelled) {
  Random random(1);
  SurfaceMesh mesh = icosphere(4);
  shake(mesh, 0.6, random);
  Progress progress([](double, const char*) { return false; }, {Stage::edge_optimisation});
  EXPECT_THROW(repair_self_intersections(mesh, {}, progress), Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
