#include "parametric_surface/parametric_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "common/parallel.h"
#include "mesh/face_tree.h"
#include "mesh/one_ring.h"
#include "mesh/split_in_four.h"
#include "samples/tangent_target.h"

namespace shrinkwrap {
namespace {

constexpr Index kProbeGrain = 256, kLeastProbes = 20000, kMostStride = 16;
constexpr Index kGrain = 1 << 11;
constexpr Index kTableSize = 64;
// Tangential weight of a vertex that no sample holds.
constexpr double kMembraneRelaxation = 0.3;

double limit_weight_of(double beta, Index valence) {
  return 1.0 / (3.0 / (8.0 * beta) + valence);
}

// eq. 13 for the valences that occur, so that the inner loop has no cosine.
std::array<double, kTableSize> limit_weights() {
  std::array<double, kTableSize> table{};
  for (Index valence = 3; valence < kTableSize; ++valence)
    table[valence] = limit_weight_of(loop_beta(valence), valence);
  return table;
}

struct Distances {
  double sum = 0.0, greatest = 0.0;
  Index held = 0, membrane = 0;

  void add(double distance) {
    sum += distance;
    greatest = std::max(greatest, distance);
    ++held;
  }
  Distances& operator+=(const Distances& other) {
    sum += other.sum;
    greatest = std::max(greatest, other.greatest);
    held += other.held;
    membrane += other.membrane;
    return *this;
  }
};

void tell(const Distances& distances, double spacing, ParametricSurfaceReport& report) {
  report.membrane_vertices = distances.membrane;
  report.mean_distance = distances.held > 0 ? distances.sum / distances.held / spacing : 0.0;
  report.max_distance = distances.greatest / spacing;
}

class Fitting {
 public:
  Fitting(const PointCloud& cloud, const ParametricSurfaceOptions& options)
      : cloud_(cloud), options_(options), tangent_(cloud), weight_(limit_weights()) {}

  // One Jacobi iteration of eq. 14; returns how far the limit positions were from their targets
  // before it.
  Distances iterate(SurfaceMesh& mesh, std::vector<Index>& hint, Progress& progress) const {
    const Index vertices = mesh.vertex_slots();
    hint.resize(mesh.position.size(), kNone);
    std::vector<Vec3> moved(mesh.position.size());
    const Distances distances =
        parallel_sum(vertices, kGrain, progress, Distances(), [&](Index begin, Index end) {
          Distances block;
          for (Index v = begin; v < end; ++v) moved[v] = move(mesh, v, hint[v], block);
          return block;
        });
    mesh.position = std::move(moved);
    return distances;
  }

  // How far the vertices are from their targets.
  Distances measure(const SurfaceMesh& mesh, Progress& progress) const {
    return parallel_sum(mesh.vertex_slots(), kGrain, progress, Distances(),
                        [&](Index begin, Index end) {
                          Distances block;
                          for (Index v = begin; v < end; ++v)
                            if (const auto target = target_of(mesh, v))
                              block.add((*target - mesh.position[v]).norm());
                            else
                              ++block.membrane;
                          return block;
                        });
  }

  std::vector<char> mark_membranes(const SurfaceMesh& mesh, Progress& progress) const {
    std::vector<char> is_membrane(mesh.position.size());
    parallel_for_each(mesh.vertex_slots(), kGrain, progress,
                      [&](Index v) { is_membrane[v] = !target_of(mesh, v); });
    return is_membrane;
  }

  Vec3 limit_position(const SurfaceMesh& mesh, Index v, const OneRing& ring) const {
    const double weight =
        ring.valence < kTableSize ? weight_[ring.valence] : loop_limit_weight(ring.valence);
    return mesh.position[v] + weight * ring.difference_sum;
  }

  void move_to_limit(SurfaceMesh& mesh, Progress& progress) const {
    std::vector<Vec3> limit(mesh.position.size());
    parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
      limit[v] = limit_position(mesh, v, gather_one_ring(mesh, v));
    });
    mesh.position = std::move(limit);
  }

