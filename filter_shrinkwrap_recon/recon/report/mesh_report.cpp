#include "report/mesh_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "common/buckets.h"
#include "common/disjoint_sets.h"
#include "common/parallel.h"
#include "common/shared_sets.h"
#include "common/sort_unique.h"
#include "geometry/coordinate_matches.h"
#include "mesh/bodies.h"
#include "mesh/self_intersection.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr Index kUpdateInterval = 1 << 16;

bool is_degenerate(const Triangle& t, Index vertices) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  return std::any_of(t.begin(), t.end(), [&](Index v) { return v < 0 || v >= vertices; });
}

// What the faces use of a mesh: vertices numbered in the order in which faces come to them, so that
// neighbours are near each other in memory whatever the order of the vertices was.
struct UsedMesh {
  std::vector<Vec3> position;
  std::vector<Triangle> triangle;  // but for degenerate ones
  Index degenerate_faces = 0;
};

UsedMesh find_used(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                   Progress& progress) {
  UsedMesh used;
  used.position.reserve(positions.size());
  used.triangle.reserve(triangles.size());
  std::vector<Index> new_index(positions.size(), kNone);
  const Index vertices = static_cast<Index>(positions.size());
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    if (f % kUpdateInterval == 0) progress.update(static_cast<double>(f) / triangles.size());
    Triangle t = triangles[f];
    if (is_degenerate(t, vertices)) {
      ++used.degenerate_faces;
      continue;
    }
    for (Index& v : t) {
      if (new_index[v] == kNone) {
        new_index[v] = static_cast<Index>(used.position.size());
        used.position.push_back(positions[v]);
      }
      v = new_index[v];
    }
    used.triangle.push_back(t);
  }
  return used;
}

// The corners (3 face + place in the face) at each vertex.
Buckets find_incidence(Index vertices, const std::vector<Triangle>& triangles, Progress& progress) {
  return sort_into_buckets(3 * static_cast<Index>(triangles.size()), vertices, progress,
                           [&](Index corner) { return triangles[corner / 3][corner % 3]; });
}

struct BorderEdge {
  Index a, b;
  Index face;
};

struct EdgeCounts {
  Index edges = 0;
  Index nonmanifold_edges = 0, nonmanifold_vertices = 0, misoriented_edges = 0;
  std::vector<BorderEdge> border;

  void add(const EdgeCounts& other) {
    edges += other.edges;
    nonmanifold_edges += other.nonmanifold_edges;
    nonmanifold_vertices += other.nonmanifold_vertices;
    misoriented_edges += other.misoriented_edges;
    border.insert(border.end(), other.border.begin(), other.border.end());
  }
};

// Looks at the faces around one vertex after the other.
class StarWalker {
 public:
  StarWalker(const std::vector<Triangle>& triangles, const Buckets& incidence,
             std::vector<Index>& next_face)
      : triangles_(triangles), incidence_(incidence), next_face_(next_face) {}

  /// Counts what the faces of the vertex are to each other, and its edges to higher vertices. For
  /// these, chains the faces at the edge: `next_face` of a half-edge is another face there, or
  /// kNone.
  void visit(Index v, EdgeCounts& counts) {
    const Index first = incidence_.begin[v];
    const Index faces = incidence_.begin[v + 1] - first;
    gather_spokes(first, faces);
    together_.reset(faces);
    Index fans = faces;
    bool edges_are_manifold = true;
    for (std::size_t i = 0; i < spokes_.size();) {
      std::size_t end = i + 1;
      while (end < spokes_.size() && spokes_[end].other == spokes_[i].other) ++end;
      for (std::size_t j = i + 1; j < end; ++j)
        fans -= together_.unite(spokes_[i].place, spokes_[j].place) ? 1 : 0;
      edges_are_manifold &= end - i <= 2;
      if (v < spokes_[i].other) count_edge(v, i, end, counts);
      i = end;
    }
    if (fans > 1 || !edges_are_manifold) ++counts.nonmanifold_vertices;
  }

 private:
  // A face seen along one of its two edges at the vertex.
  struct Spoke {
    Index other;     // vertex at the far end
    Index place;     // of the face among those around the vertex
    Index halfedge;  // of the face along the edge
    bool outgoing;
  };

  void gather_spokes(Index first, Index faces) {
    spokes_.clear();
    for (Index place = 0; place < faces; ++place) {
      const Index corner = incidence_.item[first + place];
      const Index f = SurfaceMesh::face(corner);
      const Index next = SurfaceMesh::next(corner), previous = SurfaceMesh::prev(corner);
      spokes_.push_back({triangles_[f][next - 3 * f], place, corner, true});
      spokes_.push_back({triangles_[f][previous - 3 * f], place, previous, false});
    }
    const auto before = [](const Spoke& a, const Spoke& b) {
      return a.other != b.other ? a.other < b.other : a.halfedge < b.halfedge;
    };
    std::sort(spokes_.begin(), spokes_.end(), before);
  }

