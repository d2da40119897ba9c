#include "membrane_stretching.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "face_patches.h"
#include "harmonic_surface.h"
#include "self_intersection.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

constexpr int kRimSteps = 5;
constexpr double kRimWeight = 0.5;  // of the neighbours along the rim, in a step
constexpr double kMostMeeting = 0.2;
// A neck is squeezed across itself, and not along, over more than such a part of its area; a bulge
// that becomes flat shrinks alike both ways.
constexpr double kSqueezed = 0.55, kMostSqueezed = 0.25;
constexpr double kLeastShare = 0.25;  // of the way; less is none
constexpr double kShareAnEdge = 0.125;
constexpr int kMostRounds = 8;  // of either kind of going back

using Corners = std::array<Vec3, 3>;

bool holds(const std::vector<Index>& ascending, Index i) {
  return std::binary_search(ascending.begin(), ascending.end(), i);
}

Corners corners_of_face(const SurfaceMesh& surface, Index f) {
  const auto [a, b, c] = surface.triangle(f);
  return {surface.position[a], surface.position[b], surface.position[c]};
}

// Of the linear map from a triangle to another: the least stretch over the greatest, 0 to 1. (The
// squares of both are the eigenvalues of the map's metric.) 1 if the first has no area.
double likeness_of_stretches(const Corners& from, const Corners& to) {
  const Vec3 u = from[1] - from[0], v = from[2] - from[0];
  const Vec3 along = u.normalized(), across = u.cross(v).cross(u).normalized();
  Eigen::Matrix2d frame;
  frame << u.dot(along), v.dot(along), 0.0, v.dot(across);
  if (!(frame(0, 0) > 0.0) || !(frame(1, 1) > 0.0)) return 1.0;
  Eigen::Matrix<double, 3, 2> map;
  map << to[1] - to[0], to[2] - to[0];
  map = (map * frame.inverse()).eval();
  const Eigen::Vector2d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>()
                                      .computeDirect(map.transpose() * map)
                                      .eigenvalues();
  return squares[1] > 0.0 ? std::sqrt(std::max(squares[0], 0.0) / squares[1]) : 1.0;
}

// Whether a membrane is a disc: by the Euler characteristic of the faces and edges at its vertices.
bool is_disc(const SurfaceMesh& surface, const std::vector<Index>& vertices) {
  Index edges = 0, faces = 0;  // each counted at its lowest vertex here
  for (const Index v : vertices)
    surface.for_each_outgoing(v, [&](Index h) {
      const Index a = surface.target(h), b = surface.opposite(h);
      const bool is_above_a = a < v && holds(vertices, a), is_above_b = b < v && holds(vertices, b);
      edges += is_above_a ? 0 : 1;
      faces += is_above_a || is_above_b ? 0 : 1;
    });
  return static_cast<Index>(vertices.size()) - edges + faces == 1;
}

// Twice the area of each body without its membranes.
std::vector<double> seen_areas(const SurfaceMesh& surface, const MeshComponents& components,
                               const std::vector<SurfaceMembrane>& membranes) {
  std::vector<double> area(components.count, 0.0);
  const auto body_of = [&](Index f) { return components.of_vertex[surface.origin(3 * f)]; };
  for (Index f = 0; f < surface.face_slots(); ++f)
    area[body_of(f)] += surface.area_vector(f).norm();
  for (const SurfaceMembrane& membrane : membranes)
    for (const Index f : faces_around(surface, membrane.vertices))
      area[body_of(f)] -= surface.area_vector(f).norm();
  return area;
}

// A membrane that is being stretched, with the vertices of its rims. Each of them goes a share of
// its way.
class Stretched {
 public:
  // `seen_area`: of its body, as `seen_areas` has it.
  Stretched(const SurfaceMesh& surface, SurfaceMembrane& membrane, double seen_area)
      : membrane_(&membrane), faces_(faces_around(surface, membrane.vertices)) {
    for (const Index v : corners_of(surface, faces_))
      if (!holds(membrane.vertices, v)) rim_.push_back(v);
    std::merge(membrane.vertices.begin(), membrane.vertices.end(), rim_.begin(), rim_.end(),
               std::back_inserter(moved_));
    for (const Index v : moved_) before_.push_back(surface.position[v]);
    for (const Index f : faces_) {
      corners_before_.push_back(corners_of_face(surface, f));
      area_ += surface.area_vector(f).norm();
    }
    is_other_side_ = area_ > seen_area;
    share_.assign(moved_.size(), 1.0);
  }

  bool has_rim() const { return !rim_.empty(); }  // otherwise it is a body without samples

  void smooth_rim(SurfaceMesh& surface) const {
    std::vector<Vec3> smoothed(rim_.size());
    for (int step = 0; step < kRimSteps; ++step) {
      for (std::size_t i = 0; i < rim_.size(); ++i) {
        const Vec3& p = surface.position[rim_[i]];
        Vec3 sum = Vec3::Zero();
        int count = 0;
        surface.for_each_outgoing(rim_[i], [&](Index h) {
          if (!holds(rim_, surface.target(h))) return;
          sum += surface.position[surface.target(h)] - p;
          ++count;
        });
        smoothed[i] = count > 0 ? Vec3(p + kRimWeight / count * sum) : p;
      }
      for (std::size_t i = 0; i < rim_.size(); ++i) surface.position[rim_[i]] = smoothed[i];
    }
  }

