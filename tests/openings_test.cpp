// Openings of the scan by their width: what spans them stays, or becomes a border.
#include "complete_matching/openings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "expect_mesh.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

constexpr Index kSamples = 4000;

Reconstruction hemisphere(double widest_opening, unsigned seed) {
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::automatic;
  options.complete_matching.widest_opening = widest_opening;
  Progress silent;
  return reconstruct(sample_shape(ShapeKind::hemisphere, kSamples, seed), options, silent);
}

double longest_edge(const ResultMesh& mesh, const Triangle& t) {
  const auto length = [&](int i, int j) {
    return (mesh.position[t[i]] - mesh.position[t[j]]).norm();
  };
  return std::max({length(0, 1), length(1, 2), length(2, 0)});
}

TEST(Openings, AWideOneStaysOpen) {
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Reconstruction result = hemisphere(10.0, seed);
    EXPECT_EQ(result.openings.left_open, 1);
    EXPECT_EQ(result.openings.spanned, 0);
    EXPECT_TRUE(result.report.manifold());
    EXPECT_EQ(result.report.border_loops, 1);
    EXPECT_EQ(result.report.samples_matched, kSamples);
    for (const Triangle& t : result.mesh.triangles)
      EXPECT_LE(longest_edge(result.mesh, t), 10.0 * result.spacing);
  }
}

TEST(Openings, ANarrowOneIsSpannedByFacesThatTellTheirWidth) {
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Reconstruction result = hemisphere(1000.0, seed);
    EXPECT_EQ(result.openings.left_open, 0);
    EXPECT_EQ(result.openings.spanned, 1);
    EXPECT_TRUE(result.report.closed() && result.report.manifold());
    EXPECT_EQ(result.report.samples_matched, kSamples);

    const ResultMesh& mesh = result.mesh;
    ASSERT_EQ(mesh.face_quality.size(), mesh.triangles.size());
    double widest = 0.0, area_below = 0.0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const Triangle& t = mesh.triangles[f];
      const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
      if (mesh.face_quality[f] > 0.0) {
        EXPECT_LT(std::max({a.z(), b.z(), c.z()}), 0.15) << "not a face between samples of the rim";
        EXPECT_NEAR(mesh.face_quality[f], longest_edge(mesh, t) / result.spacing, 1e-4);
        widest = std::max<double>(widest, mesh.face_quality[f]);
        area_below -= 0.5 * (b - a).cross(c - a).z();
      } else {
        EXPECT_GT((a + b + c).norm() / 3.0, 0.98) << "not a face of the sphere";
      }
    }
    EXPECT_NEAR(area_below, 3.14159, 0.05) << "the disc under the hemisphere";
    EXPECT_NEAR(widest, result.openings.longest_edge, 1e-4);
  }
}

// A sphere without the samples so near its north pole (x spacing, along the chord).
Reconstruction left_open(double radius, unsigned seed) {
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, kSamples, seed);
  const double spacing = std::sqrt(4.0 * kPi / kSamples);
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&](const Vec3& p) { return (p - Vec3::UnitZ()).norm() < radius * spacing; }),
      points.end());
  ReconstructionOptions options;
  options.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  Progress silent;
  return reconstruct(points, options, silent);
}

// Around an opening samples seem farther apart than they are, as half of their neighbours are
// missing: those nine spacings wide were closed.
TEST(Openings, OfNineSpacingsAreLeftOpen) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const Reconstruction open = left_open(4.5, seed), narrow = left_open(2.5, seed);
    EXPECT_EQ(open.report.border_loops, 1);
    EXPECT_TRUE(open.report.manifold());
    EXPECT_EQ(open.complete_matching.extra_vertices, 0);
    EXPECT_EQ(narrow.report.border_loops, 0);
  }
}

// --- what is decided about faces that a test chose ---

struct Decision {
  CompleteMatching matching;
  OpeningsReport report;
};

