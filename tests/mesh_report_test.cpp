// The report against meshes whose faults are known, and against a count of its own.
#include "report/mesh_report.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::flattened;
using testing::icosphere;
using testing::Random;
using testing::torus_mesh;

struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;

  Mesh() = default;
  explicit Mesh(const SurfaceMesh& mesh) : positions(mesh.position), triangles(mesh.triangles()) {}
  void add(const Mesh& other, const Vec3& shift, bool turned = false) {
    const Index first = static_cast<Index>(positions.size());
    for (const Vec3& p : other.positions) positions.push_back(p + shift);
    for (Triangle t : other.triangles) {
      for (Index& v : t) v += first;
      if (turned) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
  }
};

MeshReport report_of(const Mesh& mesh, const std::vector<Vec3>& samples) {
  Progress progress;
  return measure_mesh(mesh.positions, mesh.triangles, samples, {}, progress);
}
MeshReport report_of(const Mesh& mesh) {
  return report_of(mesh, mesh.positions);
}

TEST(MeshReport, ClosedMeshes) {
  for (const auto& [mesh, genus] :
       {std::make_pair(Mesh(icosphere(2)), 0), std::make_pair(Mesh(torus_mesh(24, 12)), 1)}) {
    const MeshReport report = report_of(mesh);
    EXPECT_EQ(report.vertices, static_cast<Index>(mesh.positions.size()));
    EXPECT_EQ(report.faces, static_cast<Index>(mesh.triangles.size()));
    EXPECT_EQ(2 * report.edges, 3 * report.faces);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.genus, genus);
    EXPECT_EQ(report.border_loops, 0);
    EXPECT_EQ(report.components_inside_out, 0);
    EXPECT_EQ(report.self_intersecting_faces, 0);
    EXPECT_TRUE(report.closed());
    EXPECT_TRUE(report.manifold());
    EXPECT_TRUE(report.outward());
    EXPECT_TRUE(report.complete_matching());
    EXPECT_EQ(report.samples, report.vertices);
  }
}

TEST(MeshReport, Volume) {
  Mesh cube;
  for (int v = 0; v < 8; ++v)
    cube.positions.push_back(Vec3(v & 1, v >> 1 & 1, v >> 2 & 1) + Vec3(10, 20, 30));
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  EXPECT_NEAR(report_of(cube).volume, 1.0, 1e-12);
  for (Triangle& t : cube.triangles) std::swap(t[0], t[1]);
  const MeshReport turned = report_of(cube);
  EXPECT_NEAR(turned.volume, -1.0, 1e-12);
  EXPECT_FALSE(turned.outward());
  EXPECT_EQ(turned.components_inside_out, 1);
}

TEST(MeshReport, SideOfVeryLargeAndVerySmallMeshes) {
  for (const double scale : {1e-310, 1e-150, 1e-110, 1e110, 1e150, 1e307}) {
    SCOPED_TRACE(scale);
    Mesh mesh(icosphere(1));
    for (Vec3& p : mesh.positions) p *= scale;
    EXPECT_TRUE(report_of(mesh).outward());
    for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
    EXPECT_FALSE(report_of(mesh).outward());
    EXPECT_EQ(report_of(mesh).components_inside_out, 1);
  }
}

// Its volume has the sign of the rounding of its sum.
TEST(MeshReport, AFlatComponentHasNoInside) {
  Mesh flat(flattened(icosphere(3), Vec3(1, 2, 3))), turned;
  turned.add(flat, Vec3::Zero(), true);
  for (const Mesh& mesh : {flat, turned}) {
    const MeshReport report = report_of(mesh);
    EXPECT_TRUE(report.outward());
    EXPECT_EQ(report.components_flat, 1);
    EXPECT_EQ(report.components_inside_out, 0);
    EXPECT_EQ(describe(report)[2], "Closed: yes, volume 0, 1 component is flat, without an inside");
  }
  Mesh far;  // what its coordinates are rounded by counts as well
  far.add(flat, Vec3(1000, 2000, 3001));
  EXPECT_EQ(report_of(far).components_flat, 1);
  // Beside a body the side of the body counts, which is not far from flat, but surely none.
  Mesh body(icosphere(3));
  for (Vec3& p : body.positions) p.z() *= 1e-9;
  flat.add(body, Vec3(5, 0, 0));
  turned.add(body, Vec3(5, 0, 0), true);
  EXPECT_TRUE(report_of(flat).outward());
  EXPECT_FALSE(report_of(turned).outward());
  EXPECT_EQ(report_of(turned).components_flat, 1);
  EXPECT_EQ(report_of(turned).components_inside_out, 1);
}

