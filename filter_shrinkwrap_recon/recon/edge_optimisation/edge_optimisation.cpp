#include "edge_optimisation/edge_optimisation.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/triangle_geometry.h"
#include "mesh/delaunay_flips.h"
#include "mesh/quadric.h"
#include "mesh/vertex_blocks.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr Index kLooksPerEdge = 30;
constexpr Index kProgressStride = 1 << 12;

// The two faces of an edge before and after its flip: (a, b, c) and (b, a, d) become (d, c, a) and
// (c, d, b).
struct Hinge {
  Hinge(const SurfaceMesh& mesh, Index h)
      : diagonal(h),
        opposite_diagonal(mesh.twin(h)),
        side{SurfaceMesh::next(h), SurfaceMesh::prev(h), SurfaceMesh::next(opposite_diagonal),
             SurfaceMesh::prev(opposite_diagonal)},
        corner{mesh.origin(h), mesh.origin(opposite_diagonal), mesh.opposite(h),
               mesh.opposite(opposite_diagonal)} {}
  Index diagonal, opposite_diagonal;
  std::array<Index, 4> side;    // bc, ca, ad, db
  std::array<Index, 4> corner;  // a, b, c, d
};

std::vector<Vec3f> normals_of_vertices(const SurfaceMesh& mesh,
                                       const std::vector<Vec3>* guide_normals, Progress& progress) {
  std::vector<Vec3f> normals(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
    normals[v] = (guide_normals ? (*guide_normals)[v] : mesh.vertex_normal(v)).cast<float>();
  });
  return normals;
}

// The angle between two unit normals. From the chord, which is well conditioned at small angles:
// arc sine (chord / 2) = quarter turn - arc cosine (chord / 2).
double angle_of_chord(double chord) {
  return 2.0 * std::max(kHalfPi - arc_cosine_of_positive(0.5 * chord), 0.0);
}
float angle_between(const Vec3f& m, const Vec3f& n) {
  return static_cast<float>(angle_of_chord(static_cast<double>((m - n).norm())));
}
double angle_between(const Vec3& m, const Vec3& n) {
  return angle_of_chord((m - n).norm());
}