  // Whether it should stay as it is after all.
  bool becomes_neck(const SurfaceMesh& surface) const {
    if (is_disc(surface, membrane_->vertices)) return false;
    if (is_other_side_) return true;  // with what was seen of it as islands
    double squeezed = 0.0;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const Corners& before = corners_before_[i];
      if (likeness_of_stretches(before, corners_of_face(surface, faces_[i])) < kSqueezed)
        squeezed += (before[1] - before[0]).cross(before[2] - before[0]).norm();
    }
    return squeezed > kMostSqueezed * area_;
  }

  // Where the vertices are now, is the end of their way.
  void set_out(const SurfaceMesh& surface) {
    for (const Index v : moved_) after_.push_back(surface.position[v]);
    membrane_->is_stretched = true;
  }

  // From some vertices (ascending) half of the way, at last all of it, and less and less around
  // them; an other side as a whole. False if none of them is here or moved.
  bool go_back(SurfaceMesh& surface, const std::vector<Index>& vertices) {
    if (!moves_one_of(vertices)) return false;
    std::vector<Index> lowered;  // their places
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      if (share_[i] == 0.0 || (!is_other_side_ && !holds(vertices, moved_[i]))) continue;
      share_[i] *= 0.5;
      if (share_[i] < kLeastShare) share_[i] = 0.0;
      lowered.push_back(static_cast<Index>(i));
    }
    for (std::size_t k = 0; k < lowered.size(); ++k) {
      const double most = share_[lowered[k]] + kShareAnEdge;
      surface.for_each_outgoing(moved_[lowered[k]], [&](Index h) {
        const auto at = std::lower_bound(moved_.begin(), moved_.end(), surface.target(h));
        if (at == moved_.end() || *at != surface.target(h)) return;
        const Index i = static_cast<Index>(at - moved_.begin());
        if (share_[i] <= most) return;
        share_[i] = most;
        lowered.push_back(i);
      });
    }
    for (const Index i : lowered)
      surface.position[moved_[i]] =
          share_[i] > 0.0 ? Vec3(before_[i] + share_[i] * (after_[i] - before_[i])) : before_[i];
    membrane_->is_stretched =
        std::any_of(share_.begin(), share_.end(), [](double share) { return share > 0.0; });
    return true;
  }
  void go_back_all_the_way(SurfaceMesh& surface) {
    for (std::size_t i = 0; i < moved_.size(); ++i) surface.position[moved_[i]] = before_[i];
    share_.assign(moved_.size(), 0.0);
    membrane_->is_stretched = false;
  }
  bool moves_one_of(const std::vector<Index>& vertices) const {
    for (std::size_t i = 0; i < moved_.size(); ++i)
      if (share_[i] > 0.0 && holds(vertices, moved_[i])) return true;
    return false;
  }

 private:
  SurfaceMembrane* membrane_;
  std::vector<Index> faces_;  // with a corner in the membrane, ascending
  std::vector<Index> rim_;    // ascending
  std::vector<Index> moved_;  // the membrane's vertices and those of its rims, ascending
  std::vector<Vec3> before_, after_;
  std::vector<Corners> corners_before_;  // of the faces
  std::vector<double> share_;            // of the way from before to after
  double area_ = 0.0;                    // twice that of the faces, before
  bool is_other_side_ = false;           // of what was seen, rather than an opening in it
};

}  // namespace

void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress) {
  const MeshComponents components = connected_components(surface, progress);
  const std::vector<double> seen = seen_areas(surface, components, membranes);
  std::vector<Stretched> stretched;
  std::vector<Index> vertices;
  for (SurfaceMembrane& membrane : membranes) {
    if (!membrane.is_far || membrane.is_left_open) continue;
    Stretched one(surface, membrane, seen[components.of_vertex[membrane.vertices.front()]]);
    if (!one.has_rim()) continue;
    stretched.push_back(std::move(one));
    vertices.insert(vertices.end(), membrane.vertices.begin(), membrane.vertices.end());
  }
  if (stretched.empty()) return;
  const std::vector<Triangle> triangles = surface.triangles();
  const auto faces_that_meet = [&] {
    return self_intersecting_faces(surface.position, triangles, progress);
  };
  const std::vector<Index> met_before = faces_that_meet();
  if (static_cast<double>(met_before.size()) > kMostMeeting * surface.face_count()) return;
  sort_unique(vertices);
  const auto all_go_back = [&] {
    for (Stretched& one : stretched) one.go_back_all_the_way(surface);
  };
  for (const Stretched& one : stretched) one.smooth_rim(surface);
  if (!make_harmonic(surface, vertices, progress)) return all_go_back();
  for (Stretched& one : stretched) {
    one.set_out(surface);
    if (one.becomes_neck(surface)) one.go_back_all_the_way(surface);
  }
  for (int round = 0; round < 2 * kMostRounds; ++round) {
    const std::vector<Index> met = faces_that_meet();
    std::vector<Index> meeting;
    std::set_difference(met.begin(), met.end(), met_before.begin(), met_before.end(),
                        std::back_inserter(meeting));
    const std::vector<Index> corners = corners_of(surface, meeting);
    bool goes_back = false;
    for (Stretched& one : stretched) {
      if (round < kMostRounds) {
        goes_back = one.go_back(surface, corners) || goes_back;
      } else if (one.moves_one_of(corners)) {
        one.go_back_all_the_way(surface);
        goes_back = true;
      }
    }
    if (!goes_back) return;
  }
  all_go_back();
}

}  // namespace shrinkwrap
