#include "initial_mesh/bounding_box_start.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/parallel.h"
#include "geometry/bounding_box.h"
#include "mesh/split_in_four.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr Index kBoxVertices = 8;
constexpr int kMaxLevels = 12;  // 100 million vertices, and few enough half-edges for an Index

// Eq. 4-5: towards the nearest sample.
void project(SurfaceMesh& mesh, const PointCloud& cloud, double xi, Progress& progress) {
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    Vec3& p = mesh.position[v];
    p += xi * (cloud.position[cloud.search.nearest(p).index] - p);
  });
}

// Eq. 6-8: towards the centroid of the neighbours, but only along the surface. `moved` is scratch.
void relax(SurfaceMesh& mesh, double eta, std::vector<Vec3>& moved, Progress& progress) {
  moved.resize(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    const Vec3& p = mesh.position[v];
    Vec3 laplacian = Vec3::Zero();
    Index valence = 0;
    mesh.for_each_outgoing(v, [&](Index h) {
      laplacian += mesh.position[mesh.target(h)] - p;
      ++valence;
    });
    laplacian /= static_cast<double>(valence);
    const Vec3 normal = mesh.vertex_normal(v);
    moved[v] = p + eta * (laplacian - laplacian.dot(normal) * normal);
  });
  mesh.position.swap(moved);
}

}  // namespace

std::uint64_t vertices_after(int levels) {
  Index vertices = kBoxVertices;
  for (int level = 0; level < std::min(levels, kMaxLevels); ++level)
    vertices = subdivided_vertices(vertices);
  return static_cast<std::uint64_t>(vertices);
}

int levels_for(Index samples) {
  int levels = 0;
  for (Index vertices = kBoxVertices;
       levels < kMaxLevels && subdivided_vertices(vertices) <= samples / 4; ++levels)
    vertices = subdivided_vertices(vertices);
  return levels;
}

// The box lies a spacing off the samples, so that it has a volume even if they hardly do.
SurfaceMesh box_around(const PointCloud& cloud) {
  const Box box = bounding_box(cloud.position);
  const double least_margin = 1e-6 * (box.high - box.low).maxCoeff();
  const Vec3 margin = Vec3::Constant(std::max(cloud.spacing, least_margin));
  return box_mesh(box.low - margin, box.high + margin);
}

SurfaceMesh box_mesh(const Vec3& low, const Vec3& high) {
  std::vector<Vec3> corner;
  for (int i = 0; i < kBoxVertices; ++i)
    corner.push_back(
        {i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  return SurfaceMesh::from_triangles(std::move(corner), {{0, 2, 1},
                                                         {1, 2, 3},
                                                         {4, 5, 6},
                                                         {5, 7, 6},
                                                         {0, 1, 4},
                                                         {1, 5, 4},
                                                         {2, 6, 3},
                                                         {3, 6, 7},
                                                         {0, 4, 2},
                                                         {2, 4, 6},
                                                         {1, 3, 5},
                                                         {3, 7, 5}});
}

SurfaceMesh midpoint_subdivide(const SurfaceMesh& mesh, Progress& progress) {
  const std::vector<Index> middle = edge_vertices(mesh);
  std::vector<Vec3> position = mesh.position;
  position.resize(position.size() + middle.size() / 2);
  for (Index h = 0; h < mesh.halfedge_slots(); ++h)
    position[middle[h]] = 0.5 * (mesh.position[mesh.origin(h)] + mesh.position[mesh.target(h)]);
  return split_in_four(mesh, middle, std::move(position), progress);
}

InitialMesh shrink_bounding_box(const PointCloud& cloud, const InitialMeshOptions& options,
                                Progress& progress) {
  if (options.levels > kMaxLevels)
    throw InvalidInput("the bounding box can be subdivided at most " + std::to_string(kMaxLevels) +
                       " times, not " + std::to_string(options.levels) +
                       ": choose a lower level, or -1 for the one that suits the samples");
  const int levels = options.levels >= 0 ? options.levels : levels_for(cloud.size());
  InitialMesh result;
  SurfaceMesh& mesh = result.mesh;
  mesh = box_around(cloud);
  std::vector<Vec3> scratch;
  for (int level = 1; level <= levels; ++level) {
    // Each level is four times the work of the one before.
    const double begin = std::ldexp(1.0, 2 * (level - 1 - levels));
    const double share = (4.0 * begin - begin) / std::max(options.iterations_per_level, 1);
    mesh = midpoint_subdivide(mesh, progress);
    for (int i = 0; i < options.iterations_per_level; ++i) {
      progress.set_range(begin + share * i, begin + share * (i + 0.8));
      project(mesh, cloud, options.projection, progress);
      progress.set_range(begin + share * (i + 0.8), begin + share * (i + 1));
      relax(mesh, options.box_relaxation, scratch, progress);
    }
  }
  mesh.compact();
  result.report.components = 1;
  result.report.levels = levels;
  return result;
}

}  // namespace shrinkwrap
