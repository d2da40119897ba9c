// Edge optimisation: creases are followed, planes and well-shaped triangles are left alone, nothing
// else changes.
#include "edge_optimisation/edge_optimisation.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "expect_mesh.h"
#include "mesh/delaunay_flips.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

using testing::expect_closed_manifold;
using testing::expect_same_mesh;
using testing::Random;
using testing::signed_volume;
using Criterion = EdgeOptimisationOptions::Criterion;

// The surface of the cube [-1, 1]^3 as a grid of n x n squares a side, each cut along a diagonal
// chosen at random.
SurfaceMesh cube(int n, Random& random) {
  std::map<std::array<int, 3>, Index> index;
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  const auto vertex = [&](int axis, int side, int i, int j) {
    std::array<int, 3> key;
    key[axis] = side * n;
    key[(axis + 1) % 3] = i;
    key[(axis + 2) % 3] = j;
    const auto [found, is_new] = index.emplace(key, static_cast<Index>(positions.size()));
    if (is_new) positions.push_back(Vec3(key[0], key[1], key[2]) * (2.0 / n) - Vec3::Ones());
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          Index a = vertex(axis, side, i, j), b = vertex(axis, side, i + 1, j),
                c = vertex(axis, side, i + 1, j + 1), d = vertex(axis, side, i, j + 1);
          if (side == 0) std::swap(b, d);
          if (random.below(2) == 0) {
            triangles.push_back({a, b, c});
            triangles.push_back({a, c, d});
          } else {
            triangles.push_back({b, c, d});
            triangles.push_back({b, d, a});
          }
        }
  return SurfaceMesh::from_triangles(std::move(positions), triangles);
}

bool lies_in_one_side(const SurfaceMesh& mesh, Index f) {
  const Triangle t = mesh.triangle(f);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      if (std::all_of(t.begin(), t.end(), [&](Index v) { return mesh.position[v][axis] == side; }))
        return true;
  return false;
}

// Flips edges of the cube at random, no two of them close together: each cuts a corner off.
Index cut_corners(SurfaceMesh& mesh, Random& random) {
  Index flips = 0;
  std::vector<char> is_near(mesh.position.size(), 0);
  for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
    const Vec3 m = mesh.area_vector(SurfaceMesh::face(h)).normalized(),
               n = mesh.area_vector(SurfaceMesh::face(mesh.twin(h))).normalized();
    const std::array<Index, 4> corners = {mesh.origin(h), mesh.target(h), mesh.opposite(h),
                                          mesh.opposite(mesh.twin(h))};
    if (m.dot(n) > 0.1 || random.below(2) == 0 || !mesh.is_flip_legal(h) ||
        std::any_of(corners.begin(), corners.end(), [&](Index v) { return is_near[v] != 0; }))
      continue;
    mesh.flip(h);
    ++flips;
    for (const Index v : corners)
      mesh.for_each_outgoing(v, [&](Index g) { is_near[mesh.target(g)] = 1; });
  }
  return flips;
}

double median_smallest_angle(const SurfaceMesh& mesh) {
  std::vector<double> angles;
  for (const Triangle& t : mesh.triangles()) {
    double smallest = 4.0;
    for (int i = 0; i < 3; ++i) {
      const Vec3 u = mesh.position[t[(i + 1) % 3]] - mesh.position[t[i]],
                 v = mesh.position[t[(i + 2) % 3]] - mesh.position[t[i]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
    angles.push_back(smallest);
  }
  std::nth_element(angles.begin(), angles.begin() + angles.size() / 2, angles.end());
  return angles[angles.size() / 2];
}

class EdgeOptimisation : public ::testing::TestWithParam<Criterion> {
 protected:
  EdgeOptimisationOptions options_;
  Progress progress_;
  void SetUp() override {
    options_.criterion = GetParam();
    options_.crease_angle = 0.0;  // so that flips are those of the criterion
    options_.least_gap = 1.0;
  }
};

TEST_P(EdgeOptimisation, KeepsVerticesAndTopology) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    SurfaceMesh mesh = testing::torus_mesh(40, 16);
    for (Vec3& p : mesh.position) p += 0.01 * random.in_cube();
    const std::vector<Vec3> before = mesh.position;
    const EdgeOptimisationReport report = optimise_edges(mesh, options_, progress_);
    EXPECT_GT(report.flips, 0);
    EXPECT_EQ(mesh.position, before);
    expect_closed_manifold(mesh, 1, 1);
  }
}

