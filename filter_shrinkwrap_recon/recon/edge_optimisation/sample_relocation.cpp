#include "edge_optimisation/sample_relocation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

#include "geometry/exact_predicates.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

constexpr std::size_t kMostFaces = 64;    // around a vertex that is relocated
constexpr std::size_t kMostPlaces = 64;   // faces that are tried for it, the nearest
constexpr double kWeightOfLength = 1e-3;  // of the edge that cuts off an ear, beside its bending
constexpr std::ptrdiff_t kAny = std::numeric_limits<std::ptrdiff_t>::max();

class Relocation {
 public:
  using Pair = FaceMeetings::Pair;

  Relocation(SurfaceMesh& mesh, FaceMeetings& meetings, Index v,
             const std::vector<Index>& fixed_faces, const RelocationLimits& limits)
      : mesh_(mesh), meetings_(meetings), v_(v), fixed_faces_(fixed_faces), limits_(limits) {
    mesh_.for_each_outgoing(v, [&](Index h) { star_.push_back(SurfaceMesh::face(h)); });
  }

  std::vector<Index> run() {
    if (star_.size() > kMostFaces) return {};
    for (const Index f : star_)
      if (is_fixed(f)) return {};
    const std::ptrdiff_t most =
        static_cast<std::ptrdiff_t>(meetings_.pairs_of(star_).size()) + limits_.most_added;
    if (most < 0) return {};
    if (!cut_ears(most) || !tile_last_face(most)) return undo();
    const Place place = best_place(most);
    if (place.face == kNone) return undo();
    put_into(place);
    std::sort(star_.begin(), star_.end());
    return star_;
  }

 private:
  // A face that takes the vertex.
  struct Place {
    Index face = kNone;
    std::ptrdiff_t change = 0;  // of the number of pairs
    double bending = 0.0;
    std::vector<Pair> pairs;  // of its three parts
  };

  bool is_fixed(Index f) const {
    const auto holds = [f](const std::vector<Index>& faces) {
      return std::binary_search(faces.begin(), faces.end(), f);
    };
    return holds(fixed_faces_) || (limits_.patch && !holds(*limits_.patch));
  }
  bool has_vertex(Index f) const {
    const Triangle t = mesh_.triangle(f);
    return t[0] == v_ || t[1] == v_ || t[2] == v_;
  }
  Vec3 normal_of(const Triangle& t) const {
    return unit_or_zero((at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])));
  }
  const Vec3& at(Index vertex) const { return mesh_.position[vertex]; }
  bool is_sound(const Triangle& t) const {
    return relative_height(at(t[0]), at(t[1]), at(t[2])) >= limits_.least_height &&
           projection_axis(at(t[0]), at(t[1]), at(t[2])) != kNone;
  }
  double bending(Index a, Index b, const Vec3& normal, const Vec3& other) const {
    return (at(b) - at(a)).norm() * (1.0 - normal.dot(other));
  }
  // Towards the face on the other side of a half-edge.
  double bending_across(Index h, const Vec3& normal) const {
    return bending(mesh_.origin(h), mesh_.target(h), normal,
                   normal_of(mesh_.triangle(SurfaceMesh::face(mesh_.twin(h)))));
  }

  void update_boxes(Index h) {
    meetings_.update_boxes({SurfaceMesh::face(h), SurfaceMesh::face(mesh_.twin(h))});
  }
  std::vector<Index> undo() {
    for (; !flipped_.empty(); flipped_.pop_back()) {
      mesh_.flip_back(flipped_.back());
      update_boxes(flipped_.back());
    }
    return {};
  }

  // Appends the pairs of a tile of the ring, the vertex being out; false if they are too many.
  bool find(const Triangle& tile, Index slot, std::ptrdiff_t most, std::vector<Pair>& pairs) const {
    const auto has_vertex = [this](Index f) { return this->has_vertex(f); };
    return meetings_.find(tile, slot, static_cast<std::size_t>(most), has_vertex, pairs);
  }

  // All with the most pairs that may be left.
  bool cut_ears(std::ptrdiff_t most);
  bool tile_last_face(std::ptrdiff_t most);
  Place best_place(std::ptrdiff_t most) const;
  std::ptrdiff_t pair_count() const { return static_cast<std::ptrdiff_t>(pairs_.size()); }
  bool rate(Index f, const Place& best, Place& place) const;
  void put_into(const Place& place);

  SurfaceMesh& mesh_;
  FaceMeetings& meetings_;
  Index v_;
  const std::vector<Index>& fixed_faces_;  // ascending
  const RelocationLimits& limits_;
  std::vector<Index> star_;            // faces around the vertex at first, later all that changed
  std::vector<Index> flipped_;         // its edges that ears were cut off with
  std::vector<Triangle> tiles_;        // of the ring; the last still has the vertex in it
  std::array<Index, 3> last_three_{};  // faces around the vertex: slots of the last tile ...
                                       // ... and of the second and third part of a place
  std::vector<Pair> pairs_;            // of the tiles
};

