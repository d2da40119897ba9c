#include "parametric_surface/control_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/parallel.h"
#include "mesh/quadric.h"
#include "mesh/vertex_blocks.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
// Pull of every vertex towards its own place, against the quadrics of its faces: keeps flat areas
// well shaped.
constexpr double kRegularisation = 6e-3;
// Sweeps in vertex order go down to this multiple of the target; exact greedy order does the rest.
constexpr double kSweepSurplus = 1.25;
// Share of the edges that one sweep may contract, by cost.
constexpr double kSweepQuantile = 0.3;
constexpr int kMaxSweeps = 40;
constexpr Index kProbeStride = 32;  // one edge of so many is asked for its cost

std::vector<Quadric> vertex_quadrics(const SurfaceMesh& mesh, bool area_weighted,
                                     Progress& progress) {
  const Index faces = mesh.face_slots();
  const double area = parallel_sum(faces, kGrain, progress, 0.0, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index f = begin; f < end; ++f) sum += mesh.area_vector(f).norm();
    return sum;
  });
  const double pull =
      kRegularisation * (area_weighted ? area / (3.0 * std::max<Index>(faces, 1)) : 1.0);
  std::vector<Quadric> quadric(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    mesh.for_each_outgoing(v, [&](Index h) {
      Vec3 normal = mesh.area_vector(SurfaceMesh::face(h));
      const double weight = normal.norm();
      if (weight <= 0.0) return;
      normal /= weight;
      quadric[v].add_plane(normal, -normal.dot(mesh.position[v]), area_weighted ? weight : 1.0);
    });
    quadric[v].add_point(mesh.position[v], pull);
  });
  return quadric;
}

struct Candidate {
  float cost;
  Index from, to;
  Index version;  // of both ends together when the cost was computed
};
// Heap order: cheapest first, ties by vertices.
bool is_dearer(const Candidate& a, const Candidate& b) {
  if (a.cost != b.cost) return a.cost > b.cost;
  return a.from != b.from ? a.from > b.from : a.to > b.to;
}

class Contraction {
 public:
  Contraction(SurfaceMesh& mesh, const ControlMeshOptions& options, Index target,
              Progress& progress)
      : mesh_(mesh),
        target_(target),
        guard_(options.normal_guard),
        progress_(progress),
        before_(mesh.vertex_count()),
        quadric_(vertex_quadrics(mesh, options.area_weighted, progress)) {}

  // Far from the target the exact order hardly matters: contract, vertex by vertex, every cheapest
  // edge that is among the cheaper ones of the whole mesh.
  void sweep() {
    const Index stop = static_cast<Index>(std::ceil(kSweepSurplus * target_));
    if (mesh_.vertex_count() <= stop) return;
    progress_.set_range(0.0, 0.1);
    const VertexBlocks blocks(mesh_.position, progress_);
    for (int sweep = 0; sweep < kMaxSweeps && mesh_.vertex_count() > stop; ++sweep) {
      const Index before = mesh_.vertex_count();
      const double part_done = static_cast<double>(before_ - before) / (before_ - target_);
      progress_.set_range(0.1 + 0.7 * part_done, 0.8);
      sweep_once(blocks, before - stop);
      if (before - mesh_.vertex_count() < before / 200) break;
    }
  }

  void contract_in_order() {
    std::vector<Index> version(mesh_.position.size(), 0);
    const auto candidate = [&](Index h) {
      Vec3 p;
      const double cost = contraction_cost(h, p);
      const Index a = mesh_.origin(h), b = mesh_.target(h);
      return Candidate{static_cast<float>(cost), a, b, version[a] + version[b]};
    };
    std::vector<Candidate> heap =
        parallel_collect<Candidate>(mesh_.halfedge_slots(), kGrain, progress_,
                                    [&](Index begin, Index end, std::vector<Candidate>& some) {
                                      for (Index h = begin; h < end; ++h)
                                        if (mesh_.origin(h) != kNone && h < mesh_.twin(h))
                                          some.push_back(candidate(h));
                                    });
    std::make_heap(heap.begin(), heap.end(), is_dearer);
    Index steps = 0;
    const Index begin = mesh_.vertex_count();
    progress_.set_range(0.8, 1.0);
    while (mesh_.vertex_count() > target_ && !heap.empty()) {
      if (++steps % 1024 == 0)
        progress_.update(static_cast<double>(begin - mesh_.vertex_count()) / (begin - target_));
      std::pop_heap(heap.begin(), heap.end(), is_dearer);
      const Candidate top = heap.back();
      heap.pop_back();
      if (mesh_.is_removed_vertex(top.from) || mesh_.is_removed_vertex(top.to)) continue;
      if (top.version != version[top.from] + version[top.to]) continue;
      const Index h = mesh_.find_halfedge(top.from, top.to);
      if (h == kNone) continue;
      Vec3 place;
      contraction_cost(h, place);
      if (!contract(h, place)) continue;
      version[top.to] += version[top.from] + 1;
      mesh_.for_each_outgoing(top.to, [&](Index g) {
        heap.push_back(candidate(g));
        std::push_heap(heap.begin(), heap.end(), is_dearer);
      });
    }
  }

 private:
  double contraction_cost(Index h, Vec3& place) const {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    Quadric sum = quadric_[a];
    sum += quadric_[b];
    place = sum.best_position(mesh_.position[a], mesh_.position[b]);
    return sum.cost(place);
  }

