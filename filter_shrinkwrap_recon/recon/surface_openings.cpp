#include "surface_openings.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "harmonic_surface.h"
#include "parallel.h"
#include "self_intersection.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr int kVotes = 3;
constexpr int kRimSteps = 5;
constexpr double kRimWeight = 0.5;  // of the neighbours along the rim, in a step
constexpr int kHalvings = 2;
constexpr double kLeastArea = 0.75;  // of a membrane of several rims, x its area before

// Whether a membrane is a disc: by the Euler characteristic of the faces and edges at its vertices.
bool is_disc(const SurfaceMesh& surface, const std::vector<Index>& vertices) {
  const auto holds = [&](Index v) {
    return std::binary_search(vertices.begin(), vertices.end(), v);
  };
  Index edges = 0, faces = 0;  // each counted at its lowest vertex here
  for (const Index v : vertices)
    surface.for_each_outgoing(v, [&](Index h) {
      const Index a = surface.target(h), b = surface.opposite(h);
      const bool is_above_a = a < v && holds(a), is_above_b = b < v && holds(b);
      edges += is_above_a ? 0 : 1;
      faces += is_above_a || is_above_b ? 0 : 1;
    });
  return static_cast<Index>(vertices.size()) - edges + faces == 1;
}

std::vector<Index> faces_at(const SurfaceMesh& surface, const std::vector<Index>& vertices) {
  std::vector<Index> faces;
  for (const Index v : vertices)
    surface.for_each_outgoing(v, [&](Index h) { faces.push_back(SurfaceMesh::face(h)); });
  sort_unique(faces);
  return faces;
}

double area_of(const SurfaceMesh& surface, const std::vector<Index>& faces) {
  double sum = 0.0;
  for (const Index f : faces) sum += surface.area_vector(f).norm();
  return sum;
}

// Moves vertices (ascending) towards the middle of the neighbours to which a half-edge of a curve
// leads, for which `is_on_curve(h)` holds.
template <class IsOnCurve>
void smooth_curves(SurfaceMesh& surface, const std::vector<Index>& vertices,
                   const IsOnCurve& is_on_curve) {
  std::vector<Vec3> smoothed(vertices.size());
  for (int step = 0; step < kRimSteps; ++step) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      Vec3 sum = Vec3::Zero();
      int count = 0;
      surface.for_each_outgoing(vertices[i], [&](Index h) {
        if (!is_on_curve(h)) return;
        sum += surface.position[surface.target(h)];
        ++count;
      });
      const Vec3& p = surface.position[vertices[i]];
      smoothed[i] = count > 0 ? Vec3(p + kRimWeight * (sum / count - p)) : p;
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) surface.position[vertices[i]] = smoothed[i];
  }
}

// The borders of what is left without these faces (ascending).
void smooth_borders(SurfaceMesh& surface, const std::vector<Index>& dropped) {
  const auto is_dropped = [&](Index h) {
    return std::binary_search(dropped.begin(), dropped.end(), SurfaceMesh::face(h));
  };
  const auto is_on_border = [&](Index h) { return is_dropped(h) != is_dropped(surface.twin(h)); };
  std::vector<Index> border;
  for (const Index f : dropped)
    for (Index h = 3 * f; h < 3 * f + 3; ++h)
      if (is_on_border(h)) border.push_back(surface.origin(h));
  sort_unique(border);
  smooth_curves(surface, border, is_on_border);
}

// A membrane that is being stretched, with what surrounds it.
struct Stretched {
  SurfaceMembrane* membrane;
  std::vector<Index> moved;  // its vertices, then those of its rims
  std::vector<Vec3> before;  // where these were
  double area_before;
  int halvings = 0;

  Stretched(const SurfaceMesh& surface, SurfaceMembrane& of)
      : membrane(&of),
        moved(of.vertices),
        area_before(area_of(surface, faces_at(surface, of.vertices))) {
    std::vector<Index> rim;
    for (const Index v : of.vertices)
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (!std::binary_search(of.vertices.begin(), of.vertices.end(), u)) rim.push_back(u);
      });
    sort_unique(rim);
    moved.insert(moved.end(), rim.begin(), rim.end());
    for (const Index v : moved) before.push_back(surface.position[v]);
  }

  bool has_rim() const { return moved.size() > membrane->vertices.size(); }

  void smooth_rim(SurfaceMesh& surface) const {
    const std::vector<Index> rim(
        moved.begin() + static_cast<std::ptrdiff_t>(membrane->vertices.size()), moved.end());
    smooth_curves(surface, rim, [&](Index h) {
      return std::binary_search(rim.begin(), rim.end(), surface.target(h));
    });
  }

  bool is_neck(const SurfaceMesh& surface) const {
    return area_of(surface, faces_at(surface, membrane->vertices)) < kLeastArea * area_before &&
           !is_disc(surface, membrane->vertices);
  }

  // Half of the way; at last all of it.
  void go_back(SurfaceMesh& surface) {
    if (++halvings > kHalvings) return go_back_all_the_way(surface);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      Vec3& p = surface.position[moved[i]];
      p = 0.5 * (p + before[i]);
    }
  }
  void go_back_all_the_way(SurfaceMesh& surface) {
    for (std::size_t i = 0; i < moved.size(); ++i) surface.position[moved[i]] = before[i];
    membrane->is_stretched = false;
  }
};

}  // namespace