 private:
  Vec3 move(const SurfaceMesh& mesh, Index v, Index& hint, Distances& distances) const {
    const OneRing ring = gather_one_ring(mesh, v);
    const Vec3 limit = limit_position(mesh, v, ring);
    const Vec3 laplacian = ring.laplacian();
    const Vec3 tangential = laplacian - laplacian.dot(ring.normal) * ring.normal;
    const std::optional<Vec3> target = target_of(limit, ring, mesh.position[v] + laplacian, hint);
    if (!target) {
      ++distances.membrane;
      return mesh.position[v] + kMembraneRelaxation * tangential;
    }
    const Vec3 attraction = *target - limit;
    distances.add(attraction.norm());
    return mesh.position[v] + options_.attraction * attraction + options_.relaxation * tangential;
  }

  // Of a vertex where it is. None in a membrane.
  std::optional<Vec3> target_of(const SurfaceMesh& mesh, Index v) const {
    Index hint = kNone;  // a walk from elsewhere may end at another side of the surface
    const OneRing ring = gather_one_ring(mesh, v);
    const Vec3& position = mesh.position[v];
    return target_of(position, ring, position + ring.laplacian(), hint);
  }

  std::optional<Vec3> target_of(const Vec3& query, const OneRing& ring, const Vec3& centroid,
                                Index& hint) const {
    if (options_.target == ParametricSurfaceOptions::Target::nearest_sample)
      return nearest_sample(query);
    const TangentTarget::Target found = tangent_.find(query, ring.normal, centroid, hint);
    hint = found.nearest;
    if (found.is_membrane) return std::nullopt;
    return found.point;
  }

  Vec3 nearest_sample(const Vec3& query) const {
    return cloud_.position[cloud_.search.nearest(query).index];
  }

  const PointCloud& cloud_;
  const ParametricSurfaceOptions& options_;
  TangentTarget tangent_;
  std::array<double, kTableSize> weight_;
};

// Part of the samples from which the surface is farther than `reach_of` them. Some stand for all.
template <class ReachOf>
double part_out_of_reach(const SurfaceMesh& mesh, const PointCloud& cloud, const ReachOf& reach_of,
                         Progress& progress) {
  const FaceTree tree(mesh, progress);
  const Index stride = std::clamp<Index>(cloud.size() / kLeastProbes, 1, kMostStride);
  const Index probes = (cloud.size() - 1) / stride + 1;
  const Index beyond =
      parallel_sum(probes, kProbeGrain, progress, Index{0}, [&](Index begin, Index end) {
        Index count = 0, hint = kNone;
        for (Index i = begin; i < end; ++i) {
          const double reach = reach_of(i * stride);
          const auto hit = tree.nearest(cloud.position[i * stride], reach * reach, hint,
                                        [](Index) { return true; });
          if (hit.face == kNone) ++count;
          hint = hit.face;
        }
        return count;
      });
  return static_cast<double>(beyond) / probes;
}

// How many vertices there are to be, x samples, for a surface to be fine enough.
constexpr double kEnoughVertices = 0.75, kEnoughForOneMore = 0.5;
// A sample is no farther from the surface than this, x noise, because of that.
constexpr double kMostDeviations = 3.0;
// Part of the samples that may be out of reach of a surface that is fine enough.
constexpr double kMostBeyond = 0.001;

}  // namespace

double loop_beta(Index valence) {
  if (valence == 3) return 3.0 / 16.0;
  const double c = 3.0 / 8.0 + std::cos(2.0 * kPi / valence) / 4.0;
  return (5.0 / 8.0 - c * c) / valence;
}

double loop_limit_weight(Index valence) {
  return limit_weight_of(loop_beta(valence), valence);
}

SurfaceMesh loop_subdivide(const SurfaceMesh& mesh) {
  Progress silent;
  return loop_subdivide(mesh, silent);
}

