#include "complete_matching/draw_in.h"

#include <algorithm>

#include "mesh/box_tree.h"
#include "mesh/face_patches.h"
#include "mesh/fresh_faces.h"
#include "mesh/one_ring.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {
namespace {

class DrawingIn {
 public:
  DrawingIn(SurfaceMesh& mesh, const std::vector<Index>& opening_faces, std::int64_t max_tests,
            Progress& progress)
      : mesh_(mesh),
        opening_faces_(opening_faces),
        boxes_(mesh.position, mesh.triangles(), progress),
        pairs_(mesh.position),
        tests_left_(max_tests) {}

  bool has_tests_left() const { return tests_left_ > 0; }

  // Moves the vertex there if none of its faces cuts another then.
  bool try_move(Index v, const Vec3& to) {
    if (to == mesh_.position[v]) return false;
    star_ = faces_around(mesh_, {v});
    const Vec3 before = mesh_.position[v];
    mesh_.position[v] = to;
    if (star_cuts()) {
      mesh_.position[v] = before;
      return false;
    }
    for (const Index f : star_) boxes_.set_box(f, boxes_.box_of(mesh_.position, mesh_.triangle(f)));
    return true;
  }

 private:
  // Whether faces of the star meet each other or any that stays; true if the tests do not suffice.
  bool star_cuts() {
    fresh_.clear();
    for (const Index f : star_) fresh_.push_back(mesh_.triangle(f));
    const auto is_gone = [&](Index f) {
      return std::binary_search(star_.begin(), star_.end(), f) ||
             std::binary_search(opening_faces_.begin(), opening_faces_.end(), f);
    };
    return fresh_faces_cut(mesh_, boxes_, pairs_, fresh_, false, is_gone, [&](std::int64_t tests) {
      tests_left_ -= tests;
      return has_tests_left();
    });
  }

  SurfaceMesh& mesh_;
  const std::vector<Index>& opening_faces_;
  BoxTree boxes_;
  TrianglePairs pairs_;
  std::int64_t tests_left_;
  std::vector<Index> star_;      // faces, ascending
  std::vector<Triangle> fresh_;  // their corners
};

// Extra vertices within what spans openings, but for those that go with their faces.
std::vector<Index> spanning_vertices(const CompleteMatching& matching, Index samples) {
  const SurfaceMesh& mesh = matching.mesh;
  std::vector<Index> vertices;
  for (Index v = samples; v < mesh.vertex_slots(); ++v) {
    const std::vector<Index> star = faces_around(mesh, {v});
    const auto is_within = [&](const std::vector<Index>& faces) {
      return std::all_of(star.begin(), star.end(), [&](Index f) {
        return std::binary_search(faces.begin(), faces.end(), f);
      });
    };
    if (is_within(matching.spanning_faces) && !is_within(matching.opening_faces))
      vertices.push_back(v);
  }
  return vertices;
}

}  // namespace

Index draw_in_extra_vertices(CompleteMatching& matching, Index samples, const Frame& frame,
                             HostScalar scalar, const DrawingInOptions& options,
                             Progress& progress) {
  if (matching.spanning_faces.empty()) return 0;
  SurfaceMesh& mesh = matching.mesh;
  const std::vector<Index> vertices = spanning_vertices(matching, samples);
  if (vertices.empty()) return 0;
  const std::int64_t tests =
      options.max_tests > 0 ? options.max_tests : 2000000 + 20 * std::int64_t{mesh.face_count()};
  DrawingIn drawing(mesh, matching.opening_faces, tests, progress);
  std::vector<char> has_moved(vertices.size(), 0);
  for (int round = 0; round < options.rounds; ++round)
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      progress.update(0.0);
      if (!drawing.has_tests_left()) break;
      const Index v = vertices[i];
      const Vec3 whole = gather_one_ring(mesh, v).laplacian();
      bool is_done = false;
      double step = options.step;
      for (int halving = 0; halving <= options.halvings && !is_done; ++halving, step *= 0.5)
        is_done =
            drawing.try_move(v, rounded_to_host(mesh.position[v] + step * whole, frame, scalar));
      if (is_done) has_moved[i] = 1;
    }
  return static_cast<Index>(std::count(has_moved.begin(), has_moved.end(), 1));
}

}  // namespace shrinkwrap