// So thin for its length that the products of its distances are rounded by more than its volume.
TEST(MeshReport, AThinTubeOfManyFacesHasAnInside) {
  constexpr Index kRings = 5000, kSides = 6;
  constexpr double kRadius = 1e-6;
  Mesh tube;
  for (Index ring = 0; ring < kRings; ++ring)
    for (Index side = 0; side < kSides; ++side) {
      const double angle = 2.0 * kPi * side / kSides;
      tube.positions.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle),
                                  static_cast<double>(ring) / (kRings - 1));
    }
  const auto at = [](Index ring, Index side) { return ring * kSides + side % kSides; };
  for (Index side = 0; side < kSides; ++side) {
    for (Index ring = 0; ring + 1 < kRings; ++ring) {
      tube.triangles.push_back({at(ring, side), at(ring, side + 1), at(ring + 1, side)});
      tube.triangles.push_back({at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side)});
    }
    if (side < 2) continue;
    tube.triangles.push_back({at(0, 0), at(0, side), at(0, side - 1)});
    tube.triangles.push_back({at(kRings - 1, 0), at(kRings - 1, side - 1), at(kRings - 1, side)});
  }
  Mesh turned;
  turned.add(tube, Vec3::Zero(), true);
  EXPECT_TRUE(report_of(tube).outward());
  EXPECT_EQ(report_of(tube).components_flat, 0);
  EXPECT_FALSE(report_of(turned).outward());
  EXPECT_EQ(report_of(turned).components_inside_out, 1);
}

TEST(MeshReport, ComponentsAndCavities) {
  Mesh mesh(icosphere(3));
  Mesh core(icosphere(1));
  for (Vec3& p : core.positions) p *= 0.5;
  mesh.add(core, Vec3::Zero(), true);
  mesh.add(Mesh(torus_mesh(12, 8)), Vec3(5, 0, 0));
  const MeshReport report = report_of(mesh);
  EXPECT_EQ(report.components, 3);
  EXPECT_EQ(report.cavities, 1);
  EXPECT_EQ(report.genus, 1);
  EXPECT_TRUE(report.outward());
  EXPECT_EQ(report.self_intersecting_faces, 0);
}

TEST(MeshReport, OpeningsCountAsCapped) {
  Mesh mesh(torus_mesh(24, 12));
  const auto keep_out = [&](Index v) {
    mesh.triangles.erase(std::remove_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [&](const Triangle& t) {
                                          return std::find(t.begin(), t.end(), v) != t.end();
                                        }),
                         mesh.triangles.end());
  };
  const MeshReport whole = report_of(mesh);
  keep_out(0);
  keep_out(150);
  const MeshReport report = report_of(mesh);
  EXPECT_FALSE(report.closed());
  EXPECT_TRUE(report.manifold());
  EXPECT_EQ(report.border_loops, 2);
  EXPECT_EQ(report.border_edges, 12);
  EXPECT_EQ(report.vertices, whole.vertices - 2);
  EXPECT_EQ(report.genus, 1);
  EXPECT_EQ(report.volume, 0.0);
  EXPECT_EQ(report.samples_missing, 2) << "vertices without a face match nothing";
}

