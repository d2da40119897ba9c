#include "stop_at_surface/membrane_stretching.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <queue>
#include <utility>

#include "common/sort_unique.h"
#include "mesh/face_patches.h"
#include "mesh/harmonic_surface.h"
#include "mesh/self_intersection.h"

namespace shrinkwrap {
namespace {

constexpr int kRimSteps = 5;
constexpr double kRimWeight = 0.5;  // of the neighbours along the rim, in a step
constexpr double kMostMeeting = 0.2;
// A neck is squeezed more one way than the other over a large part of its area. A bulge that
// becomes flat around a small island shrinks about alike both ways; around a large one it is taken
// for a neck too.
constexpr double kSqueezed = 0.55, kMostSqueezed = 0.25;
constexpr double kLeastShare = 0.25;  // of the way; less is none
constexpr double kSteepest = 1.0;  // of how far vertices have gone, over the distance between them
constexpr int kMostRounds = 16;    // of either kind of going back

using Corners = std::array<Vec3, 3>;

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

// A membrane with the vertices around it, as places among all that move.
struct Part {
  SurfaceMembrane* membrane = nullptr;
  std::vector<Index> faces;    // with a corner in the membrane, ascending
  std::vector<Index> places;   // of its vertices and those of its rims, ascending
  bool is_other_side = false;  // of what was seen, rather than an opening in it
};

// Membranes on their way to where they are stretched. Each vertex, of them and of their rims, goes
// a share of its own way.
class Stretching {
 public:
  Stretching(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes, Progress& progress)
      : surface_(surface) {
    const MeshComponents components = connected_components(surface, progress);
    const std::vector<double> seen = seen_areas(surface, components, membranes);
    for (SurfaceMembrane& membrane : membranes) {
      if (!membrane.is_far || membrane.is_left_open || membrane.vertices.empty()) continue;
      Part part;
      part.membrane = &membrane;
      part.faces = faces_around(surface, membrane.vertices);
      double area = 0.0;
      for (const Index f : part.faces) area += surface.area_vector(f).norm();
      part.is_other_side = area > seen[components.of_vertex[membrane.vertices.front()]];
      const std::vector<Index> corners = corners_of(surface, part.faces);
      if (corners.size() == membrane.vertices.size()) continue;  // a body without samples
      stretched_.insert(stretched_.end(), membrane.vertices.begin(), membrane.vertices.end());
      moved_.insert(moved_.end(), corners.begin(), corners.end());
      parts_.push_back(std::move(part));
    }
    sort_unique(stretched_);
    sort_unique(moved_);
    std::set_difference(moved_.begin(), moved_.end(), stretched_.begin(), stretched_.end(),
                        std::back_inserter(rims_));
    for (Part& part : parts_)
      for (const Index v : corners_of(surface, part.faces)) part.places.push_back(place_of(v));
    for (const Index v : moved_) before_.push_back(surface.position[v]);
    share_.assign(moved_.size(), 0.0);
  }

  bool is_empty() const { return parts_.empty(); }

  // All of the way, but for necks.
  void set_out(Progress& progress) {
    smooth_rims();
    const bool is_solved = make_harmonic(surface_, stretched_, progress);
    for (const Index v : moved_) after_.push_back(surface_.position[v]);
    share_.assign(moved_.size(), is_solved ? 1.0 : 0.0);
    std::vector<Index> lowered;
    for (const Part& part : parts_)
      if (is_to_stay(part)) lowered.insert(lowered.end(), part.places.begin(), part.places.end());
    for (const Index i : lowered) share_[i] = 0.0;
    fall_off(lowered);
    move();
  }

  // From some vertices (ascending) half of the way, at last all of it, and less and less around
  // them: from an other side as a whole; `wholly`: from any membrane, all of the way. False if none
  // of the vertices has moved.
  bool go_back(const std::vector<Index>& vertices, bool wholly) {
    std::vector<Index> lowered;
    for (const Part& part : parts_) {
      std::vector<Index> here;
      for (const Index i : part.places)
        if (share_[i] > 0.0 && holds(vertices, moved_[i])) here.push_back(i);
      if (!here.empty() && (wholly || part.is_other_side)) here = part.places;
      lowered.insert(lowered.end(), here.begin(), here.end());
    }
    if (lowered.empty()) return false;
    sort_unique(lowered);
    for (const Index i : lowered) {
      share_[i] *= 0.5;
      if (wholly || share_[i] < kLeastShare) share_[i] = 0.0;
    }
    fall_off(lowered);
    move();
    return true;
  }
  void go_back_all_the_way() {
    share_.assign(moved_.size(), 0.0);
    move();
  }