// Length x |dihedral angle| of five edges, and the shape of two triangles. What a flip needs of
// the present state is kept: the unit normal and shape of each face, the bending of each edge.
class BendingCriterion {
 public:
  BendingCriterion(SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                   std::vector<Vec3f> guide, Progress& progress)
      : mesh_(mesh),
        shape_weight_(options.shape_weight),
        least_gain_(options.least_gain),
        guide_(std::move(guide)),
        normal_(mesh.face_slots()),
        shape_(mesh.face_slots()),
        bending_(mesh.halfedge_slots()) {
    parallel_for_each(mesh.face_slots(), kGrain, progress, [&](Index f) {
      const Triangle t = mesh.triangle(f);
      const Vec3 &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
      const Vec3 area = (b - a).cross(c - a);
      const double twice_area = area.norm();
      shape_[f] = shape_of((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm(),
                           twice_area);
      normal_[f] = normal_of(area, twice_area, shape_[f]);
    });
    parallel_for_each(mesh.halfedge_slots(), 3 * kGrain, progress, [&](Index h) {
      const Index o = mesh.twin(h);
      if (o < h) return;
      const double length = (mesh.position[mesh.origin(h)] - mesh.position[mesh.origin(o)]).norm();
      set_bending(h, static_cast<float>(length) * angle_between(normal_[SurfaceMesh::face(h)],
                                                                normal_[SurfaceMesh::face(o)]));
    });
  }

  bool try_flip(const Hinge& hinge) {
    const auto [bc, ca, ad, db] = hinge.side;
    const Vec3 &a = mesh_.position[hinge.corner[0]], &b = mesh_.position[hinge.corner[1]],
               &c = mesh_.position[hinge.corner[2]], &d = mesh_.position[hinge.corner[3]];
    const Index first = SurfaceMesh::face(hinge.diagonal),
                second = SurfaceMesh::face(hinge.opposite_diagonal);
    const Vec3 to_c = c - d, to_a = a - d, to_b = b - d;
    const Vec3 area_first = to_c.cross(to_a), area_second = to_b.cross(to_c);
    const double twice_first = area_first.norm(), twice_second = area_second.norm();
    const double cd2 = to_c.squaredNorm(), ad2 = to_a.squaredNorm(), db2 = to_b.squaredNorm(),
                 ca2 = (c - a).squaredNorm(), bc2 = (b - c).squaredNorm();
    const float shape_first = shape_of(cd2 + ca2 + ad2, twice_first),
                shape_second = shape_of(cd2 + bc2 + db2, twice_second);
    const double length_cd = std::sqrt(cd2), length_ca = std::sqrt(ca2), length_ad = std::sqrt(ad2),
                 length_bc = std::sqrt(bc2), length_db = std::sqrt(db2);
    const double mean_length =
        ((a - b).norm() + length_cd + length_ca + length_ad + length_bc + length_db) / 6.0;
    const float before =
        bending_[hinge.diagonal] + bending_[bc] + bending_[ca] + bending_[ad] + bending_[db];
    const float shape_gain = shape_[first] + shape_[second] - shape_first - shape_second;
    // The bending after the flip must stay below this. Slivers of collinear vertices bend any way:
    // among them edges become shorter, until one has a face of some area beside it.
    const bool are_slivers =
        std::min({shape_[first], shape_[second], shape_first, shape_second}) >= kWorstShape;
    const float limit =
        are_slivers
            ? (cd2 < (1.0 - least_gain_) * (a - b).squaredNorm() ? 1e30f : 0.0f)
            : before + static_cast<float>(mean_length * (shape_weight_ * shape_gain - least_gain_));
    if (!(limit > 0.0f)) return false;

    const Vec3f normal_first = normal_of(area_first, twice_first, shape_first),
                normal_second = normal_of(area_second, twice_second, shape_second);
    const Vec3f guide = guide_[hinge.corner[0]] + guide_[hinge.corner[1]] +
                        guide_[hinge.corner[2]] + guide_[hinge.corner[3]];
    if (!keeps_side(normal_[first], normal_[second], normal_first, normal_second, guide))
      return false;

    const float bending_cd =
        static_cast<float>(length_cd) * angle_between(normal_first, normal_second);
    if (!(bending_cd < limit)) return false;
    const auto beyond = [&](Index h) { return normal_[SurfaceMesh::face(mesh_.twin(h))]; };
    const float bending_ca =
                    static_cast<float>(length_ca) * angle_between(normal_first, beyond(ca)),
                bending_ad =
                    static_cast<float>(length_ad) * angle_between(normal_first, beyond(ad)),
                bending_bc =
                    static_cast<float>(length_bc) * angle_between(normal_second, beyond(bc)),
                bending_db =
                    static_cast<float>(length_db) * angle_between(normal_second, beyond(db));
    if (!(bending_cd + bending_ca + bending_ad + bending_bc + bending_db < limit)) return false;
    if (!mesh_.is_flip_legal(hinge.diagonal)) return false;

    mesh_.flip(hinge.diagonal);
    normal_[first] = normal_first;
    normal_[second] = normal_second;
    shape_[first] = shape_first;
    shape_[second] = shape_second;
    // The sides have moved round by one: see SurfaceMesh::flip.
    set_bending(hinge.diagonal, bending_cd);
    set_bending(bc, bending_ca);
    set_bending(ca, bending_ad);
    set_bending(ad, bending_db);
    set_bending(db, bending_bc);
    return true;
  }

 private:
  static constexpr float kWorstShape = 1e4f;

  static float shape_of(double squared_sides, double twice_area) {
    return static_cast<float>(
        std::min(squared_sides / (2.0 * twice_area + 1e-300), double{kWorstShape}));
  }

  // Unit; zero for a sliver, whose normal is that of rounding.
  static Vec3f normal_of(const Vec3& area, double twice_area, float shape) {
    if (!(shape < kWorstShape)) return Vec3f::Zero();
    return Vec3(area / twice_area).cast<float>();
  }

  void set_bending(Index h, float bending) { bending_[h] = bending_[mesh_.twin(h)] = bending; }

  SurfaceMesh& mesh_;
  double shape_weight_, least_gain_;
  std::vector<Vec3f> guide_;    // per vertex
  std::vector<Vec3f> normal_;   // per face, unit; zero for slivers
  std::vector<float> shape_;    // per face
  std::vector<float> bending_;  // per half-edge, the same for twins
};

// The quadric cost of an edge against that of the opposite diagonal, with the quadrics of the mesh
// as given: every edge has one cost for good, so that the flips come to an end.
class QuadricCriterion {
 public:
  QuadricCriterion(SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                   std::vector<Vec3f> guide, Progress& progress)
      : mesh_(mesh),
        least_gain_(options.least_gain),
        guide_(std::move(guide)),
        quadric_(mesh.position.size()) {
    parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
      Quadric& quadric = quadric_[v];
      mesh.for_each_outgoing(v, [&](Index h) {
        const Vec3 normal = unit_or_zero(mesh.area_vector(SurfaceMesh::face(h)));
        quadric.add_plane(normal, -normal.dot(mesh.position[v]), 1.0);
      });
    });
  }

  bool try_flip(const Hinge& hinge) {
    const auto [a, b, c, d] = hinge.corner;
    const double before = cost(a, b), after = cost(c, d);
    const double squared_length = (mesh_.position[a] - mesh_.position[b]).squaredNorm();
    if (!(after < before - least_gain_ * squared_length)) return false;
    const Vec3 &pa = mesh_.position[a], &pb = mesh_.position[b], &pc = mesh_.position[c],
               &pd = mesh_.position[d];
    const Vec3 old_first = unit_or_zero((pb - pa).cross(pc - pa)),
               old_second = unit_or_zero((pa - pb).cross(pd - pb)),
               new_first = unit_or_zero((pc - pd).cross(pa - pd)),
               new_second = unit_or_zero((pd - pc).cross(pb - pc));
    const Vec3 guide = (guide_[a] + guide_[b] + guide_[c] + guide_[d]).cast<double>();
    if (!keeps_side(old_first, old_second, new_first, new_second, guide)) return false;
    if (!mesh_.is_flip_legal(hinge.diagonal)) return false;
    mesh_.flip(hinge.diagonal);
    return true;
  }

 private:
  // Eq. 12 at the point where the edge would be contracted to.
  double cost(Index v, Index w) const {
    Quadric sum = quadric_[v];
    sum += quadric_[w];
    return sum.cost(sum.best_position(mesh_.position[v], mesh_.position[w]));
  }

  SurfaceMesh& mesh_;
  double least_gain_;
  std::vector<Vec3f> guide_;
  std::vector<Quadric> quadric_;  // per vertex
};