std::vector<SurfaceMembrane> find_surface_membranes(const SurfaceMesh& surface,
                                                    std::vector<char> is_membrane,
                                                    const PointCloud& cloud,
                                                    const CompleteMatchingOptions& options,
                                                    Progress& progress) {
  std::vector<SurfaceMembrane> membranes;
  if (std::none_of(is_membrane.begin(), is_membrane.end(), [](char is) { return is != 0; }))
    return membranes;
  for (int vote = 0; vote < kVotes; ++vote) {
    std::vector<char> next(is_membrane.size());
    parallel_for_each(surface.vertex_slots(), kGrain, progress, [&](Index v) {
      Index votes = 0;
      surface.for_each_outgoing(v,
                                [&](Index h) { votes += is_membrane[surface.target(h)] ? 1 : -1; });
      next[v] = votes == 0 ? is_membrane[v] : votes > 0;
    });
    is_membrane = std::move(next);
  }
  std::vector<char> is_found(is_membrane.size(), 0);
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (!is_membrane[seed] || is_found[seed]) continue;
    SurfaceMembrane membrane;
    std::vector<Index>& vertices = membrane.vertices;
    vertices.push_back(seed);
    is_found[seed] = 1;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      surface.for_each_outgoing(vertices[i], [&](Index h) {
        const Index u = surface.target(h);
        if (!is_membrane[u] || is_found[u]) return;
        is_found[u] = 1;
        vertices.push_back(u);
      });
    membrane.is_wide = std::any_of(vertices.begin(), vertices.end(), [&](Index v) {
      const VoxelSearch::Hit nearest = cloud.search.nearest(surface.position[v]);
      const double spacing =
          std::max(cloud.spacing, static_cast<double>(cloud.local_spacing[nearest.index]));
      return std::sqrt(nearest.squared_distance) > options.membrane_high * spacing;
    });
    std::sort(vertices.begin(), vertices.end());
    membranes.push_back(std::move(membrane));
  }
  return membranes;
}

void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress) {
  std::vector<Stretched> stretched;
  std::vector<Index> vertices;
  for (SurfaceMembrane& membrane : membranes) {
    if (!membrane.is_wide) continue;
    Stretched one(surface, membrane);
    if (!one.has_rim()) continue;  // a body without samples
    membrane.is_stretched = true;
    stretched.push_back(std::move(one));
    vertices.insert(vertices.end(), membrane.vertices.begin(), membrane.vertices.end());
  }
  if (stretched.empty()) return;
  std::sort(vertices.begin(), vertices.end());
  for (const Stretched& one : stretched) one.smooth_rim(surface);
  const bool is_solved = make_harmonic(surface, vertices);
  for (Stretched& one : stretched)
    if (!is_solved || one.is_neck(surface)) one.go_back_all_the_way(surface);
  bool goes_back = true;
  while (goes_back) {
    goes_back = false;
    const std::vector<Index> meeting =
        self_intersecting_faces(surface.position, surface.triangles(), progress);
    if (meeting.empty()) break;
    std::vector<Index> corners;
    for (const Index f : meeting)
      for (const Index v : surface.triangle(f)) corners.push_back(v);
    sort_unique(corners);
    for (Stretched& one : stretched) {
      if (!one.membrane->is_stretched ||
          std::none_of(one.moved.begin(), one.moved.end(), [&](Index v) {
            return std::binary_search(corners.begin(), corners.end(), v);
          }))
        continue;
      one.go_back(surface);
      goes_back = true;
    }
  }
}

SurfaceOpenings decide_surface_openings(SurfaceMesh& surface,
                                        const std::vector<SurfaceMembrane>& membranes,
                                        const PointCloud& cloud,
                                        const CompleteMatchingOptions& options,
                                        Progress& progress) {
  using Openings = CompleteMatchingOptions::Openings;
  SurfaceOpenings result;
  const double widest = options.openings == Openings::leave_open ? options.membrane_high
                                                                 : 0.5 * options.widest_opening;
  const auto is_beyond = [&](Index v) {
    const Vec3f normal = surface.vertex_normal(v).cast<float>();
    const VoxelSearch::Hit nearest = cloud.search.nearest(surface.position[v]);
    const double spacing =
        std::max(cloud.spacing, static_cast<double>(cloud.local_spacing[nearest.index]));
    return cloud.search
               .nearest_if(surface.position[v], widest * spacing,
                           [&](Index i) { return cloud.normal[i].dot(normal) > 0.0f; })
               .index == kNone;
  };
  std::vector<Index> open, spanned;
  for (const SurfaceMembrane& membrane : membranes) {
    progress.update(0.5);
    const std::vector<Index>& vertices = membrane.vertices;
    const bool is_left_open = options.openings != Openings::close &&
                              std::any_of(vertices.begin(), vertices.end(), is_beyond);
    if (!is_left_open && !membrane.is_wide) continue;
    ++(is_left_open ? result.report.left_open : result.report.spanned);
    if (!is_left_open && membrane.is_stretched) ++result.report.stretched;
    std::vector<Index>& faces = is_left_open ? open : spanned;
    const std::vector<Index> more = faces_at(surface, vertices);
    faces.insert(faces.end(), more.begin(), more.end());
  }
  sort_unique(open);
  sort_unique(spanned);
  result.opening_faces = cut_openings(surface, open, 0, progress);
  smooth_borders(surface, result.opening_faces);
  std::set_union(spanned.begin(), spanned.end(), result.opening_faces.begin(),
                 result.opening_faces.end(), std::back_inserter(result.spanning_faces));
  return result;
}

}  // namespace shrinkwrap