TEST_P(EdgeOptimisation, LeavesFixedFacesAlone) {
  Random random(4);
  SurfaceMesh mesh = testing::torus_mesh(40, 16);
  for (Vec3& p : mesh.position) p += 0.02 * random.in_cube();
  const std::vector<Triangle> before = mesh.triangles();
  std::vector<Index> fixed;
  for (Index f = 0; f < mesh.face_slots(); f += 3) fixed.push_back(f);
  EXPECT_GT(optimise_edges(mesh, options_, progress_, fixed).flips, 0);
  for (const Index f : fixed) EXPECT_EQ(mesh.triangle(f), before[f]);
  std::vector<Index> all(static_cast<std::size_t>(mesh.face_slots()));
  for (Index f = 0; f < mesh.face_slots(); ++f) all[f] = f;
  EXPECT_EQ(optimise_edges(mesh, options_, progress_, all).flips, 0);
}

TEST_P(EdgeOptimisation, DoesNotDependOnThreads) {
  Random random(5);
  SurfaceMesh one = testing::torus_mesh(220, 100);  // several blocks
  for (Vec3& p : one.position) p += 0.003 * random.in_cube();
  SurfaceMesh two = one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    optimise_edges(one, options_, progress_);
  }
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
    optimise_edges(two, options_, progress_);
  }
  expect_same_mesh(one, two);
}

TEST_P(EdgeOptimisation, CanBeCancelled) {
  SurfaceMesh mesh = testing::torus_mesh(40, 16);
  Progress cancelled([](double, const char*) { return false; }, {Stage::edge_optimisation});
  EXPECT_THROW(optimise_edges(mesh, options_, cancelled), Cancelled);
}

INSTANTIATE_TEST_SUITE_P(Criteria, EdgeOptimisation,
                         ::testing::Values(Criterion::bending, Criterion::quadric),
                         [](const auto& instance) {
                           return instance.param == Criterion::bending ? "bending" : "quadric";
                         });

TEST(BendingCriterion, FollowsTheEdgesOfACube) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    SurfaceMesh mesh = cube(12, random);
    ASSERT_GT(cut_corners(mesh, random), 10);
    const std::vector<Vec3> outward(mesh.position);  // along the diagonals: good enough a guide
    Progress progress;
    optimise_edges(mesh, {}, progress, {}, &outward);
    Index across = 0;
    for (Index f = 0; f < mesh.face_slots(); ++f) across += !lies_in_one_side(mesh, f);
    EXPECT_EQ(across, 0);
    EXPECT_NEAR(signed_volume(mesh), 8.0, 1e-9);
  }
}

TEST(BendingCriterion, LeavesPlanesAlone) {
  Random random(6);
  SurfaceMesh mesh = cube(12, random);
  const std::vector<Triangle> before = mesh.triangles();
  Progress progress;
  // Squares: both diagonals are equally good everywhere.
  EXPECT_EQ(optimise_edges(mesh, {}, progress).flips, 0);
  EXPECT_EQ(mesh.triangles(), before);
}