// Delaunay, but for creases: see EdgeOptimisationOptions.
class DelaunayCriterion {
 public:
  DelaunayCriterion(SurfaceMesh& mesh, const EdgeOptimisationOptions& options)
      : mesh_(mesh),
        crease_cosine_(std::cos(options.crease_angle)),
        least_cosine_(std::cos(options.least_angle)),
        most_bending_(options.most_bending) {}

  bool try_flip(const Hinge& hinge) {
    if (!wants_delaunay_flip(mesh_, hinge.diagonal)) return false;
    const auto [ia, ib, ic, id] = hinge.corner;
    const Vec3 &a = mesh_.position[ia], &b = mesh_.position[ib], &c = mesh_.position[ic],
               &d = mesh_.position[id];
    const Vec3 old_first = normal_of(hinge.diagonal),
               old_second = normal_of(hinge.opposite_diagonal),
               new_first = unit_or_zero((c - d).cross(a - d)),
               new_second = unit_or_zero((b - d).cross(c - d));
    // In the order of Hinge::side.
    std::array<Vec3, 4> beyond;
    for (int k = 0; k < 4; ++k) beyond[k] = normal_of(mesh_.twin(hinge.side[k]));
    const std::array<const Vec3*, 4> before = {&old_first, &old_first, &old_second, &old_second},
                                     after = {&new_second, &new_first, &new_first, &new_second};
    for (int k = 0; k < 4; ++k)
      if (is_creased(after[k]->dot(beyond[k]), before[k]->dot(beyond[k]))) return false;

    const double narrowest =
        std::max(cosine_of_smallest_angle(d, c, a), cosine_of_smallest_angle(c, d, b));
    if (narrowest > least_cosine_ || old_first.dot(old_second) < crease_cosine_) {
      const std::array<double, 4> length = {(c - b).norm(), (a - c).norm(), (d - a).norm(),
                                            (b - d).norm()};
      double bending_before = (b - a).norm() * angle_between(old_first, old_second),
             bending_after = (d - c).norm() * angle_between(new_first, new_second);
      for (int k = 0; k < 4; ++k) {
        bending_before += length[k] * angle_between(*before[k], beyond[k]);
        bending_after += length[k] * angle_between(*after[k], beyond[k]);
      }
      if (!(bending_after <= most_bending_ * bending_before)) return false;
    }
    if (!mesh_.is_flip_legal(hinge.diagonal)) return false;
    mesh_.flip(hinge.diagonal);
    return true;
  }

