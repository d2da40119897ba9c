// Openings where a run ends at the parametric surface.
#include "complete_matching/surface_openings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "expect_mesh.h"
#include "mesh/face_patches.h"
#include "mesh/self_intersection.h"
#include "open_scan.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

using Openings = CompleteMatchingOptions::Openings;

TEST(SurfaceOpenings, NoneInAWholeScan) {
  const OpenScan scan(icosphere(4), [](const Vec3&) { return false; });
  EXPECT_TRUE(scan.membranes.empty());
}

TEST(SurfaceOpenings, FoundWhereNoSampleIs) {
  const OpenScan scan = open_sphere();
  ASSERT_EQ(scan.membranes.size(), 1u);
  EXPECT_TRUE(scan.membranes[0].is_far);
  const std::vector<Index>& vertices = scan.membranes[0].vertices;
  EXPECT_TRUE(std::is_sorted(vertices.begin(), vertices.end()));
  const double spacing = scan.cloud.frame.to_input_length(scan.cloud.spacing);
  for (Index v = 0; v < scan.surface.vertex_slots(); ++v) {
    const bool is_in = std::binary_search(vertices.begin(), vertices.end(), v);
    const double z = scan.at(v).z();
    EXPECT_TRUE(is_in || z < 0.5 + 2.0 * spacing);
    EXPECT_FALSE(is_in && z < 0.5 - spacing);
  }
  EXPECT_EQ(open_sphere(0.98).openings(), 0) << "a hole a few spacings across";
}

TEST(SurfaceOpenings, AVoteStraightensTheOutline) {
  // A vertex alone among others takes their side.
  OpenScan scan = open_sphere();
  const std::vector<Index> vertices = scan.membranes[0].vertices;
  std::vector<char> marks(scan.surface.position.size(), 0);
  for (const Index v : vertices) marks[v] = 1;
  Index top = 0, bottom = 0;
  for (Index v = 0; v < scan.surface.vertex_slots(); ++v) {
    if (scan.at(v).z() > scan.at(top).z()) top = v;
    if (scan.at(v).z() < scan.at(bottom).z()) bottom = v;
  }
  marks[top] = 0;
  marks[bottom] = 1;
  const auto again = find_surface_membranes(scan.surface, marks, scan.cloud, {}, scan.silent);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].vertices, vertices);
}

TEST(SurfaceOpenings, CloseSpansThem) {
  OpenScan scan = open_sphere();
  scan.stretch();
  const SurfaceOpenings closed = cut_surface_openings(scan.surface, scan.membranes, scan.silent);
  EXPECT_TRUE(closed.opening_faces.empty());
  EXPECT_EQ(closed.report.spanned, 1);
  EXPECT_EQ(closed.report.stretched, 1);
  EXPECT_EQ(closed.report.left_open, 0);
  EXPECT_EQ(closed.spanning_faces, faces_around(scan.surface, scan.membranes[0].vertices));
}

TEST(SurfaceOpenings, LeaveOpenDropsThem) {
  OpenScan scan = open_sphere();
  const SurfaceOpenings open = scan.cut(Openings::leave_open);
  EXPECT_EQ(open.report.left_open, 1);
  EXPECT_EQ(open.report.spanned, 0);
  EXPECT_GE(open.opening_faces.size(), scan.membranes[0].vertices.size());
  EXPECT_EQ(open.spanning_faces, open.opening_faces);
  const std::vector<Vec3> before = scan.surface.position;
  scan.stretch();
  EXPECT_EQ(scan.surface.position, before) << "what is dropped need not be flat";
}

TEST(SurfaceOpenings, NarrowOnesAreNone) {
  for (const Openings openings : {Openings::close, Openings::leave_open, Openings::automatic}) {
    OpenScan scan = open_sphere(0.98);
    const SurfaceOpenings decided = scan.cut(openings, 1.0);
    EXPECT_TRUE(decided.spanning_faces.empty());
    EXPECT_EQ(decided.report.spanned + decided.report.left_open, 0);
  }
}

