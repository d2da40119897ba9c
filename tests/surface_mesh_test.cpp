// The half-edge mesh: every operation keeps a closed 2-manifold, and refuses where it could not.
#include "mesh/surface_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "expect_mesh.h"
#include "shapes.h"

namespace shrinkwrap::testing {
namespace {

std::vector<Triangle> tetrahedron() {
  return {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
}
const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(SurfaceMesh, LinksOfATetrahedron) {
  const SurfaceMesh mesh = SurfaceMesh::from_triangles(kCorners, tetrahedron());
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(mesh.euler_characteristic(), 2);
  EXPECT_NEAR(signed_volume(mesh), 1.0 / 6.0, 1e-15);
  for (Index v = 0; v < 4; ++v) EXPECT_EQ(mesh.valence(v), 3);
  for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
    EXPECT_EQ(mesh.twin(mesh.twin(h)), h);
    EXPECT_EQ(mesh.origin(mesh.twin(h)), mesh.target(h));
    EXPECT_EQ(mesh.find_halfedge(mesh.origin(h), mesh.target(h)), h);
    EXPECT_FALSE(mesh.is_flip_legal(h)) << "the other diagonal is an edge already";
    EXPECT_FALSE(mesh.is_collapse_legal(h)) << "nothing smaller is closed";
  }
}

TEST(SurfaceMesh, RefusesWhatIsNoClosedManifold) {
  const auto build = [](std::vector<Triangle> faces, std::vector<Vec3> corners = kCorners) {
    return SurfaceMesh::from_triangles(std::move(corners), faces);
  };
  std::vector<Triangle> faces = tetrahedron();
  faces.pop_back();
  EXPECT_THROW(build(faces), InvalidInput) << "a border";
  faces = tetrahedron();
  std::swap(faces[0][0], faces[0][1]);
  EXPECT_THROW(build(faces), InvalidInput) << "one face turned";
  faces = tetrahedron();
  faces[0][0] = 4;
  EXPECT_THROW(build(faces), InvalidInput) << "an unknown vertex";
  faces[0][0] = -1;
  EXPECT_THROW(build(faces), InvalidInput) << "an unknown vertex";
  faces[0][0] = faces[0][1];
  EXPECT_THROW(build(faces), InvalidInput) << "one vertex twice";
  faces = tetrahedron();
  faces.push_back(faces[0]);
  EXPECT_THROW(build(faces), InvalidInput) << "a face twice";
  std::vector<Vec3> corners = kCorners;
  corners.emplace_back(5, 5, 5);
  EXPECT_THROW(build(tetrahedron(), corners), InvalidInput) << "a vertex without faces";
  // Two tetrahedra that share vertex 0.
  corners.insert(corners.end(), {{-1, 0, 0}, {0, -1, 0}});
  faces = tetrahedron();
  for (const Triangle& t : tetrahedron()) {
    const auto other = [](Index v) { return v == 0 ? 0 : v + 3; };
    faces.push_back({other(t[0]), other(t[1]), other(t[2])});
  }
  EXPECT_THROW(build(faces, corners), InvalidInput) << "a vertex with two fans";
}

// Two cones over one rim; vertices 0 and 1 are the tips.
std::vector<Triangle> double_cone(Index rim) {
  std::vector<Triangle> faces;
  for (Index i = 0; i < rim; ++i) {
    const Index from = 2 + i, to = 2 + (i + 1) % rim;
    faces.push_back({0, from, to});
    faces.push_back({1, to, from});
  }
  return faces;
}

TEST(SurfaceMesh, MatchesTheEdgesOfVerticesWithManyFaces) {
  constexpr Index kRim = 500;
  std::vector<Vec3> positions = {{0, 0, 1}, {0, 0, -1}};
  for (Index i = 0; i < kRim; ++i)
    positions.emplace_back(std::cos(2.0 * kPi * i / kRim), std::sin(2.0 * kPi * i / kRim), 0.0);
  const std::vector<Triangle> faces = double_cone(kRim);
  const SurfaceMesh mesh = SurfaceMesh::from_triangles(positions, faces);
  expect_closed_manifold(mesh, 1, 0);
  EXPECT_EQ(mesh.valence(0), kRim);

  const auto expect_refused = [&](const std::vector<Triangle>& wrong, const std::string& why) {
    try {
      SurfaceMesh::from_triangles(positions, wrong);
      FAIL() << why << " was accepted";
    } catch (const InvalidInput& refusal) {
      EXPECT_NE(std::string(refusal.what()).find(why), std::string::npos) << refusal.what();
    }
  };
  std::vector<Triangle> wrong = faces;
  wrong.pop_back();
  expect_refused(wrong, "border");
  wrong = faces;
  std::swap(wrong[100][0], wrong[100][1]);
  expect_refused(wrong, "inconsistent orientation");
  wrong = faces;
  wrong.push_back({0, 2, 3});
  expect_refused(wrong, "more than two faces");
}

TEST(SurfaceMesh, RandomOperationsKeepAClosedManifold) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SurfaceMesh mesh = torus_mesh(16, 9);
    Index inserted = 0, removed = 0, flips = 0;
    const Index before = mesh.vertex_count();
    for (int i = 0; i < 3000; ++i) {
      const Index h = random.below(mesh.halfedge_slots());
      if (mesh.is_removed_face(SurfaceMesh::face(h))) continue;
      switch (random.below(3)) {
        case 0:
          mesh.split_face(SurfaceMesh::face(h), random.in_cube());
          ++inserted;
          break;
        case 1:
          if (!mesh.is_flip_legal(h)) break;
          mesh.flip(h);
          ++flips;
          break;
        default:
          if (!mesh.is_collapse_legal(h)) break;
          mesh.collapse(h);
          ++removed;
      }
      if (i % 500 == 0) {
        ASSERT_TRUE(mesh.is_consistent());
      }
    }
    EXPECT_GT(flips, 100);
    EXPECT_GT(removed, 100);
    EXPECT_EQ(mesh.vertex_count(), before + inserted - removed);
    mesh.compact();
    expect_closed_manifold(mesh, 1, 1);
  }
}