TEST(BendingCriterion, KeepsTrianglesWellShaped) {
  // On a smooth surface the shape of triangles counts about as much as the last bit of bending.
  SurfaceMesh even = testing::icosphere(4);
  Random random(14);
  for (Vec3& p : even.position) p *= 1.0 + 0.003 * random.uniform(-1.0, 1.0);
  SurfaceMesh shaped = even, bent = even;
  Progress progress;
  EdgeOptimisationOptions options;
  options.crease_angle = 0.0;
  const Index flips = optimise_edges(shaped, options, progress).flips;
  options.shape_weight = 0.0;
  EXPECT_LT(3 * flips, optimise_edges(bent, options, progress).flips);
  EXPECT_GT(median_smallest_angle(shaped), 0.9 * median_smallest_angle(even));
}

TEST(BendingCriterion, IsDoneAfterOneCall) {
  Random random(7);
  SurfaceMesh mesh = testing::torus_mesh(40, 16);
  for (Vec3& p : mesh.position) p += 0.02 * random.in_cube();
  const std::vector<Vec3> guide = mesh.vertex_normals();
  Progress progress;
  EdgeOptimisationOptions options;
  options.crease_angle = 0.0;
  options.least_gap = 1.0;
  optimise_edges(mesh, options, progress, {}, &guide);
  EXPECT_EQ(optimise_edges(mesh, options, progress, {}, &guide).flips, 0);
}

// Eight collinear vertices on the ridge of a roof, joined across each other on both sides of the
// edge from end to end: no single flip gives either of its faces an area.
TEST(BendingCriterion, UnfoldsSliversOfCollinearVertices) {
  std::vector<Vec3> positions;
  for (int i = 0; i < 8; ++i) positions.push_back({1.0 * i, 0.0, 0.0});
  const Index front = 8, back = 9, below = 10;
  positions.push_back({3.5, 4.0, -1.0});
  positions.push_back({3.5, -4.0, -1.0});
  positions.push_back({3.5, 0.0, -6.0});
  SurfaceMesh mesh = SurfaceMesh::from_triangles(std::move(positions), {{0, 2, front},
                                                                        {2, 5, front},
                                                                        {5, 7, front},
                                                                        {0, 7, 5},
                                                                        {0, 5, 2},
                                                                        {7, 0, 1},
                                                                        {7, 1, 3},
                                                                        {7, 3, 4},
                                                                        {7, 4, 6},
                                                                        {1, 0, back},
                                                                        {3, 1, back},
                                                                        {4, 3, back},
                                                                        {6, 4, back},
                                                                        {7, 6, back},
                                                                        {0, front, below},
                                                                        {back, 0, below},
                                                                        {7, back, below},
                                                                        {front, 7, below}});
  Progress silent;
  optimise_edges(mesh, {}, silent);
  expect_closed_manifold(mesh, 1, 0);
  for (Index f = 0; f < mesh.face_slots(); ++f)
    EXPECT_GT(mesh.area_vector(f).norm(), 0.1) << "face " << f;
}

TEST(BendingCriterion, SurvivesDegenerateTriangles) {
  SurfaceMesh mesh = testing::icosphere(2);
  Random random(8);
  for (int i = 0; i < 40; ++i)
    mesh.position[random.below(mesh.vertex_slots())] =
        mesh.position[random.below(mesh.vertex_slots())];
  Progress progress;
  optimise_edges(mesh, {}, progress);
  expect_closed_manifold(mesh, 1, 0);
}

// Edges of a torus flipped at random where that leaves both faces an area.
void flip_some(SurfaceMesh& mesh, Random& random) {
  for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
    if (random.below(3) != 0 || !mesh.is_flip_legal(h)) continue;
    const Index o = mesh.twin(h);
    const Vec3 outward = mesh.area_vector(SurfaceMesh::face(h)).normalized() +
                         mesh.area_vector(SurfaceMesh::face(o)).normalized();
    mesh.flip(h);
    for (const Index f : {SurfaceMesh::face(h), SurfaceMesh::face(o)})
      if (mesh.area_vector(f).normalized().dot(outward) < 1.0) {
        mesh.flip_back(h);
        break;
      }
  }
}

Index delaunay_flips_wanted(const SurfaceMesh& mesh) {
  Index count = 0;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    count += wants_delaunay_flip(mesh, h) && mesh.is_flip_legal(h);
  return count;
}