 private:
  Vec3 normal_of(Index h) const { return unit_or_zero(mesh_.area_vector(SurfaceMesh::face(h))); }
  bool is_creased(double cosine_after, double cosine_before) const {
    return cosine_after < std::min(cosine_before, crease_cosine_);
  }

  SurfaceMesh& mesh_;
  double crease_cosine_, least_cosine_, most_bending_;
};

// Where the diagonals ab and cd of a hinge pass each other.
struct Crossing {
  bool is_inside = false;           ///< of both diagonals; nothing else is known if not
  double on_ab = 0.0, on_cd = 0.0;  ///< the nearest points are a + on_ab (b - a), c + on_cd (d - c)
  Vec3 middle, across;              ///< between these points; unit, square to both diagonals
  double gap = 0.0;                 ///< of cd over ab, along `across`
  double relative_gap = 0.0;        ///< |gap|, x the geometric mean of their lengths
};

Crossing crossing_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  constexpr double kLeastSine = 1e-3;  // between the diagonals
  constexpr double kLeastPart = 0.02;  // of a diagonal, on either side
  Crossing crossing;
  const Vec3 ab = b - a, cd = d - c, ac = c - a;
  const Vec3 normal = ab.cross(cd);
  const double ab_ab = ab.squaredNorm(), ab_cd = ab.dot(cd), cd_cd = cd.squaredNorm();
  const double determinant = normal.squaredNorm();
  if (!(determinant > kLeastSine * kLeastSine * ab_ab * cd_cd)) return crossing;
  const double s = crossing.on_ab = (ab.dot(ac) * cd_cd - cd.dot(ac) * ab_cd) / determinant;
  const double t = crossing.on_cd = (ab.dot(ac) * ab_cd - cd.dot(ac) * ab_ab) / determinant;
  crossing.is_inside = std::min(s, t) > kLeastPart && std::max(s, t) < 1.0 - kLeastPart;
  crossing.middle = 0.5 * (a + s * ab + c + t * cd);
  crossing.across = normal / std::sqrt(determinant);
  crossing.gap = crossing.across.dot(ac);
  crossing.relative_gap = std::abs(crossing.gap) / std::sqrt(std::sqrt(ab_ab * cd_cd));
  return crossing;
}

// Which gaps are large: see EdgeOptimisationOptions::least_gap and those after it.
struct LargeGaps {
  double least_relative = 0.0, least_absolute = 0.0;  ///< either will do
  bool has(const Crossing& crossing) const {
    constexpr double kRounding = 1e-5;  // relative
    return crossing.is_inside && crossing.relative_gap >= kRounding &&
           (crossing.relative_gap >= least_relative || std::abs(crossing.gap) >= least_absolute);
  }
};