TEST(MeshReport, Faults) {
  const Mesh sphere(icosphere(1));
  const auto expect_no_genus = [](const MeshReport& report) {
    EXPECT_FALSE(report.manifold());
    EXPECT_EQ(report.genus, -1);
  };
  {
    SCOPED_TRACE("a fin: an edge of three faces");
    Mesh mesh = sphere;
    mesh.positions.push_back(Vec3(0, 0, 3));
    const Triangle t = mesh.triangles[0];
    mesh.triangles.push_back({t[0], t[1], static_cast<Index>(mesh.positions.size()) - 1});
    const MeshReport report = report_of(mesh);
    EXPECT_EQ(report.nonmanifold_edges, 1);
    EXPECT_EQ(report.nonmanifold_vertices, 2);
    EXPECT_EQ(report.border_edges, 2);
    EXPECT_EQ(report.components, 1);
    expect_no_genus(report);
  }
  {
    SCOPED_TRACE("two spheres that share a vertex");
    Mesh mesh = sphere;
    mesh.add(sphere, Vec3(9, 0, 0));
    const Index first = static_cast<Index>(sphere.positions.size());
    for (Triangle& t : mesh.triangles)
      for (Index& v : t)
        if (v == first) v = 0;
    const MeshReport report = report_of(mesh);
    EXPECT_EQ(report.nonmanifold_vertices, 1);
    EXPECT_EQ(report.nonmanifold_edges, 0);
    EXPECT_EQ(report.components, 2);
    EXPECT_EQ(report.vertices, 2 * first - 1);
    expect_no_genus(report);
  }
  {
    SCOPED_TRACE("a face turned over");
    Mesh mesh = sphere;
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    const MeshReport report = report_of(mesh);
    EXPECT_EQ(report.misoriented_edges, 3);
    EXPECT_TRUE(report.closed());
    expect_no_genus(report);
  }
  {
    SCOPED_TRACE("faces that are none");
    Mesh mesh = sphere;
    mesh.triangles.push_back({3, 3, 4});
    mesh.triangles.push_back({3, 4, -1});
    mesh.triangles.push_back({3, 4, 100000});
    const MeshReport report = report_of(mesh);
    EXPECT_EQ(report.degenerate_faces, 3);
    EXPECT_EQ(report.border_edges, 0);
    EXPECT_EQ(report.components, 1);
    expect_no_genus(report);
  }
  {
    SCOPED_TRACE("coordinates that are none");
    Mesh mesh = sphere;
    mesh.positions[mesh.triangles[0][0]].x() = std::numeric_limits<double>::quiet_NaN();
    const MeshReport report = report_of(mesh, sphere.positions);
    EXPECT_EQ(report.vertices_extra, 1);
    EXPECT_EQ(report.samples_missing, 1);
    EXPECT_TRUE(std::isfinite(report.volume));
    Mesh turned;
    turned.add(mesh, Vec3::Zero(), true);
    for (const Mesh& either : {mesh, turned}) EXPECT_EQ(report_of(either).components_flat, 0);
    EXPECT_TRUE(report_of(mesh).outward());
    EXPECT_FALSE(report_of(turned).outward());
    for (Vec3& p : mesh.positions) p.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(report_of(mesh).components_flat, 0);
    EXPECT_FALSE(report_of(mesh).outward());
  }
  {
    SCOPED_TRACE("spheres that cut");
    Mesh mesh = sphere;
    mesh.add(sphere, Vec3(0.9, 0.3, 0.1));
    EXPECT_GT(report_of(mesh).self_intersecting_faces, 10);
    MeshReportOptions quick;
    quick.count_self_intersections = false;
    Progress progress;
    EXPECT_EQ(
        measure_mesh(mesh.positions, mesh.triangles, {}, quick, progress).self_intersecting_faces,
        -1);
  }
  {
    SCOPED_TRACE("nothing");
    const MeshReport report = report_of(Mesh());
    EXPECT_FALSE(report.closed());
    EXPECT_FALSE(report.manifold());
    EXPECT_EQ(report.components, 0);
  }
}