  // The share `quantile` of the edges costs less than this.
  double cost_quantile(double quantile) const {
    std::vector<float> costs = parallel_collect<float>(
        mesh_.halfedge_slots(), kGrain, progress_,
        [&](Index begin, Index end, std::vector<float>& some) {
          Index seen = 0;
          for (Index h = begin; h < end; ++h) {
            if (mesh_.origin(h) == kNone || h > mesh_.twin(h) || seen++ % kProbeStride != 0)
              continue;
            Vec3 place;
            some.push_back(static_cast<float>(contraction_cost(h, place)));
          }
        });
    if (costs.empty()) return 0.0;
    const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(
                                            quantile * static_cast<double>(costs.size() - 1));
    std::nth_element(costs.begin(), middle, costs.end());
    return *middle;
  }

  // Contracts at most about `surplus` edges: every block its share.
  void sweep_once(const VertexBlocks& blocks, Index surplus) {
    const Index count = mesh_.vertex_count();
    const double share = static_cast<double>(surplus) / count;
    const double threshold = cost_quantile(std::min(kSweepQuantile, share));
    const auto seed = [&](Index v, std::vector<Index>& vertices) {
      if (!mesh_.is_removed_vertex(v)) vertices.push_back(v);
    };
    const auto anchor = [](Index v) { return v; };
    const auto work = [&](const BlockOwner& owner, std::vector<Index>& vertices) {
      const auto owns_ring = [&](Index v) {
        bool owns = owner.owns(v);
        if (owns) mesh_.for_each_outgoing(v, [&](Index h) { owns &= owner.owns(mesh_.target(h)); });
        return owns;
      };
      Index left = static_cast<Index>(share * static_cast<double>(vertices.size()));
      std::vector<Index> deferred;
      Index seen = 0;
      for (const Index v : vertices) {
        if (left == 0) break;
        if (owner.is_last() && ++seen % 1024 == 0) progress_.update(1.0);
        if (mesh_.is_removed_vertex(v)) continue;
        if (!owns_ring(v)) {
          deferred.push_back(v);
          continue;
        }
        Index cheapest = kNone;
        double least = threshold;
        Vec3 place = Vec3::Zero();
        mesh_.for_each_outgoing(v, [&](Index h) {
          if (mesh_.target(h) < v) return;  // every edge from its lower end only
          Vec3 p;
          const double cost = contraction_cost(h, p);
          if (cost > least) return;
          least = cost;
          cheapest = h;
          place = p;
        });
        if (cheapest == kNone) continue;
        if (!owns_ring(mesh_.target(cheapest)))
          deferred.push_back(v);
        else if (contract(cheapest, place))
          --left;
      }
      vertices.swap(deferred);
    };
    run_in_blocks(blocks, progress_, seed, anchor, work);
  }

  // True if moving v to `place` turns one of its faces, other than those on the edge to `partner`,
  // too far.
  bool turns_a_face(Index v, Index partner, const Vec3& place) const {
    bool turns = false;
    mesh_.for_each_outgoing(v, [&](Index h) {
      const Index i = mesh_.target(h), j = mesh_.opposite(h);
      if (turns || i == partner || j == partner) return;
      const Vec3 &p = mesh_.position[i], &q = mesh_.position[j], &old = mesh_.position[v];
      const Vec3 before = (p - old).cross(q - old), after = (p - place).cross(q - place);
      const double along = before.dot(after);
      turns = along <= 0.0 ||
              along * along <= guard_ * guard_ * before.squaredNorm() * after.squaredNorm();
    });
    return turns;
  }

  bool contract(Index h, const Vec3& place) {
    const Index a = mesh_.origin(h), b = mesh_.target(h);
    if (!mesh_.is_collapse_legal(h)) return false;
    if (turns_a_face(a, b, place) || turns_a_face(b, a, place)) return false;
    mesh_.collapse(h);
    mesh_.position[b] = place;
    quadric_[b] += quadric_[a];
    return true;
  }

  SurfaceMesh& mesh_;
  Index target_;
  double guard_;
  Progress& progress_;
  Index before_;
  std::vector<Quadric> quadric_;
};

}  // namespace

Index control_vertices_for(Index samples, Index euler_characteristic, Index components) {
  const double vertices = (static_cast<double>(samples) + 15.0 * euler_characteristic) / 16.0;
  return std::max(static_cast<Index>(std::lround(vertices)), 4 * components);
}

ControlMesh make_control_mesh(SurfaceMesh mesh, Index samples, const ControlMeshOptions& options,
                              Progress& progress) {
  progress.begin(Stage::control_mesh);
  progress.set_range(0.0, 0.0);  // what comes before the contractions is short
  ControlMesh result;
  result.report.vertices_before = mesh.vertex_count();
  result.report.target_vertices =
      options.target_vertices > 0
          ? options.target_vertices
          : control_vertices_for(samples, mesh.euler_characteristic(),
                                 connected_components(mesh, progress).count);
  if (mesh.vertex_count() > result.report.target_vertices) {
    Contraction contraction(mesh, options, result.report.target_vertices, progress);
    contraction.sweep();
    contraction.contract_in_order();
    mesh.compact(progress);
  }
  result.report.vertices = mesh.vertex_count();
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace shrinkwrap