// As the gaps of all hinges tell, or of evenly spread ones where there are many.
LargeGaps large_gaps_of(const SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                        Progress& progress) {
  LargeGaps large;
  if (!(options.least_gap > 0.0)) return large;
  constexpr Index kProbes = 1 << 16;
  const Index stride = std::max<Index>(mesh.halfedge_slots() / kProbes, 1) | 1;
  std::vector<Crossing> crossings(static_cast<std::size_t>(mesh.halfedge_slots() / stride));
  parallel_for_each(static_cast<Index>(crossings.size()), kGrain, progress, [&](Index n) {
    const auto [a, b, c, d] = Hinge(mesh, n * stride).corner;
    crossings[n] =
        crossing_of(mesh.position[a], mesh.position[b], mesh.position[c], mesh.position[d]);
  });
  std::vector<double> relative, absolute;
  for (const Crossing& crossing : crossings) {
    if (!crossing.is_inside) continue;
    relative.push_back(crossing.relative_gap);
    absolute.push_back(std::abs(crossing.gap));
  }
  // The least of the largest ones that are this share of all.
  const auto least_of_largest = [](std::vector<double>& gaps, double share) {
    const double count = std::round(std::min(share, 1.0) * static_cast<double>(gaps.size()));
    if (!(count >= 1.0)) return std::numeric_limits<double>::infinity();
    const auto nth = gaps.end() - static_cast<std::ptrdiff_t>(count);
    std::nth_element(gaps.begin(), nth, gaps.end());
    return *nth;
  };
  const double median = relative.empty() ? 0.0 : least_of_largest(relative, 0.5);
  large.least_relative = std::max(options.least_gap, options.gap_over_median * median);
  large.least_absolute = median < options.rough_gap
                             ? least_of_largest(absolute, options.largest_gaps)
                             : std::numeric_limits<double>::infinity();
  return large;
}

// The diagonal nearer to the surface: see EdgeOptimisationOptions::least_gap. Along a diagonal the
// height of the surface is a parabola, for which the mean of an end's height and that of its
// tangent plane, weighted by the distance to the other end, is exact. Over the middle between the
// diagonals the heights of the four ends come to nothing: the planes decide. They are those of the
// faces around the hinge: its own two lean towards the diagonal that is there.
class TangentPlaneCriterion {
 public:
  TangentPlaneCriterion(SurfaceMesh& mesh, const LargeGaps& large_gaps)
      : mesh_(mesh), large_gaps_(large_gaps), flips_(mesh.halfedge_slots(), 0) {}