// Of no local spacing: no notch is narrow enough to be filled.
Decision decide(SurfaceMesh mesh, std::vector<Index> spanning, double widest_opening,
                double local_spacing = 0.0) {
  Decision decision;
  std::sort(spanning.begin(), spanning.end());
  const Index samples = mesh.vertex_count();
  decision.matching.mesh = std::move(mesh);
  decision.matching.spanning_faces = std::move(spanning);
  CompleteMatchingOptions options;
  options.openings = CompleteMatchingOptions::Openings::automatic;
  options.widest_opening = widest_opening;
  Progress silent;
  PointCloud cloud;
  cloud.position.assign(decision.matching.mesh.position.begin(),
                        decision.matching.mesh.position.begin() + samples);
  cloud.local_spacing.assign(static_cast<std::size_t>(samples), static_cast<float>(local_spacing));
  cloud.spacing = 1.0;
  decision.report = decide_openings(decision.matching, cloud, options, silent);
  return decision;
}

std::vector<Index> hinge(const SurfaceMesh& mesh, Index h) {
  return {SurfaceMesh::face(h), SurfaceMesh::face(mesh.twin(h))};
}

TEST(Openings, EachPatchByItsOwnWidth) {
  SurfaceMesh mesh = icosphere(3);
  const std::vector<Index> narrow = hinge(mesh, 0);
  // A hinge on the other side, with edges longer than any other.
  Index far = 0;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    if (mesh.position[mesh.origin(h)].dot(mesh.position[mesh.origin(0)]) < -0.9) far = h;
  ASSERT_NE(far, 0);
  mesh.position[mesh.origin(far)] *= 2.0;
  std::vector<Index> wide = hinge(mesh, far), both = wide;
  both.insert(both.end(), narrow.begin(), narrow.end());
  std::sort(wide.begin(), wide.end());

  const Decision one = decide(mesh, both, 0.5);
  EXPECT_EQ(one.report.left_open, 1);
  EXPECT_EQ(one.report.spanned, 1);
  EXPECT_GT(one.report.longest_edge, 0.05);
  EXPECT_LT(one.report.longest_edge, 0.5) << "of those that are spanned";
  EXPECT_EQ(one.matching.opening_faces, wide);

  const Decision all = decide(mesh, both, 0.01);
  EXPECT_EQ(all.report.left_open, 2);
  EXPECT_EQ(all.matching.opening_faces.size(), 4u);

  const Decision none = decide(mesh, both, 5.0);
  EXPECT_EQ(none.report.spanned, 2);
  EXPECT_TRUE(none.matching.opening_faces.empty());
}

TEST(Openings, NoSampleLosesItsLastFace) {
  const SurfaceMesh mesh = icosphere(3);
  std::vector<Index> star;
  mesh.for_each_outgoing(100, [&](Index h) { star.push_back(SurfaceMesh::face(h)); });
  const Decision decision = decide(mesh, star, 0.01);
  Index kept = 0;
  for (const Index f : star)
    kept += !std::binary_search(decision.matching.opening_faces.begin(),
                                decision.matching.opening_faces.end(), f);
  EXPECT_GT(kept, 0);
}

// They are joined to its border: no vertex that is no sample stays for their sake, and no fan of
// wide faces.
TEST(Openings, WithSamplesInTheirMiddleHaveOneBorder) {
  const double spacing = std::sqrt(4.0 * kPi / kSamples);
  std::vector<Vec3> points = sample_shape_blue_noise(ShapeKind::sphere, kSamples, 3);
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&](const Vec3& p) { return p.z() > 1.0 - 0.5 * 400.0 * spacing * spacing; }),
      points.end());
  points.emplace_back(0.0, 0.0, 1.0);
  points.emplace_back(Vec3(8.0 * spacing, 3.0 * spacing, 0.9).normalized());
  ReconstructionOptions options;
  options.outliers.exclude = false;
  options.complete_matching.widest_opening = 12.0;
  for (const auto openings : {CompleteMatchingOptions::Openings::leave_open,
                              CompleteMatchingOptions::Openings::automatic}) {
    SCOPED_TRACE(static_cast<int>(openings));
    options.complete_matching.openings = openings;
    Progress silent;
    const Reconstruction result = reconstruct(points, options, silent);
    EXPECT_TRUE(result.report.complete_matching() && result.report.manifold());
    EXPECT_EQ(result.report.border_loops, 1);
    EXPECT_EQ(result.report.components, 1);
    EXPECT_GE(result.openings.spanned, 1);
    const auto wide = std::count_if(
        result.mesh.triangles.begin(), result.mesh.triangles.end(),
        [&](const Triangle& t) { return longest_edge(result.mesh, t) > 5.0 * result.spacing; });
    EXPECT_GE(wide, 1);
    EXPECT_LE(wide, 2);
  }
}