TEST(CreaseAngle, MakesSmoothSurfacesDelaunay) {
  Random random(9);
  SurfaceMesh bent = testing::torus_mesh(120, 40);
  for (Vec3& p : bent.position) p += 0.003 * random.in_cube();
  flip_some(bent, random);
  SurfaceMesh shaped = bent;
  Progress progress;
  EdgeOptimisationOptions options;
  options.least_gap = 1.0;
  options.crease_angle = 0.0;
  optimise_edges(bent, options, progress);
  options.crease_angle = kPi;
  options.least_angle = 0.0;
  optimise_edges(shaped, options, progress);
  EXPECT_GT(delaunay_flips_wanted(bent), 100);
  EXPECT_EQ(delaunay_flips_wanted(shaped), 0);
  EXPECT_GT(median_smallest_angle(shaped), median_smallest_angle(bent));
  expect_closed_manifold(shaped, 1, 1);
}

TEST(CreaseAngle, LeavesCreasesAlone) {
  // A rod of long squares, whose inner vertices stand opposite to the middle of the edges of its
  // sides: Delaunay alone would cut these edges.
  Random random(10);
  SurfaceMesh mesh = cube(12, random);
  const auto is_inner = [](const Vec3& p) { return (p.cwiseAbs().array() < 1.0).count() == 2; };
  for (Vec3& p : mesh.position)
    p.x() = 8.0 * (p.x() + (is_inner(p) && std::abs(p.x()) < 1.0 ? 1.0 / 12.0 : 0.0));
  const std::vector<Vec3> outward(mesh.position);
  const auto faces_across_edges = [&] {
    SurfaceMesh as_cube = mesh;
    for (Vec3& p : as_cube.position) p.x() /= 8.0;
    Index count = 0;
    for (Index f = 0; f < mesh.face_slots(); ++f) count += !lies_in_one_side(as_cube, f);
    return count;
  };
  Progress progress;
  EdgeOptimisationOptions options;
  options.crease_angle = kPi / 6.0;
  options.least_angle = 0.0;
  EXPECT_GT(optimise_edges(mesh, options, progress, {}, &outward).flips, 0);
  EXPECT_EQ(faces_across_edges(), 0);
  options.crease_angle = kPi;
  optimise_edges(mesh, options, progress, {}, &outward);
  EXPECT_GT(faces_across_edges(), 20);
}

TEST(CreaseAngle, MakesNoCreaseOnRoughSurfaces) {
  Random random(11);
  SurfaceMesh mesh = testing::torus_mesh(120, 40);
  for (Vec3& p : mesh.position) p += 0.02 * random.in_cube();
  Progress progress;
  EdgeOptimisationOptions options;
  options.least_gap = 1.0;
  const std::vector<Vec3> guide = mesh.vertex_normals();
  options.crease_angle = 0.0;
  optimise_edges(mesh, options, progress, {}, &guide);
  options.least_angle = 0.0;
  options.crease_angle = kPi / 4.0;
  using Edge = std::pair<Index, Index>;
  const auto is_creased = [&](Index h) {
    const auto normal = [&](Index g) {
      return mesh.area_vector(SurfaceMesh::face(g)).normalized();
    };
    return normal(h).dot(normal(mesh.twin(h))) < std::cos(options.crease_angle);
  };
  std::set<Edge> flat;
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    if (!is_creased(h)) flat.emplace(mesh.origin(h), mesh.target(h));
  EXPECT_LT(flat.size(), static_cast<std::size_t>(mesh.halfedge_slots()) * 3 / 4);
  EXPECT_GT(optimise_edges(mesh, options, progress, {}, &guide).flips, 100);
  Index new_creases = 0;  // of edges that were there before
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    new_creases += is_creased(h) && flat.count(Edge(mesh.origin(h), mesh.target(h))) > 0;
  EXPECT_EQ(new_creases, 0);
}