TEST(MeshReport, Samples) {
  Mesh mesh(icosphere(2));
  mesh.positions[5] = Vec3(0.0, 2.0, 0.25);
  std::vector<Vec3> samples = mesh.positions;
  samples[5] = Vec3(-0.0, 2.0, 0.25);
  std::rotate(samples.begin(), samples.begin() + 40, samples.end());
  EXPECT_TRUE(report_of(mesh, samples).complete_matching()) << "-0 is 0";

  std::vector<Vec3> repeated = samples;
  repeated.push_back(samples[3]);
  repeated.push_back(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  const MeshReport with_repeated = report_of(mesh, repeated);
  EXPECT_TRUE(with_repeated.complete_matching());
  EXPECT_EQ(with_repeated.samples, static_cast<Index>(samples.size()));

  std::vector<Vec3> moved = samples;
  moved[7].x() = std::nextafter(moved[7].x(), 2.0);
  const MeshReport with_moved = report_of(mesh, moved);
  EXPECT_EQ(with_moved.samples_missing, 1);
  EXPECT_EQ(with_moved.vertices_extra, 1);
  EXPECT_EQ(with_moved.samples_matched, static_cast<Index>(samples.size()) - 1);
  EXPECT_FALSE(with_moved.complete_matching());

  mesh.positions[9] = mesh.positions[10];
  const MeshReport twice = report_of(mesh, samples);
  EXPECT_EQ(twice.samples_matched_twice, 1);
  EXPECT_EQ(twice.samples_missing, 1);
  EXPECT_FALSE(twice.complete_matching());
}

// What the definitions say, with maps.
void expect_counts_by_definition(const Mesh& mesh, const MeshReport& report) {
  std::map<std::pair<Index, Index>, std::vector<std::pair<Index, bool>>> faces_at;
  std::map<Index, std::vector<Index>> star;
  for (Index f = 0; f < static_cast<Index>(mesh.triangles.size()); ++f)
    for (int i = 0; i < 3; ++i) {
      const Index a = mesh.triangles[f][i], b = mesh.triangles[f][(i + 1) % 3];
      faces_at[std::minmax(a, b)].emplace_back(f, a < b);
      star[a].push_back(f);
    }
  Index border = 0, nonmanifold = 0, misoriented = 0;
  for (const auto& [edge, faces] : faces_at) {
    border += faces.size() == 1 ? 1 : 0;
    nonmanifold += faces.size() > 2 ? 1 : 0;
    misoriented += faces.size() == 2 && faces[0].second == faces[1].second ? 1 : 0;
  }
  // Spreads from one face over edges that `crosses` accepts; returns the faces reached.
  const auto reach = [&](Index from, const std::set<Index>& among, Index vertex) {
    std::set<Index> reached = {from};
    std::vector<Index> stack = {from};
    while (!stack.empty()) {
      const Triangle t = mesh.triangles[stack.back()];
      stack.pop_back();
      for (int i = 0; i < 3; ++i) {
        const Index a = t[i], b = t[(i + 1) % 3];
        if (vertex != kNone && a != vertex && b != vertex) continue;
        for (const auto& [g, up] : faces_at[std::minmax(a, b)])
          if (among.count(g) > 0 && reached.insert(g).second) stack.push_back(g);
      }
    }
    return reached;
  };
  Index bad_vertices = 0, components = 0;
  for (const auto& [v, faces] : star) {
    const std::set<Index> among(faces.begin(), faces.end());
    bool good = reach(faces[0], among, v).size() == among.size();
    for (Index f : faces)
      for (Index u : mesh.triangles[f]) good &= u == v || faces_at[std::minmax(u, v)].size() <= 2;
    bad_vertices += good ? 0 : 1;
  }
  std::set<Index> left;
  for (Index f = 0; f < static_cast<Index>(mesh.triangles.size()); ++f) left.insert(f);
  while (!left.empty()) {
    ++components;
    for (Index f : reach(*left.begin(), std::set<Index>(left), kNone)) left.erase(f);
  }
  EXPECT_EQ(report.vertices, static_cast<Index>(star.size()));
  EXPECT_EQ(report.edges, static_cast<Index>(faces_at.size()));
  EXPECT_EQ(report.border_edges, border);
  EXPECT_EQ(report.nonmanifold_edges, nonmanifold);
  EXPECT_EQ(report.misoriented_edges, misoriented);
  EXPECT_EQ(report.nonmanifold_vertices, bad_vertices);
  EXPECT_EQ(report.components, components);
}

TEST(MeshReport, DamagedMeshesAsTheDefinitionsSay) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Mesh mesh(seed % 2 == 0 ? icosphere(2) : torus_mesh(16, 9));
    const Index vertices = static_cast<Index>(mesh.positions.size());
    for (unsigned i = 0; i < 3 * seed; ++i) {
      Triangle& t = mesh.triangles[random.below(static_cast<Index>(mesh.triangles.size()))];
      const Triangle before = t;
      switch (random.below(4)) {
        case 0:
          t = mesh.triangles.back();
          mesh.triangles.pop_back();
          break;
        case 1:
          std::swap(t[0], t[1]);
          break;
        case 2:
          mesh.triangles.push_back(before);
          break;
        default:
          t[0] = random.below(vertices);
          if (t[0] == t[1] || t[0] == t[2]) t = before;
      }
    }
    MeshReportOptions quick;
    quick.count_self_intersections = false;
    Progress progress;
    expect_counts_by_definition(
        mesh, measure_mesh(mesh.positions, mesh.triangles, mesh.positions, quick, progress));
  }
}