  void count_edge(Index v, std::size_t begin, std::size_t end, EdgeCounts& counts) {
    const std::size_t faces = end - begin;
    ++counts.edges;
    if (faces == 1)
      counts.border.push_back(
          {v, spokes_[begin].other, SurfaceMesh::face(spokes_[begin].halfedge)});
    if (faces > 2) ++counts.nonmanifold_edges;
    if (faces == 2 && spokes_[begin].outgoing == spokes_[begin + 1].outgoing)
      ++counts.misoriented_edges;
    for (std::size_t i = begin; i + 1 < end; ++i)
      next_face_[spokes_[i].halfedge] = SurfaceMesh::face(spokes_[i + 1].halfedge);
  }

  const std::vector<Triangle>& triangles_;
  const Buckets& incidence_;
  std::vector<Index>& next_face_;
  std::vector<Spoke> spokes_;
  DisjointSets together_{0};
};

EdgeCounts count_edges(const std::vector<Triangle>& triangles, const Buckets& incidence,
                       std::vector<Index>& next_face, Progress& progress) {
  const Index vertices = static_cast<Index>(incidence.begin.size()) - 1;
  std::vector<EdgeCounts> partial(block_count(vertices, kGrain));
  parallel_blocks(vertices, kGrain, progress, [&](Index block, Index begin, Index end) {
    StarWalker walker(triangles, incidence, next_face);
    for (Index v = begin; v < end; ++v) walker.visit(v, partial[block]);
  });
  EdgeCounts counts;
  for (const EdgeCounts& part : partial) counts.add(part);
  return counts;
}

// Sets of border edges that hang together: for a manifold, its loops.
Index count_border_loops(const std::vector<BorderEdge>& border) {
  std::vector<Index> vertex;
  vertex.reserve(2 * border.size());
  for (const BorderEdge& edge : border) {
    vertex.push_back(edge.a);
    vertex.push_back(edge.b);
  }
  sort_unique(vertex);
  const auto number_of = [&](Index v) {
    return static_cast<Index>(std::lower_bound(vertex.begin(), vertex.end(), v) - vertex.begin());
  };
  Index loops = static_cast<Index>(vertex.size());
  DisjointSets sets(loops);
  for (const BorderEdge& edge : border)
    loops -= sets.unite(number_of(edge.a), number_of(edge.b)) ? 1 : 0;
  return loops;
}

struct Components {
  std::vector<Index> of_face;  // lowest face of the component
  Index count = 0;
};

Components find_components(const std::vector<Index>& next_face, Progress& progress) {
  const Index faces = static_cast<Index>(next_face.size() / 3);
  SharedSets sets(faces, progress);
  parallel_for_each(static_cast<Index>(next_face.size()), kGrain, progress, [&](Index h) {
    if (next_face[h] != kNone) sets.unite(h / 3, next_face[h]);
  });
  Components components;
  components.of_face.resize(faces);
  parallel_for_each(faces, kGrain, progress,
                    [&](Index f) { components.of_face[f] = sets.find(f); });
  components.count = parallel_sum<Index>(faces, kGrain, progress, 0, [&](Index begin, Index end) {
    Index lowest = 0;
    for (Index f = begin; f < end; ++f) lowest += components.of_face[f] == f ? 1 : 0;
    return lowest;
  });
  return components;
}

// A power of two by which the coordinates become so moderate that their products neither vanish nor
// overflow; they are rounded as without it, but for those that are 1e300 times smaller.
int moderating_exponent(const std::vector<Vec3>& positions) {
  constexpr int kMost = 1000;
  double greatest = 0.0;
  for (const Vec3& p : positions)
    if (p.allFinite()) greatest = std::max(greatest, p.cwiseAbs().maxCoeff());
  return greatest > 0.0 ? std::clamp(-std::ilogb(greatest), -kMost, kMost) : 0;
}

// Of a closed mesh.
void measure_volume(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                    const Components& components, MeshReport& report, Progress& progress) {
  const int exponent = moderating_exponent(positions);
  // Components are named by their lowest face: here they are numbered.
  std::vector<Index> component(components.of_face.size());
  Index count = 0;
  for (std::size_t f = 0; f < component.size(); ++f) {
    const auto lowest = static_cast<std::size_t>(components.of_face[f]);
    component[f] = lowest == f ? count++ : component[lowest];
  }
  const ComponentVolumes volumes =
      signed_volumes(positions, triangles, component, count, std::ldexp(1.0, exponent), progress);
  const double sum = std::accumulate(volumes.volume.begin(), volumes.volume.end(), 0.0);
  report.volume = std::ldexp(sum, -3 * exponent);
  report.volume_is_positive = sum > 0.0;
  report.components_flat = volumes.flat;
  if (!report.manifold()) return;
  const ComponentSides sides =
      find_sides(positions, triangles, component, volumes.volume, progress);
  report.cavities = static_cast<Index>(sides.cavities.size());
  report.components_inside_out = static_cast<Index>(sides.inside_out.size());
}