SurfaceMesh loop_subdivide(const SurfaceMesh& mesh, Progress& progress) {
  const Index vertices = mesh.vertex_slots(), halfedges = mesh.halfedge_slots();
  const std::vector<Index> edge_vertex = edge_vertices(mesh);
  progress.update(0.0);
  std::vector<Vec3> position(static_cast<std::size_t>(vertices) + halfedges / 2);
  parallel_for_each(vertices, kGrain, progress, [&](Index v) {
    Vec3 sum = Vec3::Zero();
    Index valence = 0;
    mesh.for_each_outgoing(v, [&](Index h) {
      sum += mesh.position[mesh.target(h)];
      ++valence;
    });
    const double beta = loop_beta(valence);
    position[v] = (1.0 - valence * beta) * mesh.position[v] + beta * sum;
  });
  parallel_for_each(halfedges, kGrain, progress, [&](Index h) {
    const Index o = mesh.twin(h);
    if (h > o) return;
    position[edge_vertex[h]] =
        0.375 * (mesh.position[mesh.origin(h)] + mesh.position[mesh.origin(o)]) +
        0.125 * (mesh.position[mesh.opposite(h)] + mesh.position[mesh.opposite(o)]);
  });
  return split_in_four(mesh, edge_vertex, std::move(position), progress);
}

ParametricSurface make_parametric_surface(SurfaceMesh control, const PointCloud& cloud,
                                          const ParametricSurfaceOptions& options,
                                          Progress& progress) {
  progress.begin(Stage::parametric_surface);
  ParametricSurface result;
  const Fitting fitting(cloud, options);
  SurfaceMesh mesh = std::move(control);
  Distances distances;
  const auto is_coarse = [&](double vertices, double enough) {
    return vertices < std::floor(enough * cloud.size());
  };
  const auto goes_on = [&](int level, double vertices) {
    return level <= options.subdivisions &&
           is_coarse(vertices, level < options.subdivisions ? kEnoughVertices : kEnoughForOneMore);
  };
  for (int level = 0; goes_on(level, mesh.vertex_count()); ++level) {
    const double edges = 1.5 * mesh.face_count();
    const bool is_last = !goes_on(level + 1, mesh.vertex_count() + edges);
    progress.set_range(0.1 * level, 0.1 * level);
    if (is_last && level > 0 && options.fine_enough > 0.0 &&
        cloud.size() >= options.fine_enough_from &&
        part_out_of_reach(
            mesh, cloud, [&](Index) { return options.fine_enough * cloud.spacing; }, progress) <=
            kMostBeyond)
      break;
    mesh = loop_subdivide(mesh, progress);
    mesh.compact(progress);
    ++result.report.subdivisions;
    const int iterations = is_last ? (options.iterations + 1) / 2 : options.iterations;
    std::vector<Index> hint;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      const double begin = is_last ? 0.3 : 0.1 * level, width = is_last ? 0.7 : 0.1;
      progress.set_range(begin + width * iteration / iterations,
                         begin + width * (iteration + 1) / iterations);
      distances = fitting.iterate(mesh, hint, progress);
    }
  }
  if (result.report.subdivisions > 0) fitting.move_to_limit(mesh, progress);
  if (result.report.subdivisions == 0 || options.iterations == 0)
    distances = fitting.measure(mesh, progress);
  result.report.vertices = mesh.vertex_count();
  tell(distances, cloud.spacing, result.report);
  result.mesh = std::move(mesh);
  return result;
}

double part_of_samples_far(const SurfaceMesh& surface, const PointCloud& cloud, double noise,
                           Progress& progress) {
  const double deviations = cloud.is_denoised() ? 0.0 : kMostDeviations;
  const auto reach = [&](Index i) {
    return cloud.local_spacing[i] + deviations * cloud.noise_at(i, noise) * cloud.spacing_at(i);
  };
  return part_out_of_reach(surface, cloud, reach, progress);
}

std::vector<char> mark_membranes(const SurfaceMesh& surface, const PointCloud& cloud,
                                 const ParametricSurfaceOptions& options, Progress& progress) {
  return Fitting(cloud, options).mark_membranes(surface, progress);
}

void measure_distances(ParametricSurface& surface, const PointCloud& cloud,
                       const ParametricSurfaceOptions& options, Progress& progress) {
  const Fitting fitting(cloud, options);
  tell(fitting.measure(surface.mesh, progress), cloud.spacing, surface.report);
}

}  // namespace shrinkwrap