TEST(MeshReport, SameForAnyNumberOfThreadsAndAnyOrderOfVertices) {
  const Mesh mesh(icosphere(5));
  const std::size_t count = mesh.positions.size();
  Mesh shuffled = mesh;
  const auto place = [&](std::size_t v) { return v * 7919 % count; };  // a prime, no divisor
  for (std::size_t v = 0; v < count; ++v) shuffled.positions[place(v)] = mesh.positions[v];
  for (Triangle& t : shuffled.triangles)
    for (Index& v : t) v = static_cast<Index>(place(v));
  const auto describe_with = [&](std::size_t threads, const Mesh& m) {
    tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return describe(report_of(m));
  };
  const std::vector<std::string> expected = describe_with(1, mesh);
  EXPECT_EQ(describe_with(4, mesh), expected);
  EXPECT_EQ(describe_with(4, shuffled), expected);
}

TEST(MeshReport, LinesForALog) {
  Mesh mesh(torus_mesh(24, 12));
  const std::vector<std::string> good = describe(report_of(mesh));
  ASSERT_EQ(good.size(), 5u);
  EXPECT_EQ(good[0], "Mesh: 288 vertices, 864 edges, 576 faces, 1 component");
  EXPECT_EQ(good[1], "2-manifold: yes, genus 1");
  EXPECT_EQ(good[2].rfind("Closed: yes, volume ", 0), 0u) << good[2];
  EXPECT_EQ(good[3], "Self-intersections: none");
  EXPECT_EQ(good[4], "Complete matching: 288 of 288 samples matched exactly; one to one");

  mesh.triangles.pop_back();
  std::vector<Vec3> samples = mesh.positions;
  samples.push_back(Vec3(7, 7, 7));
  const std::vector<std::string> bad = describe(report_of(mesh, samples));
  EXPECT_EQ(bad[2], "Closed: 3 border edges, 1 opening");
  EXPECT_EQ(bad[4], "Complete matching: 288 of 289 samples matched exactly; 1 sample is no vertex");
}

TEST(MeshReport, ProgressRisesAndCancels) {
  const Mesh mesh(icosphere(5));
  double last = 0.0;
  bool rises = true;
  Progress progress(
      [&](double fraction, const char*) {
        rises &= fraction >= last;
        last = fraction;
        return true;
      },
      {Stage::report});
  progress.begin(Stage::report);
  measure_mesh(mesh.positions, mesh.triangles, mesh.positions, {}, progress);
  EXPECT_TRUE(rises);
  EXPECT_LE(last, 1.0);
  Progress refuses([](double, const char*) { return false; }, {Stage::report});
  EXPECT_THROW(measure_mesh(mesh.positions, mesh.triangles, mesh.positions, {}, refuses),
               Cancelled);
}

}  // namespace
}  // namespace shrinkwrap