  bool try_flip(const Hinge& hinge) {
    const auto [a, b, c, d] = hinge.corner;
    const Crossing crossing =
        crossing_of(mesh_.position[a], mesh_.position[b], mesh_.position[c], mesh_.position[d]);
    if (!large_gaps_.has(crossing)) return false;
    if (flips_[hinge.diagonal] == kMostFlips) return false;
    std::array<Vec3, 4> normal;
    Vec3 outward = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      normal[k] = normal_around(hinge, hinge.corner[k]);
      outward += normal[k];
    }
    const double side = crossing.across.dot(outward) < 0.0 ? -1.0 : 1.0;
    const double height = height_of_surface(hinge, normal, crossing, side * crossing.across);
    if (!(height * side * crossing.gap > kLeastHeight * crossing.gap * crossing.gap)) return false;
    if (!keeps_shape(hinge, outward)) return false;
    if (!mesh_.is_flip_legal(hinge.diagonal)) return false;
    flip(hinge);
    return true;
  }

 private:
  // To flip, the surface passes so far beyond the middle of the gap towards the diagonal that would
  // be new, x the gap. That diagonal is at 0.5; what is told of less is as often wrong as right.
  static constexpr double kLeastHeight = 0.15;

  // Of one edge: each flip changes the normals around, and some hinges would take turns for ever.
  static constexpr std::uint8_t kMostFlips = 2;

  void flip(const Hinge& hinge) {
    const auto [bc, ca, ad, db] = hinge.side;
    const std::uint8_t of_ca = flips_[ca], of_ad = flips_[ad], of_db = flips_[db],
                       of_bc = flips_[bc];
    mesh_.flip(hinge.diagonal);
    const auto set = [&](Index h, std::uint8_t flips) {
      flips_[h] = flips_[mesh_.twin(h)] = flips;
    };
    // The sides have moved round by one: see SurfaceMesh::flip.
    set(hinge.diagonal, static_cast<std::uint8_t>(flips_[hinge.diagonal] + 1));
    set(bc, of_ca);
    set(ca, of_ad);
    set(ad, of_db);
    set(db, of_bc);
  }

  // Unit normal of the faces at a corner, but for those of the hinge; zero if there are none.
  Vec3 normal_around(const Hinge& hinge, Index corner) const {
    const Index first = SurfaceMesh::face(hinge.diagonal),
                second = SurfaceMesh::face(hinge.opposite_diagonal);
    Vec3 area = Vec3::Zero();
    mesh_.for_each_outgoing(corner, [&](Index h) {
      const Index f = SurfaceMesh::face(h);
      if (f != first && f != second) area += mesh_.area_vector(f);
    });
    return unit_or_zero(area);
  }

  // Of the surface over the middle of the crossing: half of what the planes have there, which are
  // weighted by the nearness of their vertices, mean of both diagonals.
  double height_of_surface(const Hinge& hinge, const std::array<Vec3, 4>& normal,
                           const Crossing& crossing, const Vec3& up) const {
    constexpr double kLeastCosine = 0.3;  // steeper planes count as this steep
    const std::array<double, 4> weight = {1.0 - crossing.on_ab, crossing.on_ab,
                                          1.0 - crossing.on_cd, crossing.on_cd};
    double height = 0.0;
    for (int k = 0; k < 4; ++k)
      height += weight[k] * normal[k].dot(mesh_.position[hinge.corner[k]] - crossing.middle) /
                std::max(normal[k].dot(up), kLeastCosine);
    return 0.25 * height;
  }

  // No face turned away, no sliver, nearly Delaunay.
  bool keeps_shape(const Hinge& hinge, const Vec3& outward) const {
    // A sliver is told by its narrowest angle; one that is there may become another, less narrow.
    static const double least_angle_cosine = std::cos(8.0 * kPi / 180.0);
    constexpr double kMostAtEnds = 260.0 * kPi / 180.0;
    const Vec3 &a = mesh_.position[hinge.corner[0]], &b = mesh_.position[hinge.corner[1]],
               &c = mesh_.position[hinge.corner[2]], &d = mesh_.position[hinge.corner[3]];
    if (!(std::min((c - d).cross(a - d).dot(outward), (b - d).cross(c - d).dot(outward)) > 0.0))
      return false;
    const double narrowest =
        std::max(cosine_of_smallest_angle(d, c, a), cosine_of_smallest_angle(c, d, b));
    if (narrowest > least_angle_cosine &&
        narrowest > std::max(cosine_of_smallest_angle(a, b, c), cosine_of_smallest_angle(b, a, d)))
      return false;
    // Opposite to a Delaunay edge cd the angles sum to no more than a half turn.
    const auto angle = [](const Vec3& u, const Vec3& v) {
      return std::atan2(u.cross(v).norm(), u.dot(v));
    };
    return angle(c - a, b - a) + angle(d - a, b - a) + angle(c - b, a - b) + angle(d - b, a - b) <=
           kMostAtEnds;
  }

  SurfaceMesh& mesh_;
  LargeGaps large_gaps_;
  std::vector<std::uint8_t> flips_;  // of edges, per half-edge, the same for twins
};

