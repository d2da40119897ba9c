#include "complete_matching/surface_openings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <queue>
#include <utility>

#include "common/parallel.h"
#include "common/sort_unique.h"
#include "mesh/face_patches.h"
#include "mesh/self_intersection.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11, kPollInterval = 1 << 12;
constexpr int kVotes = 3;
constexpr int kBorderSteps = 5;
constexpr double kBorderWeight = 0.5;  // of the neighbours along the border, in a step
constexpr std::size_t kShortestBorder = 16;

// Where the samples are, seen from the vertices of membranes.
struct Nearest {
  std::vector<float> distance, spacing;  // per vertex: of the nearest sample

  Nearest(const SurfaceMesh& surface, const std::vector<char>& is_membrane, const PointCloud& cloud,
          Progress& progress)
      : distance(is_membrane.size()), spacing(is_membrane.size()) {
    parallel_for_each(surface.vertex_slots(), kGrain, progress, [&](Index v) {
      bool is_near_one = is_membrane[v] != 0;  // rims count too
      surface.for_each_outgoing(
          v, [&](Index h) { is_near_one = is_near_one || is_membrane[surface.target(h)]; });
      if (!is_near_one) return;
      const VoxelSearch::Hit hit = cloud.search.nearest(surface.position[v]);
      distance[v] = static_cast<float>(std::sqrt(hit.squared_distance));
      spacing[v] = static_cast<float>(cloud.spacing_beside(hit.index));
    });
  }
};

// How far the vertices of membranes are from the samples along the surface: from that of the
// nearest sample at the rim on. Infinite where there is no rim.
std::vector<float> distances_along(const SurfaceMesh& surface, const std::vector<char>& is_membrane,
                                   const Nearest& nearest, Progress& progress) {
  using Entry = std::pair<float, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<float> distance(is_membrane.size(), std::numeric_limits<float>::infinity());
  const auto reach = [&](Index v, float at) {
    if (at >= distance[v]) return;
    distance[v] = at;
    queue.push({at, v});
  };
  const auto spread = [&](Index from, float at) {
    surface.for_each_outgoing(from, [&](Index h) {
      const Index u = surface.target(h);
      if (is_membrane[u])
        reach(u, at + static_cast<float>((surface.position[u] - surface.position[from]).norm()));
    });
  };
  for (Index v = 0; v < surface.vertex_slots(); ++v)
    if (!is_membrane[v]) spread(v, nearest.distance[v]);
  for (Index count = 1; !queue.empty(); ++count) {
    const auto [at, v] = queue.top();
    queue.pop();
    if (at <= distance[v]) spread(v, at);
    if (count % kPollInterval == 0) progress.update(0.5);
  }
  return distance;
}

// Vertices that alone are unlike those around them turn into their like.
void straighten_outlines(const SurfaceMesh& surface, std::vector<char>& is_membrane,
                         Progress& progress) {
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
}

bool is_left_open(double width, const CompleteMatchingOptions& options) {
  switch (options.openings) {
    case CompleteMatchingOptions::Openings::close:
      return false;
    case CompleteMatchingOptions::Openings::leave_open:
      return true;
    case CompleteMatchingOptions::Openings::automatic:
      break;
  }
  return width > options.widest_opening;
}

// The borders of what is left without these faces, each in order.
std::vector<std::vector<Index>> borders_of(const SurfaceMesh& surface,
                                           const std::vector<Index>& dropped) {
  std::vector<char> is_dropped(static_cast<std::size_t>(surface.face_slots()), 0);
  for (const Index f : dropped) is_dropped[f] = 1;
  std::vector<std::vector<Index>> borders = border_loops_of(surface, is_dropped);
  for (std::vector<Index>& border : borders)
    for (Index& h : border) h = surface.origin(h);
  return borders;
}

// A border that is being smoothed.
class SmoothedBorder {
 public:
  SmoothedBorder(const SurfaceMesh& surface, std::vector<Index> border)
      : vertices_(std::move(border)) {
    for (const Index v : vertices_) before_.push_back(surface.position[v]);
  }

  void smooth(SurfaceMesh& surface) const {
    const std::size_t size = vertices_.size();
    std::vector<Vec3> smoothed(size);
    for (int step = 0; step < kBorderSteps; ++step) {
      for (std::size_t i = 0; i < size; ++i) {
        const auto at = [&](std::size_t k) -> const Vec3& {
          return surface.position[vertices_[(i + k) % size]];
        };
        smoothed[i] = at(0) + kBorderWeight * (0.5 * (at(size - 1) + at(1)) - at(0));
      }
      for (std::size_t i = 0; i < size; ++i) surface.position[vertices_[i]] = smoothed[i];
    }
  }

