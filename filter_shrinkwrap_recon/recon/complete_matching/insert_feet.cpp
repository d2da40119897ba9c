#include "complete_matching/insert_feet.h"

#include <algorithm>
#include <array>

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr double kMargin = 1e-3;       // barycentric: feet keep this far off edges and corners ...
constexpr double kSpread = 0.1;        // ... and this far off the foot they would coincide with
constexpr double kCoincident = 0.996;  // barycentric: from here on a foot is as good as on a corner

// A point or corner in the plane of the face: weights of its second and third corner.
struct PlanePoint {
  double x, y;
};

double twice_area(const PlanePoint& p, const PlanePoint& q, const PlanePoint& r) {
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

using Weights = std::array<double, 3>;

Weights barycentric(const PlanePoint& p, const PlanePoint& a, const PlanePoint& b,
                    const PlanePoint& c) {
  const double area = twice_area(a, b, c);
  if (!(area > 0.0)) return {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
  const double weight_a = twice_area(p, b, c) / area, weight_b = twice_area(a, p, c) / area;
  return {weight_a, weight_b, 1.0 - weight_a - weight_b};
}

double least(const Weights& weights) {
  return std::min(weights[0], std::min(weights[1], weights[2]));
}

// Moves a point into the inside of its triangle.
Weights kept_inside(Weights weights, bool is_face_of_surface) {
  const double largest = std::max(weights[0], std::max(weights[1], weights[2]));
  const double margin = largest > kCoincident && !is_face_of_surface ? kSpread : kMargin;
  double sum = 0.0;
  for (double& weight : weights) sum += weight = std::max(weight, margin);
  for (double& weight : weights) weight /= sum;
  return weights;
}

// Splits one face of the surface at its feet. Half-edges of the new faces are written to their
// place in the arrays of the whole mesh; those on the outline of the face stay without a twin.
class FaceSplitter {
 public:
  FaceSplitter(std::vector<Index>& origin, std::vector<Index>& twin)
      : origin_(origin), twin_(twin) {}

  // `corner`: the vertices of the face; `slot`: the first of 2 count + 1 face slots.
  void split(const Triangle& corner, Index slot, const SampleFeet& feet, const Index* sample,
             Index count, Index first_foot_vertex) {
    point_.assign({{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}});
    vertex_.assign(corner.begin(), corner.end());
    node_.assign(1, {{0, 1, 2}, slot, kNone});
    for (Index j = 0; j < 3; ++j) {
      origin_[3 * slot + j] = corner[j];
      twin_[3 * slot + j] = kNone;
    }
    // Bit-reversed order: the tree of splits stays shallow for feet that come along a curve.
    Index next_slot = slot + 1, size = 1;
    while (size < count) size *= 2;
    for (Index j = 0, reversed = 0; j < size; ++j) {
      if (reversed < count) {
        insert(feet.foot[sample[reversed]], first_foot_vertex + sample[reversed], next_slot);
        next_slot += 2;
      }
      Index bit = size / 2;
      while (bit > 0 && (reversed & bit)) {
        reversed -= bit;
        bit /= 2;
      }
      reversed += bit;
    }
  }

  // Calls `fn(vertex, point)` for the feet inserted by the last call of split.
  template <class Fn>
  void for_each_foot(const Fn& fn) const {
    for (std::size_t i = 3; i < vertex_.size(); ++i) fn(vertex_[i], point_[i]);
  }

 private:
  struct Node {
    std::array<Index, 3> corner;  // of point_
    Index slot;
    Index first_child;  // three in a row, made by a split; kNone: a face
    Index feet = 0;     // in it
  };

  Weights weights_in(const Node& node, const PlanePoint& p) const {
    return barycentric(p, point_[node.corner[0]], point_[node.corner[1]], point_[node.corner[2]]);
  }

  void insert(const SampleFoot& foot, Index vertex, Index free_slot) {
    PlanePoint p{foot.weight_b, foot.weight_c};
    Index at = 0;
    Weights weights = weights_in(node_[0], p);
    while (node_[at].first_child != kNone) {
      const Index first = node_[at].first_child;
      ++node_[at].feet;
      double best = 0.0;
      for (Index child = first; child < first + 3; ++child) {
        const Weights in_child = weights_in(node_[child], p);
        const double inside = least(in_child);
        // Feet on one corner lie in two children alike: they are spread over both.
        if (child > first && !(inside > best) &&
            !(inside == best && node_[child].feet < node_[at].feet))
          continue;
        at = child;
        weights = in_child;
        best = inside;
      }
    }
    node_[at].feet = 1;
    weights = kept_inside(weights, at == 0);
    const std::array<Index, 3> corner = node_[at].corner;
    p = {0.0, 0.0};
    for (int i = 0; i < 3; ++i) {
      p.x += weights[i] * point_[corner[i]].x;
      p.y += weights[i] * point_[corner[i]].y;
    }
    const Index fresh = static_cast<Index>(point_.size());
    point_.push_back(p);
    vertex_.push_back(vertex);
    const Index slot = node_[at].slot;
    node_[at].first_child = static_cast<Index>(node_.size());
    node_.push_back({{corner[0], corner[1], fresh}, slot, kNone});
    node_.push_back({{corner[1], corner[2], fresh}, free_slot, kNone});
    node_.push_back({{corner[2], corner[0], fresh}, free_slot + 1, kNone});
    split_slot(slot, vertex, free_slot, free_slot + 1);
  }

  // (a, b, c) becomes f = (a, b, v), g = (b, c, v), k = (c, a, v): every face keeps its stretch of
  // the outline as its first half-edge.
  void split_slot(Index f, Index v, Index g, Index k) {
    const Index a = origin_[3 * f], b = origin_[3 * f + 1], c = origin_[3 * f + 2];
    const Index beyond_bc = twin_[3 * f + 1], beyond_ca = twin_[3 * f + 2];
    origin_[3 * f + 2] = v;
    put(g, b, c, v);
    put(k, c, a, v);
    link(3 * g, beyond_bc);
    link(3 * k, beyond_ca);
    link(3 * f + 1, 3 * g + 2);
    link(3 * g + 1, 3 * k + 2);
    link(3 * k + 1, 3 * f + 2);
  }
  void put(Index f, Index a, Index b, Index c) {
    origin_[3 * f] = a;
    origin_[3 * f + 1] = b;
    origin_[3 * f + 2] = c;
  }
  void link(Index h, Index o) {
    twin_[h] = o;
    if (o != kNone) twin_[o] = h;
  }

  std::vector<Index>& origin_;
  std::vector<Index>& twin_;
  std::vector<PlanePoint> point_;  // the three corners, then the feet
  std::vector<Index> vertex_;      // of each point
  std::vector<Node> node_;         // the tree of splits
};

}  // namespace

SurfaceMesh insert_feet(SurfaceMesh surface, const SampleFeet& feet, Progress& progress) {
  const Index faces = surface.face_slots(), vertices = surface.vertex_slots();
  const Index samples = static_cast<Index>(feet.foot.size());
  const auto feet_in = [&](Index f) { return feet.begin[f + 1] - feet.begin[f]; };
  const auto first_slot = [&](Index f) { return f + 2 * feet.begin[f]; };

  std::vector<Vec3> position = std::move(surface.position);
  position.resize(static_cast<std::size_t>(vertices) + samples);
  std::vector<Index> origin(3 * (static_cast<std::size_t>(faces) + 2 * feet.foot.size()));
  std::vector<Index> twin(origin.size());

  parallel_blocks(faces, kGrain, progress, [&](Index, Index begin, Index end) {
    FaceSplitter splitter(origin, twin);
    for (Index f = begin; f < end; ++f) {
      const Triangle t = surface.triangle(f);
      splitter.split(t, first_slot(f), feet, feet.by_face.data() + feet.begin[f], feet_in(f),
                     vertices);
      const Vec3 a = position[t[0]], ab = position[t[1]] - a, ac = position[t[2]] - a;
      splitter.for_each_foot(
          [&](Index v, const PlanePoint& p) { position[v] = a + p.x * ab + p.y * ac; });
    }
  });

  // Twins across the edges of the surface.
  const auto outline = [&](Index h) {
    const Index f = SurfaceMesh::face(h), side = h % 3;
    return feet_in(f) > 0 ? 3 * (first_slot(f) + side) : 3 * first_slot(f) + side;
  };
  parallel_for_each(surface.halfedge_slots(), 3 * kGrain, progress,
                    [&](Index h) { twin[outline(h)] = outline(surface.twin(h)); });
  surface = SurfaceMesh();
  return SurfaceMesh::from_halfedges(std::move(position), std::move(origin), std::move(twin));
}

}  // namespace shrinkwrap