TEST(SurfaceMesh, MovesAVertexFromFaceToFace) {
  Random random(1);
  SurfaceMesh mesh = torus_mesh(16, 9);
  const Index face_count = mesh.face_count() + 2;
  const Index v = mesh.split_face(7, random.in_cube());
  for (int i = 0; i < 500; ++i) {
    const Index h = mesh.outgoing(v), g = mesh.rotate(h), k = mesh.rotate(g);
    const Triangle ring = {mesh.target(k), mesh.target(h), mesh.target(g)};
    const Index f = random.below(mesh.face_slots());
    const Triangle t = mesh.triangle(f);
    ASSERT_TRUE(mesh.is_move_legal(v));
    if (std::find(t.begin(), t.end(), v) != t.end()) continue;
    const Index one = mesh.move_vertex(v, f);
    Triangle made = mesh.triangle(one);
    while (made[0] != ring[0]) std::rotate(made.begin(), made.begin() + 1, made.end());
    ASSERT_EQ(made, ring);
    ASSERT_EQ(mesh.triangle(f), (Triangle{t[0], t[1], v}));
    ASSERT_TRUE(mesh.is_consistent());
  }
  EXPECT_EQ(mesh.face_count(), face_count);
  expect_closed_manifold(mesh, 1, 1);
  EXPECT_FALSE(mesh.is_move_legal(mesh.origin(0))) << "six faces";
  const SurfaceMesh tetrahedron =
      SurfaceMesh::from_triangles({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)},
                                  {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  for (Index corner = 0; corner < 4; ++corner) EXPECT_FALSE(tetrahedron.is_move_legal(corner));
}

TEST(SurfaceMesh, CollapsesStopBeforeTheHandleIsLost) {
  SurfaceMesh mesh = torus_mesh(12, 8);
  for (bool found = true; found;) {
    found = false;
    for (Index h = 0; h < mesh.halfedge_slots(); ++h) {
      if (mesh.is_removed_face(SurfaceMesh::face(h)) || !mesh.is_collapse_legal(h)) continue;
      mesh.collapse(h);
      found = true;
    }
  }
  mesh.compact();
  expect_closed_manifold(mesh, 1, 1);
  EXPECT_GE(mesh.vertex_count(), 7) << "no triangulated torus has fewer";
  EXPECT_LT(mesh.vertex_count(), 20);
}

TEST(SurfaceMesh, FlipTwiceIsTheSameEdge) {
  SurfaceMesh mesh = icosphere(1);
  const Index a = mesh.origin(0), b = mesh.target(0), c = mesh.opposite(0),
              d = mesh.opposite(mesh.twin(0));
  ASSERT_TRUE(mesh.is_flip_legal(0));
  mesh.flip(0);
  EXPECT_EQ(mesh.find_halfedge(a, b), kNone);
  EXPECT_NE(mesh.find_halfedge(c, d), kNone);
  EXPECT_EQ(mesh.origin(0), d);
  EXPECT_EQ(mesh.target(0), c);
  mesh.flip(0);
  EXPECT_NE(mesh.find_halfedge(a, b), kNone);
  expect_closed_manifold(mesh, 1, 0);
}

TEST(SurfaceMesh, PatchesComeBack) {
  Random random(3);
  SurfaceMesh mesh = icosphere(3);
  std::vector<Index> patch;
  for (Index f = 0; f < mesh.face_slots(); ++f)
    if (mesh.position[mesh.triangle(f)[0]].z() > 0.3) patch.push_back(f);
  const auto is_inside = [&](Index h) {
    return std::binary_search(patch.begin(), patch.end(), SurfaceMesh::face(h));
  };
  const SurfaceMesh before = mesh;
  const SurfaceMesh::Patch copy = mesh.copy_patch(patch);
  int flips = 0, moves = 0;
  for (int i = 0; i < 5000; ++i) {
    const Index h =
        3 * patch[static_cast<std::size_t>(random.below(static_cast<Index>(patch.size())))];
    if (is_inside(mesh.twin(h)) && mesh.is_flip_legal(h)) {
      mesh.flip(h);
      ++flips;
    }
    const Index v = mesh.origin(h), to = patch[static_cast<std::size_t>(i) % patch.size()];
    bool may_move = mesh.valence(v) == 3 && mesh.is_move_legal(v);
    mesh.for_each_outgoing(
        v, [&](Index g) { may_move = may_move && is_inside(g) && SurfaceMesh::face(g) != to; });
    if (!may_move) continue;
    mesh.move_vertex(v, to);
    ++moves;
  }
  EXPECT_GT(flips, 1000);
  EXPECT_GT(moves, 50);
  EXPECT_NE(mesh.triangles(), before.triangles());
  ASSERT_TRUE(mesh.is_consistent());
  mesh.restore_patch(copy);
  EXPECT_TRUE(mesh.is_consistent());
  EXPECT_EQ(mesh.triangles(), before.triangles());
}

TEST(SurfaceMesh, CanonicalFormIsThatOfItsTriangles) {
  Random random(7);
  SurfaceMesh mesh = icosphere(3);
  for (int i = 0; i < 300; ++i) {
    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_removed_face(SurfaceMesh::face(h)) && mesh.is_collapse_legal(h)) mesh.collapse(h);
  }
  const SurfaceMesh before = mesh;
  const std::vector<Index> new_index = mesh.compact();
  for (Index v = 0; v < before.vertex_slots(); ++v) {
    ASSERT_EQ(new_index[v] == kNone, before.is_removed_vertex(v));
    if (new_index[v] == kNone) continue;
    EXPECT_EQ(mesh.position[new_index[v]], before.position[v]);
  }
  const SurfaceMesh rebuilt = SurfaceMesh::from_triangles(mesh.position, mesh.triangles());
  expect_same_mesh(rebuilt, mesh);
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    EXPECT_EQ(mesh.outgoing(v), rebuilt.outgoing(v)) << "vertex " << v;
}