// A prism of eight sides, along whose edges vertices are twice as far apart as within the sides:
// Delaunay flips would cut the edges, and bend the sides of their hinges by less than 40 degrees.
TEST(CreaseAngle, KeepsCrestsAboveIt) {
  constexpr int kSides = 8, kAcross = 8, kAlong = 40;
  std::vector<Vec3> positions;
  std::vector<std::vector<Index>> column;
  for (int side = 0; side < kSides; ++side) {
    const double turn = 2.0 * kPi / kSides;
    const Vec3 from(std::cos(turn * side), std::sin(turn * side), 0.0),
        to(std::cos(turn * (side + 1)), std::sin(turn * (side + 1)), 0.0);
    for (int i = 0; i < kAcross; ++i) {
      column.emplace_back();
      for (int k = 0; k <= kAlong; k += i == 0 ? 2 : 1) {
        column.back().push_back(static_cast<Index>(positions.size()));
        positions.push_back(from + (to - from) * i / kAcross + Vec3(0.0, 0.0, 0.1 * k));
      }
    }
  }
  std::vector<Triangle> triangles;
  for (std::size_t c = 0; c < column.size(); ++c) {
    const std::vector<Index>&left = column[c], &right = column[(c + 1) % column.size()];
    std::size_t i = 0, j = 0;
    while (i + 1 < left.size() || j + 1 < right.size())
      if (j + 1 == right.size() || (i + 1 < left.size() && i * right.size() <= j * left.size())) {
        triangles.push_back({left[i], right[j], left[i + 1]});
        ++i;
      } else {
        triangles.push_back({left[i], right[j], right[j + 1]});
        ++j;
      }
  }
  for (const bool is_top : {false, true}) {
    const Index apex = static_cast<Index>(positions.size());
    positions.push_back({0.0, 0.0, is_top ? 0.1 * kAlong : 0.0});
    for (std::size_t c = 0; c < column.size(); ++c) {
      const std::vector<Index>&left = column[c], &right = column[(c + 1) % column.size()];
      if (is_top)
        triangles.push_back({left.back(), right.back(), apex});
      else
        triangles.push_back({right.front(), left.front(), apex});
    }
  }
  SurfaceMesh mesh = SurfaceMesh::from_triangles(positions, triangles);
  const auto crest_edges = [&] {
    Index count = 0;
    for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
      const Vec3 &p = mesh.position[mesh.origin(h)], &q = mesh.position[mesh.target(h)];
      const double z = q.z() - p.z();
      count += (q - p).head<2>().isZero(1e-9) && p.head<2>().norm() > 1.0 - 1e-9 && z > 0.15;
    }
    return count;
  };
  ASSERT_EQ(crest_edges(), kSides * kAlong / 2);
  Progress progress;
  EdgeOptimisationOptions options;
  optimise_edges(mesh, options, progress);
  EXPECT_EQ(crest_edges(), kSides * kAlong / 2);
  options.crease_angle = 50.0 * kPi / 180.0;
  options.least_gap = 1.0;
  optimise_edges(mesh, options, progress);
  EXPECT_LT(crest_edges(), kSides * kAlong / 4);
}

// Where the triangles of the Delaunay triangulation are thin too, the bending has the last word,
// but where it hardly differs.
TEST(CreaseAngle, LeavesThinTrianglesToTheBending) {
  SurfaceMesh bent = testing::torus_mesh(30, 90);  // long along the ring, short around it
  Random random(12);
  flip_some(bent, random);
  SurfaceMesh strict = bent, by_default = bent, without_least = bent;
  Progress progress;
  EdgeOptimisationOptions options;
  optimise_edges(by_default, options, progress);
  options.most_bending = 1.0;
  optimise_edges(strict, options, progress);
  options.least_angle = 0.0;
  optimise_edges(without_least, options, progress);
  options.crease_angle = 0.0;
  optimise_edges(bent, options, progress);
  EXPECT_EQ(strict.triangles(), bent.triangles());
  EXPECT_LT(delaunay_flips_wanted(by_default), delaunay_flips_wanted(bent));
  EXPECT_GT(delaunay_flips_wanted(by_default), 2 * delaunay_flips_wanted(without_least));
}