TEST(Openings, NotchesInTheirBordersAreFilledWhenTheyAreDecided) {
  // All faces around two neighbouring samples of a round border but one, which leaves a notch.
  SurfaceMesh mesh = icosphere(3);
  std::vector<Index> disc;
  mesh.for_each_outgoing(100, [&](Index h) {
    mesh.for_each_outgoing(mesh.target(h), [&](Index g) { disc.push_back(SurfaceMesh::face(g)); });
  });
  std::sort(disc.begin(), disc.end());
  disc.erase(std::unique(disc.begin(), disc.end()), disc.end());
  const Index rim_face = [&] {  // across the border, with one edge on it
    for (const Index f : disc)
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index other = SurfaceMesh::face(mesh.twin(h));
        if (!std::binary_search(disc.begin(), disc.end(), other)) return other;
      }
    return kNone;
  }();
  ASSERT_NE(rim_face, kNone);
  std::vector<Index> ragged = disc;
  ragged.push_back(rim_face);
  const Decision without = decide(mesh, ragged, 0.01, 0.0), with = decide(mesh, ragged, 0.01, 1.0);
  EXPECT_EQ(without.report.notches_filled, 0);
  EXPECT_EQ(with.report.left_open, 1);
  EXPECT_GT(with.report.notches_filled, 0);
  EXPECT_LT(with.matching.opening_faces.size(), without.matching.opening_faces.size());
  EXPECT_FALSE(std::binary_search(with.matching.opening_faces.begin(),
                                  with.matching.opening_faces.end(), rim_face));
  EXPECT_TRUE(with.matching.mesh.is_consistent());
}

TEST(Openings, LeftOpenTellTheNotchesFilled) {
  for (const auto kind : {CompleteMatchingOptions::Openings::leave_open,
                          CompleteMatchingOptions::Openings::automatic}) {
    ReconstructionOptions options;
    options.complete_matching.openings = kind;
    options.complete_matching.widest_opening = 10.0;
    Progress silent;
    const Reconstruction result =
        reconstruct(sample_shape(ShapeKind::hemisphere, kSamples, 1), options, silent);
    EXPECT_GT(result.openings.notches_filled, 0);
    EXPECT_EQ(result.report.border_loops, 1);
    EXPECT_EQ(result.report.samples_matched, kSamples);
  }
}

// Along its rim a rough sheet has a few, however often faces were parted there.
TEST(Openings, ASheetThatIsRepairedHasTheOpeningsThatItHad) {
  constexpr unsigned kSeeds = 3;
  Index spanned = 0;
  for (unsigned seed = 2; seed < 2 + kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    std::vector<Vec3> points;
    for (int i = 0; i < 30; ++i)
      for (int j = 0; j < 30; ++j) {
        const double x = i + random.uniform(-0.3, 0.3), y = j + random.uniform(-0.3, 0.3);
        const double z = 10.0 * std::sin(0.3 * x) * std::cos(0.2 * y);
        points.push_back({x, y, z + random.uniform(-0.2, 0.2)});
      }
    Progress silent;
    const Reconstruction result = reconstruct(points, {}, silent);
    EXPECT_GE(result.openings.spanned, 1);
    spanned += result.openings.spanned;
  }
  EXPECT_LE(spanned, 5 * kSeeds);
}

// Faces that meet around an opening keep vertices from being removed until they are parted, and
// faces that do not meet yet, until they are cut and parted again.
TEST(Openings, OfScanLinesAreSpannedBetweenSamplesOnly) {
  constexpr unsigned kSeeds = 12;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Progress silent;
    const Reconstruction result = reconstruct(sample_sphere_on_scan_lines(2000, seed), {}, silent);
    EXPECT_GE(result.openings.spanned, 1);
    EXPECT_EQ(result.complete_matching.extra_vertices, result.report.vertices_extra);
    EXPECT_EQ(result.report.vertices_extra, 0);
    EXPECT_EQ(result.report.self_intersecting_faces, 0);
    EXPECT_TRUE(result.report.closed() && result.report.manifold());
    EXPECT_EQ(result.report.genus, 0);
    double longest = 0.0;
    for (const float quality : result.mesh.face_quality)
      longest = std::max<double>(longest, quality);
    EXPECT_NEAR(longest, result.openings.longest_edge, 1e-4);
  }
}

}  // namespace
}  // namespace shrinkwrap::testing