  // Says which membranes are stretched, somewhere at least.
  void tell() const {
    for (const Part& part : parts_)
      part.membrane->is_stretched =
          std::any_of(part.membrane->vertices.begin(), part.membrane->vertices.end(),
                      [&](Index v) { return share_[place_of(v)] > 0.0; });
  }

 private:
  Index place_of(Index v) const {
    return static_cast<Index>(std::lower_bound(moved_.begin(), moved_.end(), v) - moved_.begin());
  }

  void smooth_rims() {
    std::vector<Vec3> smoothed(rims_.size());
    for (int step = 0; step < kRimSteps; ++step) {
      for (std::size_t i = 0; i < rims_.size(); ++i) {
        const Vec3& p = surface_.position[rims_[i]];
        Vec3 sum = Vec3::Zero();
        int count = 0;
        surface_.for_each_outgoing(rims_[i], [&](Index h) {
          if (!holds(rims_, surface_.target(h))) return;
          sum += surface_.position[surface_.target(h)] - p;
          ++count;
        });
        smoothed[i] = count > 0 ? Vec3(p + kRimWeight / count * sum) : p;
      }
      for (std::size_t i = 0; i < rims_.size(); ++i) surface_.position[rims_[i]] = smoothed[i];
    }
  }

  Corners corners(Index f, const std::vector<Vec3>& position) const {
    const auto [a, b, c] = surface_.triangle(f);
    return {position[place_of(a)], position[place_of(b)], position[place_of(c)]};
  }

  // Whether a membrane had better not be stretched at all.
  bool is_to_stay(const Part& part) const {
    if (is_disc(surface_, part.membrane->vertices)) return false;
    if (part.is_other_side) return true;
    double all = 0.0, squeezed = 0.0;
    for (const Index f : part.faces) {
      const Corners from = corners(f, before_);
      const double area = (from[1] - from[0]).cross(from[2] - from[0]).norm();
      all += area;
      if (likeness_of_stretches(from, corners(f, after_)) < kSqueezed) squeezed += area;
    }
    return squeezed > kMostSqueezed * all;
  }

  // Lowers shares so that from these places on no vertex goes farther than its neighbour's share of
  // its way by more than the distance between the two, times kSteepest.
  void fall_off(const std::vector<Index>& places) {
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const Index i : places) queue.push({share_[i], i});
    while (!queue.empty()) {
      const auto [share, i] = queue.top();
      queue.pop();
      if (share > share_[i]) continue;
      surface_.for_each_outgoing(moved_[i], [&](Index h) {
        const Index j = place_of(surface_.target(h));
        if (j == static_cast<Index>(moved_.size()) || moved_[j] != surface_.target(h)) return;
        const double way = (after_[j] - before_[j]).norm();
        const double most = share * way + kSteepest * (after_[j] - after_[i]).norm();
        if (!(share_[j] * way > most)) return;
        share_[j] = most / way;
        queue.push({share_[j], j});
      });
    }
  }

  void move() {
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      Vec3& p = surface_.position[moved_[i]];
      p = share_[i] > 0.0 ? Vec3(before_[i] + share_[i] * (after_[i] - before_[i])) : before_[i];
    }
  }

  SurfaceMesh& surface_;
  std::vector<Part> parts_;
  std::vector<Index> stretched_;  // the vertices of the membranes, ascending
  std::vector<Index> rims_;       // the vertices around them, ascending
  std::vector<Index> moved_;      // these, and those of their rims, ascending
  std::vector<Vec3> before_, after_;
  std::vector<double> share_;  // of the way from before to after
};

}  // namespace

void stretch_membranes(SurfaceMesh& surface, std::vector<SurfaceMembrane>& membranes,
                       Progress& progress) {
  Stretching stretching(surface, membranes, progress);
  if (stretching.is_empty()) return;
  const std::vector<Triangle> triangles = surface.triangles();
  const KeptMeetings before = keep_meetings(surface.position, triangles, progress);
  if (static_cast<double>(before.faces.size()) > kMostMeeting * surface.face_count()) return;
  stretching.set_out(progress);
  for (int round = 0;; ++round) {
    const std::vector<Index> meeting =
        newly_meeting_faces(before, keep_meetings(surface.position, triangles, progress));
    if (round == 2 * kMostRounds) {
      if (!meeting.empty()) stretching.go_back_all_the_way();
      break;
    }
    if (!stretching.go_back(corners_of(surface, meeting), round >= kMostRounds)) break;
  }
  stretching.tell();
}

}  // namespace shrinkwrap
