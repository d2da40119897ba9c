#include "second_attempt.h"

#include <gtest/gtest.h>

#include <new>
#include <numeric>

#include "shapes.h"

namespace shrinkwrap {
namespace {

ResultMesh as_result(const SurfaceMesh& surface) {
  ResultMesh mesh;
  mesh.position = surface.position;
  mesh.triangles = surface.triangles();
  mesh.input_index.assign(mesh.position.size(), kNone);
  return mesh;
}

// A run that made a sphere with these faults.
Reconstruction with_faults(MatchingFaults faults) {
  Reconstruction run;
  run.mesh = as_result(testing::icosphere(3));
  run.intersection_repair.annealed = 1;
  run.intersection_repair.faces_before_annealing = faults.meeting;
  run.intersection_repair.faces_after = faults.still_meeting;
  run.complete_matching.extra_vertices = faults.extra_vertices;
  run.complete_matching.cut_out = faults.cut_out;
  return run;
}

const std::function<void()> kMake = [] {};

struct Outcome {
  SecondAttempt attempt;
  Reconstruction kept;
};

Outcome after(Reconstruction first, Reconstruction second, bool is_same_surface = false,
              const std::function<void()>& make = kMake, const PointCloud& cloud = {}) {
  Progress silent;
  try_again(first, second, &Reconstruction::backs, is_same_surface, cloud, silent, make);
  return {first.backs, std::move(first)};
}

TEST(SecondAttempt, IsNotMadeWithoutFaults) {
  EXPECT_FALSE(after(with_faults({}), with_faults({})).attempt.is_made);
}

TEST(SecondAttempt, IsNotMadeIfMostFacesAreFaulty) {
  EXPECT_TRUE(after(with_faults({639, 0, 0}), with_faults({})).attempt.is_made);
  EXPECT_FALSE(after(with_faults({640, 0, 0}), with_faults({})).attempt.is_made);
  EXPECT_FALSE(after(with_faults({0, 0, 107}), with_faults({})).attempt.is_made);
}

TEST(SecondAttempt, AFewAnnealedFacesOfManyTellOfNoWrongSurface) {
  RepairReport repair;
  EXPECT_FALSE(tells_of_wrong_surface(repair, 100));
  repair.annealed = 1;
  repair.faces_before_annealing = 3;
  EXPECT_TRUE(tells_of_wrong_surface(repair, 100));
  EXPECT_FALSE(tells_of_wrong_surface(repair, 30000));
  repair.faces_after = 2;
  EXPECT_TRUE(tells_of_wrong_surface(repair, 30000));
}

TEST(SecondAttempt, IsTakenIfItsFaultsWeighLess) {
  const Outcome outcome = after(with_faults({20, 20, 0}), with_faults({0, 0, 3}));
  EXPECT_TRUE(outcome.attempt.is_taken);
  EXPECT_EQ(outcome.attempt.first.still_meeting, 20);
  EXPECT_EQ(outcome.attempt.second.extra_vertices, 3);
  EXPECT_EQ(outcome.kept.complete_matching.extra_vertices, 3);
}

// What was mended weighs little against what breaks the promise.
TEST(SecondAttempt, IsNotTakenForFewerAnnealedFacesAtThePriceOfExtraVertices) {
  EXPECT_FALSE(after(with_faults({18, 0, 0}), with_faults({0, 0, 4})).attempt.is_taken);
  EXPECT_TRUE(after(with_faults({18, 0, 4}), with_faults({0, 0, 4})).attempt.is_taken);
}

// They were in the way of something.
TEST(SecondAttempt, VerticesCutOutAreFaultsToo) {
  EXPECT_TRUE(after(with_faults({0, 0, 0, 1}), with_faults({})).attempt.is_taken);
  EXPECT_FALSE(after(with_faults({3, 0, 0, 0}), with_faults({0, 0, 0, 1})).attempt.is_taken);
  EXPECT_TRUE(after(with_faults({0, 0, 1, 0}), with_faults({0, 0, 0, 1})).attempt.is_taken);
}

TEST(SecondAttempt, IsTakenIfItAloneKeepsThePromise) {
  EXPECT_TRUE(after(with_faults({6, 6, 0}), with_faults({50, 0, 0})).attempt.is_taken);
  EXPECT_TRUE(after(with_faults({0, 0, 1}), with_faults({50, 0, 0})).attempt.is_taken);
  EXPECT_FALSE(after(with_faults({50, 0, 0}), with_faults({1, 1, 0})).attempt.is_taken);
}

// Of two that keep the promise. Faces of a spike stand across the planes of the sphere.
TEST(SecondAttempt, IsTakenIfItIsNearerToThePlanesOfTheSamples) {
  Progress silent;
  PointCloud cloud = prepare_samples(testing::icosphere(3).position, {}, silent);
  cloud.normal.clear();
  for (const Vec3& p : cloud.position) cloud.normal.push_back(p.normalized().cast<float>());
  const auto with_spikes = [](Index spikes, double length, MatchingFaults faults) {
    Reconstruction run = with_faults(faults);
    std::iota(run.mesh.input_index.begin(), run.mesh.input_index.end(), 0);
    for (Index v = 0; v < spikes; ++v) run.mesh.position[v] *= length;
    return run;
  };
  const auto attempt = [&](Reconstruction first, Reconstruction second,
                           bool is_same_surface = false) {
    return after(std::move(first), std::move(second), is_same_surface, kMake, cloud).attempt;
  };
  const SecondAttempt nearer =
      attempt(with_spikes(2, 2.0, {5, 0, 0}), with_spikes(1, 2.0, {9, 0, 0}));
  EXPECT_TRUE(nearer.is_taken);
  EXPECT_LT(nearer.second.across, 0.6 * nearer.first.across);
  EXPECT_FALSE(attempt(with_spikes(1, 2.0, {9, 0, 0}), with_spikes(2, 2.0, {5, 0, 0})).is_taken);
  // Of the same surface one may span more openings, where there are no planes.
  EXPECT_FALSE(
      attempt(with_spikes(2, 2.0, {5, 0, 0}), with_spikes(1, 2.0, {9, 0, 0}), true).is_taken);
  // Where both break it, the faults tell.
  EXPECT_FALSE(attempt(with_spikes(2, 2.0, {5, 2, 0}), with_spikes(1, 2.0, {9, 2, 0})).is_taken);
  // Planes that fit as badly tell nothing: the faults do.
  EXPECT_FALSE(attempt(with_spikes(2, 5.0, {5, 0, 0}), with_spikes(1, 5.0, {9, 0, 0})).is_taken);
}

TEST(SecondAttempt, IsNotTakenIfMoreFacesMeet) {
  EXPECT_FALSE(after(with_faults({2, 2, 50}), with_faults({3, 3, 0})).attempt.is_taken);
}

TEST(SecondAttempt, IsNotTakenWithMoreHandlesOfAnotherSurface) {
  Reconstruction torus = with_faults({});
  torus.mesh = as_result(testing::torus_mesh(24, 12));
  EXPECT_FALSE(after(with_faults({5, 0, 0}), torus).attempt.is_taken);
  EXPECT_TRUE(after(with_faults({5, 0, 0}), torus, true).attempt.is_taken);
}

TEST(SecondAttempt, LeavesTheFirstIfItCannotBeFinished) {
  const std::vector<std::function<void()>> failures = {[] { throw ReconstructionFailed("none"); },
                                                       [] { throw InvalidInput("none"); },
                                                       [] { throw std::bad_alloc(); }};
  for (const std::function<void()>& fails : failures) {
    const Outcome outcome = after(with_faults({5, 5, 0}), with_faults({}), false, fails);
    EXPECT_TRUE(outcome.attempt.is_made);
    EXPECT_FALSE(outcome.attempt.is_finished);
    EXPECT_FALSE(outcome.attempt.is_taken);
    EXPECT_EQ(outcome.kept.intersection_repair.faces_after, 5);
  }
}

TEST(SecondAttempt, LeavesTheFirstIfItBreaksThePromise) {
  Reconstruction second = with_faults({});
  second.mesh.triangles.push_back(second.mesh.triangles.front());
  const Outcome outcome = after(with_faults({5, 5, 0}), second);
  EXPECT_FALSE(outcome.attempt.is_finished);
  EXPECT_FALSE(outcome.attempt.is_taken);
  EXPECT_EQ(outcome.kept.mesh.triangles.size() + 1, second.mesh.triangles.size());
}

TEST(SecondAttempt, TimesAreThoseOfBoth) {
  Reconstruction first = with_faults({5, 5, 0}), second = with_faults({});
  const auto row = [](const char* name, double seconds) {
    StageRecord record;
    record.name = name;
    record.seconds = seconds;
    return record;
  };
  first.stages = {row("samples", 1.0), row("matching", 2.0)};
  second.stages = {row("matching", 4.0)};
  const Outcome outcome = after(std::move(first), std::move(second));
  ASSERT_EQ(outcome.kept.stages.size(), 2u);
  EXPECT_EQ(outcome.kept.stages[0].seconds, 1.0);
  EXPECT_EQ(outcome.kept.stages[1].seconds, 6.0);
}

}  // namespace
}  // namespace shrinkwrap