// Everything but the samples and self-intersections.
void measure_topology(const UsedMesh& mesh, MeshReport& report, Progress& progress) {
  std::vector<Index> next_face(3 * mesh.triangle.size(), kNone);
  EdgeCounts counts;
  report.vertices = static_cast<Index>(mesh.position.size());
  {
    progress.set_range(0.1, 0.15);
    const Buckets incidence = find_incidence(report.vertices, mesh.triangle, progress);
    progress.set_range(0.15, 0.25);
    counts = count_edges(mesh.triangle, incidence, next_face, progress);
  }
  report.edges = counts.edges;
  report.border_edges = static_cast<Index>(counts.border.size());
  report.border_loops = count_border_loops(counts.border);
  report.nonmanifold_edges = counts.nonmanifold_edges;
  report.nonmanifold_vertices = counts.nonmanifold_vertices;
  report.misoriented_edges = counts.misoriented_edges;

  progress.set_range(0.25, 0.3);
  const Components components = find_components(next_face, progress);
  report.components = components.count;
  if (report.manifold()) {
    // Every opening gets a cap: one more face.
    const Index euler = report.vertices - report.edges + report.faces + report.border_loops;
    report.genus = report.components - euler / 2;
  }
  progress.set_range(0.3, 0.35);
  if (report.closed()) measure_volume(mesh.position, mesh.triangle, components, report, progress);
}

std::string counted(Index count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

// Collects what is wrong, for one line.
class Complaints {
 public:
  void add(Index count, const char* singular, const char* plural) {
    if (count > 0) text_ += (text_.empty() ? "" : ", ") + counted(count, singular, plural);
  }
  std::string or_else(const char* none) const { return text_.empty() ? none : text_; }

 private:
  std::string text_;
};

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

MeshReport measure_mesh(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                        const std::vector<Vec3>& samples, const MeshReportOptions& options,
                        Progress& progress) {
  MeshReport report;
  progress.set_range(0.0, 0.1);
  const UsedMesh mesh = find_used(positions, triangles, progress);
  report.faces = static_cast<Index>(triangles.size());
  report.degenerate_faces = mesh.degenerate_faces;
  measure_topology(mesh, report, progress);
  progress.set_range(0.35, 0.4);
  const CoordinateMatches matches = match_coordinates(samples, mesh.position, progress);
  report.samples = matches.samples;
  report.samples_matched = matches.matched;
  report.samples_missing = matches.missing;
  report.samples_matched_twice = matches.matched_twice;
  report.vertices_extra = matches.extra;
  progress.set_range(0.4, 1.0);
  if (options.count_self_intersections)
    report.self_intersecting_faces =
        static_cast<Index>(self_intersecting_faces(mesh.position, mesh.triangle, progress).size());
  progress.set_range(0.0, 1.0);
  return report;
}

std::vector<std::string> describe(const MeshReport& report) {
  std::vector<std::string> lines;
  lines.push_back("Mesh: " + counted(report.vertices, "vertex", "vertices") + ", " +
                  counted(report.edges, "edge", "edges") + ", " +
                  counted(report.faces, "face", "faces") + ", " +
                  counted(report.components, "component", "components"));

  Complaints surface;
  surface.add(report.degenerate_faces, "degenerate face", "degenerate faces");
  surface.add(report.nonmanifold_edges, "non-manifold edge", "non-manifold edges");
  surface.add(report.nonmanifold_vertices, "non-manifold vertex", "non-manifold vertices");
  surface.add(report.misoriented_edges, "misoriented edge", "misoriented edges");
  lines.push_back("2-manifold: " + surface.or_else(report.faces > 0 ? "yes" : "no faces") +
                  (report.genus >= 0 ? ", genus " + std::to_string(report.genus) : ""));

  Complaints borders;
  borders.add(report.border_edges, "border edge", "border edges");
  borders.add(report.border_loops, "opening", "openings");
  std::string closed = "Closed: " + borders.or_else(report.faces > 0 ? "yes" : "no faces");
  if (report.closed()) {
    closed += ", volume " + short_number(report.volume);
    if (report.components_flat > 0)
      closed += ", " + counted(report.components_flat, "component is", "components are") +
                " flat, without an inside";
    if (report.cavities > 0) closed += ", " + counted(report.cavities, "cavity", "cavities");
    if (report.components_inside_out > 0)
      closed +=
          ", " + counted(report.components_inside_out, "component", "components") + " inside out";
  }
  lines.push_back(closed);

  if (report.self_intersecting_faces >= 0)
    lines.push_back("Self-intersections: " +
                    (report.self_intersecting_faces == 0
                         ? std::string("none")
                         : counted(report.self_intersecting_faces, "face", "faces")));

  Complaints samples;
  samples.add(report.samples_missing, "sample is no vertex", "samples are no vertex");
  samples.add(report.samples_matched_twice, "sample is several vertices",
              "samples are several vertices");
  samples.add(report.vertices_extra, "vertex is no sample", "vertices are no sample");
  lines.push_back("Complete matching: " + std::to_string(report.samples_matched) + " of " +
                  counted(report.samples, "sample", "samples") + " matched exactly; " +
                  samples.or_else("one to one"));
  return lines;
}

}  // namespace shrinkwrap
