#include "complete_matching/near_copy_insertion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr int kTurns = 16;                          // directions around a middle one
constexpr double kTilts[] = {0.15, 0.3, 0.6, 1.2};  // tangents of their angles with it
constexpr int kSteps = 64;                          // to the middle one
constexpr double kWeightOfWays = 4.0;               // of the angles between places, x faces
constexpr int kMostSteps = 64;  // from triangle to triangle on the way to a copy
constexpr int kFlipsPerCopy = 64;

using PlanePoint = Eigen::Vector2d;

double twice_area(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  const PlanePoint ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

class NearCopyInserter {
 public:
  explicit NearCopyInserter(CompleteMatching& matching)
      : matching_(matching), mesh_(matching.mesh), kind_(mesh_.face_slots(), kSurface) {
    for (const Index f : matching.spanning_faces) kind_[f] = kSpanning;
    for (const Index f : matching.opening_faces) kind_[f] = kOpening;
  }

  // Inserts vertices at these places, which are near that of the vertex `original`.
  void insert(Index original, const std::vector<Vec3>& places) {
    origin_ = mesh_.position[original];
    look_along(best_direction(original, places));
    group_.assign(1, original);
    for (const Vec3& place : places) insert_one(original, place);
  }

 private:
  // Of a face. No copy goes into an opening: a vertex needs a face that is none.
  enum Kind : char { kSurface, kSpanning, kOpening };

  struct Place {
    Index face = kNone;
    std::array<double, 3> weight{};  // of its corners; below 0: beyond the edge across
    double least() const { return std::min({weight[0], weight[1], weight[2]}); }
  };

  // The unit normals of the faces around a vertex.
  std::vector<Vec3> normals_around(Index vertex) const {
    std::vector<Vec3> normals;
    mesh_.for_each_outgoing(vertex, [&](Index h) {
      const Index f = SurfaceMesh::face(h);
      if (kind_[f] != kOpening) normals.push_back(unit_or_zero(mesh_.area_vector(f)));
    });
    return normals;
  }

  // The direction from which the steepest of these is least so; zero if there are none.
  static Vec3 middle_of(const std::vector<Vec3>& normals) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& normal : normals) middle += normal;
    middle = unit_or_zero(middle);
    const auto is_worse = [&](const Vec3& a, const Vec3& b) {
      return a.dot(middle) < b.dot(middle);
    };
    // Towards the worst in ever smaller steps (Badoiu and Clarkson 2003).
    for (int step = 1; step <= kSteps && !normals.empty(); ++step) {
      const Vec3& worst = *std::min_element(normals.begin(), normals.end(), is_worse);
      middle = unit_or_zero(middle + (worst - middle) / (step + 1));
    }
    return middle;
  }

  static double worst_of(const std::vector<Vec3>& normals, const Vec3& direction) {
    double worst = 1.0;
    for (const Vec3& normal : normals) worst = std::min(worst, normal.dot(direction));
    return worst;
  }

  // The one in which the worst of two things is best: how steep the faces around the vertex are,
  // and how near to each other two of the places are, x their distance.
  Vec3 best_direction(Index original, const std::vector<Vec3>& places) const {
    const std::vector<Vec3> normals = normals_around(original);
    Vec3 middle = middle_of(normals);
    if (middle.isZero()) middle = mesh_.vertex_normal(original);  // or all faces are degenerate
    std::vector<Vec3> ways;
    for (std::size_t i = 0; i < places.size(); ++i) {
      ways.push_back(unit_or_zero(places[i] - origin_));
      for (std::size_t j = 0; j < i; ++j) ways.push_back(unit_or_zero(places[i] - places[j]));
    }
    const auto quality_of = [&](const Vec3& direction) {
      double quality = worst_of(normals, direction);
      for (const Vec3& way : ways)
        quality = std::min(quality, kWeightOfWays * way.cross(direction).norm());
      return quality;
    };
    const Vec3 across = middle.unitOrthogonal(), along = middle.cross(across);
    Vec3 best = middle;
    double best_quality = quality_of(best);
    for (const double tilt : kTilts)
      for (int k = 0; k < kTurns; ++k) {
        const double angle = 2.0 * kPi * k / kTurns;
        const Vec3 direction =
            (middle + tilt * (std::cos(angle) * across + std::sin(angle) * along)).normalized();
        const double quality = quality_of(direction);
        if (!(quality > best_quality)) continue;
        best_quality = quality;
        best = direction;
      }
    return best;
  }

  void look_along(const Vec3& direction) {
    u_ = direction.unitOrthogonal();
    v_ = direction.cross(u_);
  }
  PlanePoint seen(const Vec3& p) const {
    const Vec3 d = p - origin_;
    return {d.dot(u_), d.dot(v_)};
  }
  PlanePoint seen(Index vertex) const { return seen(mesh_.position[vertex]); }

  Place place_in(Index f, const PlanePoint& p) const {
    const Triangle t = mesh_.triangle(f);
    const PlanePoint a = seen(t[0]), b = seen(t[1]), c = seen(t[2]);
    const double area = twice_area(a, b, c);
    Place place;
    place.face = f;
    place.weight = {twice_area(p, b, c), twice_area(a, p, c), twice_area(a, b, p)};
    for (double& weight : place.weight)
      weight = area > 0.0 ? weight / area : -std::numeric_limits<double>::infinity();
    return place;
  }

  // The triangle below a point, from those around the vertex on; the last one before an opening if
  // it lies below that.
  Place find(Index original, const PlanePoint& p) const {
    Place best;
    const auto is_opening = [&](Index f) { return kind_[f] == kOpening; };
    mesh_.for_each_outgoing(original, [&](Index h) {
      const Place place = place_in(SurfaceMesh::face(h), p);
      const bool is_better =
          best.face == kNone || is_opening(best.face) > is_opening(place.face) ||
          (is_opening(best.face) == is_opening(place.face) && place.least() > best.least());
      if (is_better) best = place;
    });
    for (int step = 0; step < kMostSteps && best.least() < 0.0; ++step) {
      // Across the edge that the point lies farthest beyond.
      Place next;
      double farthest = 0.0;
      for (Index corner = 0; corner < 3; ++corner) {
        const double weight = best.weight[corner];
        const Index beyond = face_across(best.face, corner);
        if (!(weight < farthest) || is_opening(beyond)) continue;
        farthest = weight;
        next = place_in(beyond, p);
      }
      if (next.face == kNone || !std::isfinite(next.least())) break;
      best = next;
    }
    return best;
  }

  // Half-edge that a corner of a face looks at.
  static Index edge_across(Index f, Index corner) { return SurfaceMesh::next(3 * f + corner); }
  Index face_across(Index f, Index corner) const {
    return SurfaceMesh::face(mesh_.twin(edge_across(f, corner)));
  }

  // The half-edge of the opening that the point lies in, if it is beyond no other edge; or kNone.
  Index border_before(const Place& place) const {
    Index border = kNone;
    for (Index corner = 0; corner < 3 && kind_[place.face] != kOpening; ++corner) {
      if (place.weight[corner] > 0.0) continue;
      const Index beyond = mesh_.twin(edge_across(place.face, corner));
      if (border != kNone || kind_[SurfaceMesh::face(beyond)] != kOpening) return kNone;
      border = beyond;
    }
    return border;
  }

  void insert_one(Index original, const Vec3& p) {
    const Place place = find(original, seen(p));
    const Index border = border_before(place);
    const Index first_new_face = mesh_.face_slots();
    const Index vertex = mesh_.split_face(place.face, p);
    group_.push_back(vertex);
    const Kind kind = kind_[place.face];
    kind_.resize(mesh_.face_slots(), kind);
    if (kind != kSurface)
      for (Index f = first_new_face; f < mesh_.face_slots(); ++f) mark_as(place.face, f);
    if (border != kNone && mesh_.is_flip_legal(border)) {
      // It goes through the vertex then, and both its faces are the opening's.
      const Index outside = SurfaceMesh::face(border),
                  inside = SurfaceMesh::face(mesh_.twin(border));
      mesh_.flip(border);
      kind_[inside] = kOpening;
      mark_as(outside, inside);
    }
    stack_.clear();
    mesh_.for_each_outgoing(vertex, [&](Index h) { stack_.push_back(SurfaceMesh::next(h)); });
    flip_to_delaunay();
  }

  // Makes a face one of the openings, or of those that span, if another is.
  void mark_as(Index other, Index f) {
    for (std::vector<Index>* faces : {&matching_.opening_faces, &matching_.spanning_faces}) {
      const auto place_of = [&](Index face) {
        return std::lower_bound(faces->begin(), faces->end(), face);
      };
      const auto of_other = place_of(other), own = place_of(f);
      if (of_other == faces->end() || *of_other != other) continue;
      if (own == faces->end() || *own != f) faces->insert(own, f);
    }
  }

  // Flips edges in the plane as long as that helps, each to one that ends at the sample or its
  // copies: others stay.
  void flip_to_delaunay() {
    for (int looks = kFlipsPerCopy; looks > 0 && !stack_.empty(); --looks) {
      const Index h = stack_.back();
      stack_.pop_back();
      if (!wants_flip(h) || !mesh_.is_flip_legal(h)) continue;
      const Index o = mesh_.twin(h);
      mesh_.flip(h);
      for (const Index side :
           {SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(o), SurfaceMesh::prev(o)})
        stack_.push_back(side);
    }
  }

  bool wants_flip(Index h) const {
    constexpr double kLeastExcess = 1e-7;  // sine: four points on a circle do not flip for ever
    const Index o = mesh_.twin(h);
    const Kind kind = kind_[SurfaceMesh::face(h)];
    if (kind == kOpening || kind != kind_[SurfaceMesh::face(o)]) return false;
    const Index corner_c = mesh_.opposite(h), corner_d = mesh_.opposite(o);
    if (corner_c == corner_d || !(is_of_group(corner_c) || is_of_group(corner_d))) return false;
    const PlanePoint a = seen(mesh_.origin(h)), b = seen(mesh_.origin(o)), c = seen(corner_c),
                     d = seen(corner_d);
    if (!(twice_area(d, c, a) > 0.0 && twice_area(c, d, b) > 0.0)) return false;
    // cot(c) + cot(d) < 0, multiplied by both sines and the lengths of the sides.
    const double cos_c = (a - c).dot(b - c), cos_d = (a - d).dot(b - d);
    const double sin_c = twice_area(c, a, b), sin_d = twice_area(d, b, a);
    const double excess = -(cos_c * sin_d + cos_d * sin_c);
    return excess > kLeastExcess * (std::abs(sin_c * sin_d) + std::abs(cos_c * cos_d));
  }
  bool is_of_group(Index vertex) const {
    return std::find(group_.begin(), group_.end(), vertex) != group_.end();
  }

  CompleteMatching& matching_;
  SurfaceMesh& mesh_;
  std::vector<Kind> kind_;  // per face
  Vec3 origin_ = Vec3::Zero(), u_ = Vec3::UnitX(), v_ = Vec3::UnitY();
  std::vector<Index> group_;  // the sample and its copies, as far as they are vertices
  std::vector<Index> stack_;  // half-edges
};

}  // namespace

void insert_near_copies(CompleteMatching& matching, const PointCloud& cloud,
                        const std::vector<Vec3>& points, Progress& progress) {
  const std::vector<NearCopy>& copies = cloud.conditioning.near_copies;
  if (copies.empty()) return;
  std::vector<Index> sample_of_input(points.size(), kNone);
  for (Index i = 0; i < cloud.size(); ++i) sample_of_input[cloud.input_index[i]] = i;

  NearCopyInserter inserter(matching);
  std::vector<Vec3> places;
  matching.sample_of_vertex.resize(matching.mesh.position.size(), SampleId::none);
  const Index count = static_cast<Index>(copies.size());
  for (Index begin = 0, end = 0; begin < count; begin = end) {  // they come by their originals
    progress.update(static_cast<double>(begin) / count);
    places.clear();
    for (; end < count && copies[end].original == copies[begin].original; ++end) {
      places.push_back(cloud.frame.to_unit(points[copies[end].copy]));
      matching.sample_of_vertex.push_back(to_sample(cloud.size() + end));
    }
    inserter.insert(sample_of_input[copies[begin].original], places);
  }
}

}  // namespace shrinkwrap