// Flips edges away from the vertex until it has three. False if more pairs come of it than may.
bool Relocation::cut_ears(std::ptrdiff_t most) {
  for (std::size_t faces = star_.size(); faces > 3; --faces) {
    Index best = kNone;
    Triangle best_ear{};
    std::vector<Pair> best_pairs, pairs;
    double best_bending = 0.0;
    mesh_.for_each_outgoing(v_, [&](Index h) {
      if (!mesh_.is_flip_legal(h)) return;
      const Index o = mesh_.twin(h), slot = SurfaceMesh::face(o);
      const Triangle ear = {mesh_.opposite(h), mesh_.opposite(o), mesh_.target(h)};
      if (!is_sound(ear)) return;
      const Vec3 normal = normal_of(ear);
      const double bending = kWeightOfLength * (at(ear[0]) - at(ear[1])).norm() +
                             bending_across(SurfaceMesh::next(h), normal) +
                             bending_across(SurfaceMesh::prev(o), normal);
      std::ptrdiff_t most_of_ear = kAny;
      if (best != kNone) {
        const bool bends_less = bending < best_bending;
        most_of_ear = static_cast<std::ptrdiff_t>(best_pairs.size()) - (bends_less ? 0 : 1);
      }
      pairs.clear();
      if (most_of_ear < 0 || !find(ear, slot, most_of_ear, pairs)) return;
      best = h;
      best_ear = ear;
      best_pairs.swap(pairs);
      best_bending = bending;
    });
    if (best == kNone) return false;
    mesh_.flip(best);
    update_boxes(best);
    flipped_.push_back(best);
    tiles_.push_back(best_ear);
    pairs_.insert(pairs_.end(), best_pairs.begin(), best_pairs.end());
    if (pair_count() > most) return false;
  }
  return true;
}

// The face that the last three become.
bool Relocation::tile_last_face(std::ptrdiff_t most) {
  if (!mesh_.is_move_legal(v_)) return false;
  const Index h = mesh_.outgoing(v_), g = mesh_.rotate(h), k = mesh_.rotate(g);
  last_three_ = {SurfaceMesh::face(h), SurfaceMesh::face(g), SurfaceMesh::face(k)};
  const Triangle last = {mesh_.target(h), mesh_.target(g), mesh_.target(k)};
  if (!is_sound(last)) return false;
  if (!find(last, last_three_[0], most - pair_count(), pairs_)) return false;
  tiles_.push_back(last);
  return true;
}

// Rates a face as a place. False if it is no better than the best: it adds more pairs, or as many
// and bends no less.
bool Relocation::rate(Index f, const Place& best, Place& place) const {
  const Triangle t = mesh_.triangle(f);
  std::array<Triangle, 3> part;
  std::array<Vec3, 3> normal;
  for (std::size_t i = 0; i < 3; ++i) {
    part[i] = {t[i], t[(i + 1) % 3], v_};
    if (!is_sound(part[i])) return false;
    normal[i] = normal_of(part[i]);
  }
  place.face = f;
  place.bending = 0.0;
  place.pairs.clear();
  for (std::size_t i = 0; i < 3; ++i)
    place.bending += bending(v_, t[i], normal[i], normal[(i + 2) % 3]) +
                     bending_across(3 * f + static_cast<Index>(i), normal[i]);

  // The pairs of the face go; what is known of the faces around the vertex is of no account.
  const auto was_around = [&](Index g) {
    return std::find(star_.begin(), star_.end(), g) != star_.end();
  };
  const bool bends_less = best.face == kNone || place.bending < best.bending;
  const std::ptrdiff_t most = bends_less ? best.change : best.change - 1;
  std::ptrdiff_t gone = 0;
  for (const auto& [tile, g] : pairs_) gone += tile == f || g == f ? 1 : 0;
  if (!was_around(f))
    for (const Index g : meetings_.faces_met_by(f)) gone += was_around(g) ? 0 : 1;
  const std::array<Index, 3> slot = {f, last_three_[1], last_three_[2]};
  const auto skip = [&](Index g) { return g == f || has_vertex(g); };
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (meetings_.meet(part[i], part[j])) place.pairs.emplace_back(slot[i], slot[j]);
    if (meetings_.meet(part[i], tiles_.back())) place.pairs.emplace_back(slot[i], last_three_[0]);
    const std::ptrdiff_t left = most + gone - static_cast<std::ptrdiff_t>(place.pairs.size());
    if (left < 0 ||
        !meetings_.find(part[i], slot[i], static_cast<std::size_t>(left), skip, place.pairs))
      return false;
  }
  place.change = static_cast<std::ptrdiff_t>(place.pairs.size()) - gone;
  return true;
}

// The place where the fewest pairs are added, not too many beside those of the tiles; no face if
// there is none.
Relocation::Place Relocation::best_place(std::ptrdiff_t most) const {
  std::vector<Triangle> area = tiles_;
  for (const Index f : last_three_) area.push_back(mesh_.triangle(f));
  std::vector<std::pair<double, Index>> by_distance;
  for (const Index f : meetings_.faces_around(area)) {
    if (has_vertex(f) || is_fixed(f)) continue;
    const Triangle t = mesh_.triangle(f);
    const Vec3 middle = (at(t[0]) + at(t[1]) + at(t[2])) / 3.0;
    by_distance.emplace_back((at(v_) - middle).squaredNorm(), f);
  }
  const std::size_t count = std::min(by_distance.size(), kMostPlaces);
  std::partial_sort(by_distance.begin(), by_distance.begin() + count, by_distance.end());
  Place best, place;
  best.change = most - pair_count();
  for (std::size_t i = 0; i < count; ++i)
    if (rate(by_distance[i].second, best, place)) std::swap(best, place);
  return best;
}

void Relocation::put_into(const Place& place) {
  mesh_.move_vertex(v_, place.face);
  if (std::find(star_.begin(), star_.end(), place.face) == star_.end()) star_.push_back(place.face);
  std::vector<Pair> pairs = place.pairs;
  for (const auto& [tile, g] : pairs_)
    if (tile != place.face && g != place.face) pairs.emplace_back(tile, g);
  meetings_.update_boxes(star_);
  meetings_.replace(star_, pairs);
}

}  // namespace

std::vector<Index> relocate_sample(SurfaceMesh& mesh, FaceMeetings& meetings, Index v,
                                   const std::vector<Index>& fixed_faces,
                                   const RelocationLimits& limits) {
  return Relocation(mesh, meetings, v, fixed_faces, limits).run();
}

}  // namespace shrinkwrap
