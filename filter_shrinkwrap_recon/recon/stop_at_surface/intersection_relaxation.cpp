#include "stop_at_surface/intersection_relaxation.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <utility>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "mesh/box_tree.h"
#include "mesh/face_patches.h"
#include "mesh/one_ring.h"
#include "mesh/self_intersection.h"
#include "mesh/triangle_pair.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 8;

// The faces that meet one of those given, and these of which that is true; ascending. Near-linear
// in heaps too: a pair of which both are known is not tested. Which faces are found does not depend
// on who comes first.
std::vector<Index> faces_that_meet(const SurfaceMesh& mesh, const BoxTree& tree,
                                   const TrianglePairs& test, const std::vector<Index>& faces,
                                   Progress& progress) {
  const auto is_found =
      std::make_unique<std::atomic<bool>[]>(static_cast<std::size_t>(mesh.face_slots()));
  std::vector<Index> found = parallel_collect<Index>(
      static_cast<Index>(faces.size()), kGrain, progress,
      [&](Index begin, Index end, std::vector<Index>& some) {
        const auto add = [&](Index f) {
          if (!is_found[f].exchange(true, std::memory_order_relaxed)) some.push_back(f);
        };
        for (Index i = begin; i < end; ++i) {
          const Index f = faces[i];
          const Triangle t = mesh.triangle(f);
          tree.for_each_overlap(tree.box_of(mesh.position, t), [&](Index g) {
            if (g == f || (is_found[f].load(std::memory_order_relaxed) &&
                           is_found[g].load(std::memory_order_relaxed)))
              return;
            if (!test.meet(t, mesh.triangle(g))) return;
            add(f);
            add(g);
          });
        }
      });
  std::sort(found.begin(), found.end());
  return found;
}

// Moves vertices, and remembers where they were.
class Relaxation {
 public:
  Relaxation(SurfaceMesh& mesh, const Frame& frame, HostScalar scalar,
             const RelaxationOptions& options, Progress& progress)
      : mesh_(mesh),
        frame_(frame),
        scalar_(scalar),
        options_(options),
        progress_(progress),
        components_(connected_components(mesh, progress)),
        size_(static_cast<std::size_t>(components_.count), 0),
        has_moved_(mesh.position.size(), 0) {
    for (const Index component : components_.of_vertex)
      if (component != kNone) ++size_[component];
  }

  // Smooths these faces and some rings around them; returns the faces that have changed, ascending.
  std::vector<Index> smooth_around(const std::vector<Index>& faces, int rings) {
    std::vector<Index> region = corners_of(mesh_, faces);
    for (int ring = 0; ring < rings; ++ring) {
      progress_.update(0.0);
      region = corners_of(mesh_, faces_around(mesh_, region));
    }
    leave_out_whole_bodies(region);
    for (const Index v : region)
      if (!has_moved_[v]) {
        has_moved_[v] = 1;
        original_.emplace_back(v, mesh_.position[v]);
      }
    const Index count = static_cast<Index>(region.size());
    moved_.resize(region.size());
    for (int step = 0; step < options_.steps + rings; ++step) {
      parallel_for_each(count, kGrain, progress_, [&](Index i) {
        moved_[i] = mesh_.position[region[i]] +
                    options_.weight * gather_one_ring(mesh_, region[i]).laplacian();
      });
      for (Index i = 0; i < count; ++i) mesh_.position[region[i]] = moved_[i];
    }
    for (const Index v : region)
      mesh_.position[v] = rounded_to_host(mesh_.position[v], frame_, scalar_);
    return faces_around(mesh_, region);
  }

  void keep() {
    kept_.clear();
    for (const auto& entry : original_) kept_.push_back(mesh_.position[entry.first]);
  }
  // All vertices to where they were when `keep` was called last, or at first.
  void restore() {
    for (std::size_t i = 0; i < original_.size(); ++i) {
      const auto& [v, position] = original_[i];
      mesh_.position[v] = i < kept_.size() ? kept_[i] : position;
    }
  }
  Index moved() const { return static_cast<Index>(kept_.size()); }

 private:
  // Without a vertex that stays, a body would shrink to a point.
  void leave_out_whole_bodies(std::vector<Index>& region) const {
    std::vector<Index> count(size_.size(), 0);
    for (const Index v : region) ++count[components_.of_vertex[v]];
    const auto is_whole = [&](Index v) {
      const Index component = components_.of_vertex[v];
      return count[component] == size_[component];
    };
    region.erase(std::remove_if(region.begin(), region.end(), is_whole), region.end());
  }

  SurfaceMesh& mesh_;
  const Frame& frame_;
  const HostScalar scalar_;
  const RelaxationOptions& options_;
  Progress& progress_;
  const MeshComponents components_;
  std::vector<Index> size_;  // vertices of each component
  std::vector<char> has_moved_;
  std::vector<std::pair<Index, Vec3>> original_;  // of each vertex that moved
  std::vector<Vec3> kept_;                        // of the first of these
  std::vector<Vec3> moved_;
};

}  // namespace

RelaxationReport relax_self_intersections(SurfaceMesh& mesh, const Frame& frame, HostScalar scalar,
                                          const RelaxationOptions& options, Progress& progress) {
  RelaxationReport report;
  const std::vector<Triangle> triangles = mesh.triangles();
  BoxTree tree(mesh.position, triangles, progress);
  const TrianglePairs test(mesh.position);
  std::vector<Index> fewest = self_intersecting_faces(tree, test, triangles, progress);
  report.faces_before = static_cast<Index>(fewest.size());

  if (static_cast<double>(fewest.size()) <= options.most * mesh.face_count()) {
    Relaxation relaxation(mesh, frame, scalar, options, progress);
    std::vector<Index> meeting = fewest;
    const double most = options.most_growth * static_cast<double>(report.faces_before);
    while (!fewest.empty() && report.rounds < options.max_rounds &&
           static_cast<double>(meeting.size()) <= most) {
      progress.update(static_cast<double>(report.rounds) / options.max_rounds);
      const std::vector<Index> changed =
          relaxation.smooth_around(meeting, report.rounds / options.rounds_a_ring);
      ++report.rounds;
      if (changed.empty()) break;
      for (const Index f : changed) tree.set_box(f, tree.box_of(mesh.position, mesh.triangle(f)));
      std::vector<Index> now = faces_that_meet(mesh, tree, test, changed, progress);
      // Faces of bodies that are left alone have not changed, but may still meet others.
      const std::vector<Index> before = faces_that_meet(mesh, tree, test, meeting, progress);
      meeting.clear();
      std::set_union(now.begin(), now.end(), before.begin(), before.end(),
                     std::back_inserter(meeting));
      if (meeting.size() >= fewest.size()) continue;
      fewest = meeting;
      relaxation.keep();
    }
    relaxation.restore();
    report.moved = relaxation.moved();
    if (!fewest.empty() && options.repair.enabled) {
      RepairOptions only_intersections = options.repair;
      only_intersections.folds.most_folded = 0.0;  // membranes fold at their rims
      RepairReport repair = repair_self_intersections(mesh, only_intersections, progress);
      report.flips = repair.flips + repair.relocated;
      fewest = std::move(repair.remaining_faces);
    }
  }
  report.faces_after = static_cast<Index>(fewest.size());
  report.remaining_faces = std::move(fewest);
  return report;
}

}  // namespace shrinkwrap
