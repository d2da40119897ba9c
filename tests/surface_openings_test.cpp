// Openings where a run ends at the parametric surface.
#include "surface_openings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "expect_mesh.h"
#include "face_patches.h"
#include "meeting_pairs.h"
#include "oriented_cloud.h"
#include "parametric_surface.h"
#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

using Openings = CompleteMatchingOptions::Openings;

// A surface, and samples at those of its vertices where the scan is not open.
struct OpenScan {
  template <class IsOpen>
  OpenScan(const SurfaceMesh& mesh, const IsOpen& is_open) : surface(mesh) {
    std::vector<Vec3> samples;
    for (const Vec3& p : mesh.position)
      if (!is_open(p)) samples.push_back(p);
    cloud = oriented_cloud(samples);
    for (Vec3& p : surface.position) p = cloud.frame.to_unit(p);
    find();
  }
  // As the options say.
  SurfaceOpenings cut(Openings openings, double widest = 30.0) {
    find(openings, widest);
    return cut_surface_openings(surface, membranes, silent);
  }
  void find(Openings openings = Openings::close, double widest = 30.0) {
    CompleteMatchingOptions options;
    options.openings = openings;
    options.widest_opening = widest;
    membranes = find_surface_membranes(surface, mark_membranes(surface, cloud, {}, silent), cloud,
                                       options, silent);
  }
  void stretch() { stretch_membranes(surface, membranes, silent); }
  Index openings() const { return static_cast<Index>(membranes.size()); }
  Vec3 at(Index v) const { return cloud.frame.to_input(surface.position[v]); }

  Progress silent;
  SurfaceMesh surface;
  PointCloud cloud;
  std::vector<SurfaceMembrane> membranes;
};

// The unit sphere without samples above a height.
OpenScan open_sphere(double z = 0.5) {
  return OpenScan(icosphere(4), [z](const Vec3& p) { return p.z() > z; });
}

SurfaceMesh ball(const Vec3& centre, double radius, int subdivisions) {
  return placed(icosphere(subdivisions), radius, centre);
}

// The torus without samples over an angle around its axis.
OpenScan open_torus(double angle) {
  return OpenScan(torus_mesh(150, 50), [angle](const Vec3& p) {
    return std::abs(std::atan2(p.y(), p.x())) < 0.5 * angle;
  });
}

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

TEST(SurfaceOpenings, AMembraneIsStretchedFlat) {
  OpenScan scan = open_sphere();
  const OpenScan before = open_sphere();
  scan.stretch();
  ASSERT_TRUE(scan.membranes[0].is_stretched);
  const double spacing = scan.cloud.frame.to_input_length(scan.cloud.spacing);
  for (const Index v : scan.membranes[0].vertices) {
    EXPECT_NEAR(scan.at(v).z(), 0.5, spacing);
    EXPECT_LT(std::hypot(scan.at(v).x(), scan.at(v).y()), 0.9);
  }
  Index moved = 0;
  for (Index v = 0; v < scan.surface.vertex_slots(); ++v) {
    const double way = (scan.at(v) - before.at(v)).norm();
    EXPECT_TRUE(way == 0.0 || before.at(v).z() > 0.5 - spacing);
    moved += way > 0.0;
  }
  EXPECT_GT(moved, static_cast<Index>(scan.membranes[0].vertices.size()))
      << "the rim is smoothed too";
  EXPECT_EQ(count_pairs(scan.surface), 0);
}

TEST(SurfaceOpenings, AMembraneGoesBackFromWhatItWouldMeet) {
  const auto beside = [](const std::vector<double>& heights) {
    std::vector<SurfaceMesh> bodies = {icosphere(5)};
    for (const double z : heights) bodies.push_back(ball({0.0, 0.0, z}, 0.05, 2));
    return OpenScan(joined(bodies), [](const Vec3& p) { return p.z() > 0.5 && p.norm() > 0.99; });
  };
  const auto top_of = [](const OpenScan& scan) {
    double top = 0.0;
    for (const Index v : scan.membranes[0].vertices) top = std::max(top, scan.at(v).z());
    return top;
  };
  // Where the membrane would pass all of the way, half of it and a quarter.
  OpenScan once = beside({0.5}), never = beside({0.5, 0.74, 0.85});
  ASSERT_EQ(once.openings(), 1);
  once.stretch();
  EXPECT_TRUE(once.membranes[0].is_stretched);
  EXPECT_NEAR(top_of(once), 0.75, 0.03);
  EXPECT_EQ(count_pairs(once.surface), 0);

  ASSERT_EQ(never.openings(), 1);
  const std::vector<Vec3> before = never.surface.position;
  never.stretch();
  EXPECT_FALSE(never.membranes[0].is_stretched);
  EXPECT_EQ(never.surface.position, before);
}

TEST(SurfaceOpenings, ATubeDoesNotBecomeAThread) {
  OpenScan narrow = open_torus(0.5), wide = open_torus(1.8);
  ASSERT_EQ(narrow.openings(), 1);
  ASSERT_EQ(wide.openings(), 1);
  narrow.stretch();
  EXPECT_TRUE(narrow.membranes[0].is_stretched);
  const std::vector<Vec3> before = wide.surface.position;
  wide.stretch();
  EXPECT_FALSE(wide.membranes[0].is_stretched);
  EXPECT_EQ(wide.surface.position, before);
}

TEST(SurfaceOpenings, WithoutARimNothingIsStretched) {
  // A body that no sample is on, beside one with an opening.
  OpenScan scan(joined({icosphere(4), ball({4.0, 0.0, 0.0}, 0.5, 2)}),
                [](const Vec3& p) { return p.x() > 2.0 || p.z() > 0.5; });
  ASSERT_EQ(scan.openings(), 2);
  const std::vector<Vec3> before = scan.surface.position;
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  EXPECT_FALSE(scan.membranes[1].is_stretched);
  for (const Index v : scan.membranes[1].vertices) EXPECT_EQ(scan.surface.position[v], before[v]);
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

TEST(SurfaceOpenings, FacesThatMeetAnywayAreNoReasonToGoBack) {
  // A fold of the fit, beside the rim.
  OpenScan scan = open_sphere();
  const std::vector<Index>& vertices = scan.membranes[0].vertices;
  Index v = vertices[0];
  scan.surface.for_each_outgoing(v, [&](Index h) {
    const Index u = scan.surface.target(h);
    if (!std::binary_search(vertices.begin(), vertices.end(), u)) v = u;
  });
  Index beyond = v;
  scan.surface.for_each_outgoing(v, [&](Index h) {
    const Index u = scan.surface.target(h);
    if (scan.at(u).z() < scan.at(beyond).z()) beyond = u;
  });
  Vec3& p = scan.surface.position[beyond];
  p += 3.0 * (scan.surface.position[v] - p);  // over its neighbour
  ASSERT_GT(count_pairs(scan.surface), 0);
  SurfaceMesh flat = scan.surface;
  scan.stretch();
  EXPECT_TRUE(scan.membranes[0].is_stretched);
  for (const Index u : vertices) EXPECT_LT(scan.at(u).z(), 0.65);
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