TEST(SurfaceOpenings, TheirBordersAreSmoothed) {
  OpenScan scan = open_sphere();
  const std::vector<Vec3> before = scan.surface.position;
  const std::vector<Index> dropped = scan.cut(Openings::leave_open).opening_faces;
  const auto is_dropped = [&](Index h) {
    return std::binary_search(dropped.begin(), dropped.end(), SurfaceMesh::face(h));
  };
  const SurfaceMesh& surface = scan.surface;
  double length = 0.0, length_before = 0.0;
  std::vector<char> is_on_border(before.size(), 0);
  for (Index h = 0; h < surface.halfedge_slots(); ++h) {
    if (!is_dropped(h) || is_dropped(surface.twin(h))) continue;
    const Index a = surface.origin(h), b = surface.target(h);
    length += (surface.position[b] - surface.position[a]).norm();
    length_before += (before[b] - before[a]).norm();
    is_on_border[a] = 1;
  }
  EXPECT_LT(length, 0.95 * length_before);
  EXPECT_GT(length, 0.8 * length_before);
  for (Index v = 0; v < surface.vertex_slots(); ++v)
    EXPECT_EQ(surface.position[v] != before[v], is_on_border[v] != 0);
}

TEST(SurfaceOpenings, ABorderThatWouldMeetSomethingIsNotSmoothed) {
  // Two openings in a sphere, and a ball beside it that is put where the upper border would go.
  const SurfaceMesh sphere = icosphere(4);
  const auto make_scan = [&] {
    return OpenScan(joined({sphere, placed(icosphere(1), 0.05, {3.0, 0.0, 0.0})}),
                    [](const Vec3& p) { return p.x() < 2.0 && (p.z() > 0.5 || p.z() < -0.7); });
  };
  OpenScan smoothed = make_scan(), scan = make_scan();
  const std::vector<Vec3> before = scan.surface.position;
  const SurfaceOpenings openings = smoothed.cut(Openings::leave_open);
  ASSERT_EQ(openings.report.left_open, 2);
  Index farthest = 0;  // of those that move up, away from what is left
  const auto climb = [&](Index v) { return smoothed.surface.position[v].z() - before[v].z(); };
  for (Index v = 0; v < sphere.vertex_slots(); ++v)
    if (scan.at(v).z() > 0.0 && climb(v) > climb(farthest)) farthest = v;
  for (Index v = sphere.vertex_slots(); v < scan.surface.vertex_slots(); ++v)
    scan.surface.position[v] =
        smoothed.surface.position[farthest] +
        0.05 * climb(farthest) * icosphere(1).position[v - sphere.vertex_slots()];
  const std::vector<Vec3> with_ball = scan.surface.position;

  EXPECT_EQ(cut_surface_openings(scan.surface, smoothed.membranes, scan.silent).opening_faces,
            openings.opening_faces);
  std::vector<Triangle> left;
  for (Index f = 0; f < scan.surface.face_slots(); ++f)
    if (!std::binary_search(openings.opening_faces.begin(), openings.opening_faces.end(), f))
      left.push_back(scan.surface.triangle(f));
  EXPECT_TRUE(self_intersections(scan.surface.position, left, scan.silent).empty());
  std::vector<Vec3> met = with_ball;  // had it been smoothed all the same
  for (Index v = 0; v < sphere.vertex_slots(); ++v) met[v] = smoothed.surface.position[v];
  EXPECT_FALSE(self_intersections(met, left, scan.silent).empty());
  for (Index v = 0; v < sphere.vertex_slots(); ++v) {
    const Vec3& expected = scan.at(v).z() > 0.0 ? before[v] : smoothed.surface.position[v];
    EXPECT_EQ(scan.surface.position[v], expected);
  }
}

TEST(SurfaceOpenings, AutomaticDecidesByTheirWidth) {
  // One of radius 0.87, one of 0.44: some 30 and 13 spacings across, bulging.
  const auto scan = [] {
    return OpenScan(icosphere(4), [](const Vec3& p) { return p.z() > 0.5 || p.z() < -0.9; });
  };
  OpenScan close_both = scan(), close_one = scan(), close_none = scan();
  EXPECT_EQ(close_both.cut(Openings::automatic, 100.0).report.spanned, 2);
  ASSERT_EQ(close_both.openings(), 2);
  for (const SurfaceMembrane& membrane : close_both.membranes) {
    const bool is_top = close_both.at(membrane.vertices[0]).z() > 0.0;
    EXPECT_NEAR(membrane.width, is_top ? 31.0 : 13.0, 3.0);
  }
  const SurfaceOpenings one = close_one.cut(Openings::automatic, 20.0);
  EXPECT_EQ(one.report.spanned, 1);
  EXPECT_EQ(one.report.left_open, 1);
  for (const Index f : one.opening_faces)
    EXPECT_GT(close_one.at(close_one.surface.triangle(f)[0]).z(), 0.0) << "the wide one";
  EXPECT_GT(one.spanning_faces.size(), one.opening_faces.size());
  EXPECT_EQ(close_none.cut(Openings::automatic, 9.0).report.left_open, 2);
}