// A saddle: its hinge bends by 63 degrees about the longer diagonal, which is not Delaunay, and by
// 52 degrees about the other one. In all the five edges bend by a quarter more with that.
TEST(CreaseAngle, CreasesThatShowEitherWayBecomeDelaunay) {
  const SurfaceMesh saddle = SurfaceMesh::from_triangles(
      {Vec3(-1.0, 0, 0.3), Vec3(1.0, 0, 0.3), Vec3(0, 0.8, -0.192), Vec3(0, -0.8, -0.192),
       Vec3(-1.2, 1.0, -0.08), Vec3(1.2, 1.0, -0.08), Vec3(1.2, -1.0, -0.08),
       Vec3(-1.2, -1.0, -0.08), Vec3(0, 0, -3.0)},
      {Triangle{0, 1, 2}, Triangle{1, 0, 3}, Triangle{0, 2, 4}, Triangle{2, 1, 5},
       Triangle{1, 3, 6}, Triangle{3, 0, 7}, Triangle{4, 2, 8}, Triangle{0, 4, 8},
       Triangle{5, 1, 8}, Triangle{2, 5, 8}, Triangle{6, 3, 8}, Triangle{1, 6, 8},
       Triangle{7, 0, 8}, Triangle{3, 7, 8}});
  std::vector<Index> all_others;
  for (Index f = 2; f < saddle.face_slots(); ++f) all_others.push_back(f);
  const auto flips = [&](double most_bending) {
    EdgeOptimisationOptions options;
    options.shape_weight = 0.0;
    options.most_bending = most_bending;
    SurfaceMesh mesh = saddle;
    Progress progress;
    return optimise_edges(mesh, options, progress, all_others).flips;
  };
  EXPECT_EQ(flips(1.1), 0);
  EXPECT_EQ(flips(1.3), 1);
}

TEST(CreaseAngle, MakesEvenTrianglesDelaunayByDefault) {
  SurfaceMesh mesh = testing::icosphere(4);
  Random random(13);
  for (Vec3& p : mesh.position) p *= 1.0 + 0.002 * random.uniform(-1.0, 1.0);
  SurfaceMesh bent = mesh;
  EdgeOptimisationOptions options;
  Progress progress;
  optimise_edges(mesh, options, progress);
  EXPECT_EQ(delaunay_flips_wanted(mesh), 0);
  options.crease_angle = 0.0;
  optimise_edges(bent, options, progress);
  EXPECT_GT(delaunay_flips_wanted(bent), 100);
}

TEST(LeastGap, LeavesFlatPartsAndCreasesAlone) {
  Random random(17);
  SurfaceMesh mesh = cube(12, random);
  // Turned, so that rounding leaves gaps between the diagonals.
  const Eigen::AngleAxisd turn(0.7, Vec3(1.0, 2.0, 3.0).normalized());
  for (Vec3& p : mesh.position) p = turn * p;
  const std::vector<Triangle> before = mesh.triangles();
  EdgeOptimisationOptions options;
  options.least_gap = 0.0;
  Progress progress;
  EXPECT_EQ(optimise_edges(mesh, options, progress).flips, 0);
  EXPECT_EQ(mesh.triangles(), before);
}

TEST(EdgeOptimisationOfATetrahedron, FlipsNothing) {
  SurfaceMesh mesh = SurfaceMesh::from_triangles(
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)},
      {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{1, 2, 3}, Triangle{0, 3, 2}});
  Progress progress;
  EXPECT_EQ(optimise_edges(mesh, {}, progress).flips, 0);
  expect_closed_manifold(mesh, 1, 0);
}

}  // namespace
}  // namespace shrinkwrap