  bool has_one_of(const std::vector<Index>& ascending) const {
    return std::any_of(vertices_.begin(), vertices_.end(),
                       [&](Index v) { return holds(ascending, v); });
  }
  void go_back(SurfaceMesh& surface) const {
    for (std::size_t i = 0; i < vertices_.size(); ++i) surface.position[vertices_[i]] = before_[i];
  }

 private:
  std::vector<Index> vertices_;
  std::vector<Vec3> before_;
};

// Smooths the borders of what is left without these faces (ascending), but for those at which faces
// would meet others that they did not meet before. As many searches for these as borders in their
// way, and two.
void smooth_borders(SurfaceMesh& surface, const std::vector<Index>& dropped, Progress& progress) {
  std::vector<SmoothedBorder> borders;
  for (std::vector<Index>& border : borders_of(surface, dropped))
    if (border.size() >= kShortestBorder) borders.emplace_back(surface, std::move(border));
  if (borders.empty()) return;
  std::vector<Triangle> left;
  for (Index f = 0; f < surface.face_slots(); ++f)
    if (!holds(dropped, f)) left.push_back(surface.triangle(f));
  const KeptMeetings before = keep_meetings(surface.position, left, progress);
  for (const SmoothedBorder& border : borders) border.smooth(surface);
  while (!borders.empty()) {
    std::vector<Index> corners;
    for (const Index i :
         newly_meeting_faces(before, keep_meetings(surface.position, left, progress)))
      corners.insert(corners.end(), left[i].begin(), left[i].end());
    sort_unique(corners);
    // Those that go back may free others, or leave others in their way.
    const auto stay = std::stable_partition(
        borders.begin(), borders.end(),
        [&](const SmoothedBorder& border) { return !border.has_one_of(corners); });
    if (stay == borders.end()) return;
    for (auto border = stay; border != borders.end(); ++border) border->go_back(surface);
    borders.erase(stay, borders.end());
  }
}

}  // namespace

std::vector<SurfaceMembrane> find_surface_membranes(const SurfaceMesh& surface,
                                                    std::vector<char> is_membrane,
                                                    const PointCloud& cloud,
                                                    const CompleteMatchingOptions& options,
                                                    Progress& progress) {
  std::vector<SurfaceMembrane> openings;
  const bool has_sides = cloud.size() > cloud.neighbour_count;
  if (!has_sides || std::count(is_membrane.begin(), is_membrane.end(), 0) == surface.vertex_slots())
    return openings;
  straighten_outlines(surface, is_membrane, progress);
  const Nearest nearest(surface, is_membrane, cloud, progress);
  const std::vector<float> distance = distances_along(surface, is_membrane, nearest, progress);
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (!is_membrane[seed]) continue;
    SurfaceMembrane membrane;
    std::vector<Index>& vertices = membrane.vertices;
    bool is_opening = false;
    is_membrane[seed] = 0;
    vertices.push_back(seed);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Index v = vertices[i];
      const double limit = options.membrane_high * nearest.spacing[v];
      is_opening = is_opening || distance[v] > limit;
      membrane.is_far = membrane.is_far || nearest.distance[v] > limit;
      membrane.width = std::max(membrane.width, 2.0 * distance[v] / cloud.spacing);
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (!is_membrane[u]) return;
        is_membrane[u] = 0;
        vertices.push_back(u);
      });
    }
    if (!is_opening) continue;
    std::sort(vertices.begin(), vertices.end());
    membrane.is_left_open = is_left_open(membrane.width, options);
    openings.push_back(std::move(membrane));
  }
  return openings;
}

SurfaceOpenings cut_surface_openings(SurfaceMesh& surface,
                                     const std::vector<SurfaceMembrane>& membranes,
                                     Progress& progress) {
  SurfaceOpenings result;
  std::vector<Index> open, spanned;  // vertices
  for (const SurfaceMembrane& membrane : membranes) {
    std::vector<Index>& vertices = membrane.is_left_open ? open : spanned;
    vertices.insert(vertices.end(), membrane.vertices.begin(), membrane.vertices.end());
    ++(membrane.is_left_open ? result.report.left_open : result.report.spanned);
    result.report.stretched += membrane.is_stretched;
  }
  result.opening_faces = cut_openings(surface, faces_around(surface, open), 0, progress);
  smooth_borders(surface, result.opening_faces, progress);
  const std::vector<Index> spanning = faces_around(surface, spanned);
  std::set_union(spanning.begin(), spanning.end(), result.opening_faces.begin(),
                 result.opening_faces.end(), std::back_inserter(result.spanning_faces));
  return result;
}

}  // namespace shrinkwrap