TEST(SurfaceMesh, FacesAreFollowedWhenVerticesAreRenumbered) {
  Random random(8);
  SurfaceMesh mesh = icosphere(2);
  for (int i = 0; i < 60; ++i) {
    const Index h = random.below(mesh.halfedge_slots());
    if (!mesh.is_removed_face(SurfaceMesh::face(h)) && mesh.is_collapse_legal(h)) mesh.collapse(h);
  }
  const SurfaceMesh before = mesh;
  std::vector<Index> new_index(before.position.size(), kNone);
  Index left = before.vertex_count();  // the other way round
  for (Index v = 0; v < before.vertex_slots(); ++v)
    if (!before.is_removed_vertex(v)) new_index[v] = --left;
  const std::vector<Index> new_face = mesh.renumber(new_index);
  ASSERT_EQ(new_face.size(), static_cast<std::size_t>(before.face_slots()));
  for (Index f = 0; f < before.face_slots(); ++f) {
    ASSERT_EQ(new_face[f] == kNone, before.is_removed_face(f));
    if (new_face[f] == kNone) continue;
    const Triangle was = before.triangle(f), is = mesh.triangle(new_face[f]);
    for (int corner = 0; corner < 3; ++corner) EXPECT_EQ(is[corner], new_index[was[corner]]);
  }
}

TEST(SurfaceMesh, ComponentsAreCounted) {
  std::vector<Triangle> faces = tetrahedron();
  for (const Triangle& t : tetrahedron()) faces.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  std::vector<Vec3> corners = kCorners;
  for (const Vec3& p : kCorners) corners.push_back(p + Vec3(3, 0, 0));
  const MeshComponents components =
      connected_components(SurfaceMesh::from_triangles(corners, faces));
  EXPECT_EQ(components.count, 2);
  EXPECT_EQ(components.of_vertex, (std::vector<Index>{0, 0, 0, 0, 1, 1, 1, 1}));
}

TEST(RoundToHost, LeavesWhatSinglePrecisionHolds) {
  Frame frame;
  frame.center = Vec3(1234.5, -77.0, 0.25);
  frame.scale = 1.0 / 64.0;
  SurfaceMesh mesh = icosphere(3);
  round_to_host(mesh, frame, HostScalar::single_precision);
  for (const Vec3& p : mesh.position) {
    const Vec3 in_host = frame.to_input(p);
    EXPECT_EQ(in_host, rounded_to_single(in_host));
  }
  const SurfaceMesh once = mesh;
  round_to_host(mesh, frame, HostScalar::single_precision);
  EXPECT_EQ(mesh.position, once.position) << "a second trip must change nothing";
}

}  // namespace
}  // namespace shrinkwrap::testing