// Looks at every edge, and again at those around each flip, until no flip helps.
template <class Criterion>
Index flip_all(SurfaceMesh& mesh, Criterion& criterion, const VertexBlocks& blocks,
               const std::vector<Index>& fixed_faces, Progress& progress) {
  std::vector<char> is_queued(mesh.halfedge_slots(), 0);  // by the lower half-edge of an edge
  std::vector<char> is_fixed(fixed_faces.empty() ? 0 : mesh.face_slots(), 0);
  for (const Index f : fixed_faces) is_fixed[f] = 1;
  SharedCount flips;

  const auto seed = [&](Index v, std::vector<Index>& edges) {
    mesh.for_each_outgoing(v, [&](Index h) {
      if (h < mesh.twin(h)) edges.push_back(h);
    });
  };
  const auto anchor = [&](Index h) { return mesh.origin(h); };
  const auto work = [&](const BlockOwner& owner, std::vector<Index>& edges) {
    std::vector<Index> queue, deferred;
    queue.reserve(edges.size());
    const auto add = [&](Index h) {
      const Index edge = std::min(h, mesh.twin(h));
      if (!owner.owns(mesh.origin(h)) || !owner.owns(mesh.target(h))) {
        deferred.push_back(edge);
      } else if (!is_queued[edge]) {
        is_queued[edge] = 1;
        queue.push_back(edge);
      }
    };
    for (const Index edge : edges) add(edge);
    const std::size_t limit = kLooksPerEdge * (queue.size() + 8);
    Index flipped = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const Index h = queue[head];
      is_queued[h] = 0;
      if (head >= limit) continue;
      if (owner.is_last() && head % kProgressStride == 0)
        progress.update(static_cast<double>(head) / static_cast<double>(queue.size()));
      if (mesh.twin(h) < h) continue;  // another edge by now, which was added when it changed
      const Hinge hinge(mesh, h);
      const auto [a, b, c, d] = hinge.corner;
      if (c == d) continue;
      if (!owner.owns(c) || !owner.owns(d)) {
        deferred.push_back(h);
        continue;
      }
      if (!is_fixed.empty() && (is_fixed[SurfaceMesh::face(hinge.diagonal)] ||
                                is_fixed[SurfaceMesh::face(hinge.opposite_diagonal)]))
        continue;
      if (!criterion.try_flip(hinge)) continue;
      ++flipped;
      add(h);
      for (const Index side : hinge.side) {
        add(side);
        const Index beyond = mesh.twin(side);
        add(SurfaceMesh::next(beyond));
        add(SurfaceMesh::prev(beyond));
      }
    }
    flips.add(flipped);
    edges.swap(deferred);
  };
  run_in_blocks(blocks, progress, seed, anchor, work);
  return flips.get();
}

}  // namespace

EdgeOptimisationReport optimise_edges(SurfaceMesh& mesh, const EdgeOptimisationOptions& options,
                                      Progress& progress, const std::vector<Index>& fixed_faces,
                                      const std::vector<Vec3>* guide_normals) {
  progress.begin(Stage::edge_optimisation);
  progress.set_range(0.0, 0.2);
  std::vector<Vec3f> guide = normals_of_vertices(mesh, guide_normals, progress);
  const VertexBlocks blocks(mesh.position, progress);
  EdgeOptimisationReport report;
  const auto flip = [&](auto criterion, double from, double to) {
    progress.set_range(from, to);
    report.flips += flip_all(mesh, criterion, blocks, fixed_faces, progress);
  };
  if (options.criterion == EdgeOptimisationOptions::Criterion::quadric)
    flip(QuadricCriterion(mesh, options, std::move(guide), progress), 0.2, 0.7);
  else
    flip(BendingCriterion(mesh, options, std::move(guide), progress), 0.2, 0.7);
  if (options.crease_angle > 0.0) flip(DelaunayCriterion(mesh, options), 0.7, 0.85);
  if (options.least_gap < 1.0) {
    progress.set_range(0.85, 0.9);
    const LargeGaps large_gaps = large_gaps_of(mesh, options, progress);
    flip(TangentPlaneCriterion(mesh, large_gaps), 0.9, 1.0);
  }
  progress.update(1.0);
  return report;
}

}  // namespace shrinkwrap