TEST(SurfaceOpenings, WidthIsAlongTheSurface) {
  // No sample near a base is on its side: a cup without one is no wider for that.
  const OpenScan cup(icosphere(4), [](const Vec3& p) { return p.z() > 0.0; });
  ASSERT_EQ(cup.openings(), 1);
  const double spacing = cup.cloud.frame.to_input_length(cup.cloud.spacing);
  EXPECT_NEAR(cup.membranes[0].width, kPi / spacing, 0.1 * kPi / spacing);
}

TEST(SurfaceOpenings, NoneOfSoFewSamplesThatTheyTellNoSide) {
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  options.complete_matching.openings = Openings::leave_open;
  Progress silent;
  for (const Index count : {4, 6, 12}) {
    SCOPED_TRACE(count);
    const Reconstruction result =
        reconstruct(sample_shape(ShapeKind::sphere, count, 1), options, silent);
    EXPECT_TRUE(result.report.closed() && result.report.manifold());
  }
}

TEST(SurfaceOpenings, ARunThatStopsClosesOrLeavesThem) {
  SampleDefects defects;
  defects.noise = 0.3;
  std::vector<Vec3> points = sample_shape(ShapeKind::hemisphere, 4000, 1, defects);
  for (Vec3& p : points) p = rounded_to_single(p);
  const auto run = [&](Openings openings, double widest = 30.0) {
    ReconstructionOptions options;
    options.stop_at_parametric_surface = true;
    options.complete_matching.openings = openings;
    options.complete_matching.widest_opening = widest;
    Progress silent;
    return reconstruct(points, options, silent);
  };
  const Reconstruction closed = run(Openings::close);
  EXPECT_TRUE(closed.report.closed() && closed.report.manifold());
  EXPECT_EQ(closed.openings.spanned, 1);
  EXPECT_EQ(closed.openings.stretched, 1);
  EXPECT_GT(closed.openings.longest_edge, 0.0);
  ASSERT_EQ(closed.mesh.face_quality.size(), closed.mesh.triangles.size());
  double lowest = 1.0, highest = -1.0, area = 0.0;
  for (std::size_t f = 0; f < closed.mesh.triangles.size(); ++f) {
    if (closed.mesh.face_quality[f] == 0.0f) continue;
    const Triangle& t = closed.mesh.triangles[f];
    const auto& p = closed.mesh.position;
    area += 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm();
    for (const Index v : t) {
      lowest = std::min(lowest, p[v].z());
      highest = std::max(highest, p[v].z());
    }
  }
  EXPECT_LT(highest - lowest, 4.0 * closed.spacing) << "flat";
  EXPECT_GT(area, 2.0);

  const Reconstruction open = run(Openings::leave_open);
  EXPECT_TRUE(open.report.manifold());
  EXPECT_EQ(open.report.border_loops, 1);
  EXPECT_EQ(open.report.components, 1);
  EXPECT_EQ(open.openings.left_open, 1);
  EXPECT_EQ(open.report.self_intersecting_faces, 0);
  EXPECT_TRUE(open.mesh.face_quality.empty());
  for (const Vec3& p : open.mesh.position) EXPECT_EQ(p, rounded_to_single(p));
  EXPECT_LT(open.mesh.triangles.size(), closed.mesh.triangles.size());

  EXPECT_EQ(static_cast<std::size_t>(open.stages[open.stages.size() - 2].vertices),
            open.mesh.position.size());

  EXPECT_EQ(run(Openings::automatic, 10.0).mesh.triangles, open.mesh.triangles);
  EXPECT_EQ(run(Openings::automatic, 1000.0).mesh.triangles, closed.mesh.triangles);
}

TEST(SurfaceOpenings, ASheetHasOneSide) {
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  options.complete_matching.openings = Openings::leave_open;
  Progress silent;
  const Reconstruction sheet = reconstruct(sample_strip(600, 10, 1), options, silent);
  EXPECT_TRUE(sheet.report.manifold());
  EXPECT_EQ(sheet.report.components, 1);
  EXPECT_EQ(sheet.report.border_loops, 1);
  double front = 0.0, back = 0.0;  // areas
  for (const Triangle& t : sheet.mesh.triangles) {
    const auto& p = sheet.mesh.position;
    const Vec3 area = 0.5 * (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
    (area.z() > 0.0 ? front : back) += area.norm();
  }
  EXPECT_GT(front, 540.0);
  EXPECT_LT(back, 0.03 * front) << "at the border";
}

}  // namespace
}  // namespace shrinkwrap::testing
