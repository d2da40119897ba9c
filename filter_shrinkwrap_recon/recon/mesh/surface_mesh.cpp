#include "mesh/surface_mesh.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "common/buckets.h"
#include "common/parallel.h"
#include "common/shared_sets.h"
#include "geometry/morton.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 13;
constexpr std::ptrdiff_t kFewHalfedges = 64;  // at a vertex: few enough to compare all pairs

// What keeps half-edges from being twins of each other.
enum class EdgeDefect { none, same_direction, several_faces, border };

[[noreturn]] void refuse(EdgeDefect defect) {
  switch (defect) {
    case EdgeDefect::same_direction:
      throw InvalidInput(
          "an edge is shared by faces of inconsistent orientation or by more than two faces");
    case EdgeDefect::several_faces:
      throw InvalidInput("an edge is shared by more than two faces");
    default:
      throw InvalidInput("the mesh has a border: an edge has only one face");
  }
}

// Makes twins of the half-edges at one vertex that lead to higher ones or come from there.
EdgeDefect match_at_vertex(const Index* begin, const Index* end, const std::vector<Index>& origin,
                           std::vector<Index>& twin) {
  for (const Index* i = begin; i != end; ++i) {
    const Index h = *i;
    if (twin[h] != kNone) continue;
    const Index from = origin[h], to = origin[SurfaceMesh::next(h)];
    Index match = kNone;
    for (const Index* j = i + 1; j != end; ++j) {
      const Index g = *j;
      const Index g_from = origin[g], g_to = origin[SurfaceMesh::next(g)];
      if (g_from == from && g_to == to) return EdgeDefect::same_direction;
      if (g_from == to && g_to == from) {
        if (match != kNone || twin[g] != kNone) return EdgeDefect::several_faces;
        match = g;
      }
    }
    if (match == kNone) return EdgeDefect::border;
    twin[h] = match;
    twin[match] = h;
  }
  return EdgeDefect::none;
}

// The same in O(n log n), for vertices of many edges.
EdgeDefect match_at_busy_vertex(const Index* begin, const Index* end,
                                const std::vector<Index>& origin, std::vector<Index>& twin) {
  const auto other_end = [&](Index h) { return std::max(origin[h], origin[SurfaceMesh::next(h)]); };
  std::vector<Index> sorted(begin, end);
  std::sort(sorted.begin(), sorted.end(), [&](Index a, Index b) {
    return std::pair(other_end(a), a) < std::pair(other_end(b), b);
  });
  for (const Index *run = sorted.data(), *last = run + sorted.size(); run != last;) {
    const Index* run_end = run;
    while (run_end != last && other_end(*run_end) == other_end(*run)) ++run_end;
    const EdgeDefect found = match_at_vertex(run, run_end, origin, twin);
    if (found != EdgeDefect::none) return found;
    run = run_end;
  }
  return EdgeDefect::none;
}

// The twin of every half-edge. Throws InvalidInput unless every edge has exactly two faces that run
// along it in opposite directions.
std::vector<Index> match_twins(Index vertices, const std::vector<Index>& origin,
                               Progress& progress) {
  const Buckets by_vertex =
      sort_into_buckets(static_cast<Index>(origin.size()), vertices, progress,
                        [&](Index h) { return std::min(origin[h], origin[SurfaceMesh::next(h)]); });
  std::vector<Index> twin(origin.size(), kNone);
  std::vector<EdgeDefect> defect(block_count(vertices, kGrain), EdgeDefect::none);
  parallel_blocks(vertices, kGrain, progress, [&](Index block, Index begin, Index end) {
    const Index* item = by_vertex.item.data();
    for (Index v = begin; v < end && defect[block] == EdgeDefect::none; ++v) {
      const Index *first = item + by_vertex.begin[v], *last = item + by_vertex.begin[v + 1];
      const auto match = last - first > kFewHalfedges ? match_at_busy_vertex : match_at_vertex;
      defect[block] = match(first, last, origin, twin);
    }
  });
  for (const EdgeDefect found : defect)
    if (found != EdgeDefect::none) refuse(found);
  return twin;
}

}  // namespace

SurfaceMesh SurfaceMesh::from_halfedges(std::vector<Vec3> positions, std::vector<Index> origins,
                                        std::vector<Index> twins) {
  SurfaceMesh mesh;
  mesh.position = std::move(positions);
  mesh.origin_ = std::move(origins);
  mesh.twin_ = std::move(twins);
  // The lowest half-edge that leaves a vertex.
  Progress silent;
  const Index halfedges = mesh.halfedge_slots();
  std::vector<std::atomic<Index>> lowest(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, silent,
                    [&](Index v) { lowest[v].store(halfedges, std::memory_order_relaxed); });
  parallel_for_each(halfedges, kGrain, silent,
                    [&](Index h) { lower_to(lowest[mesh.origin_[h]], h); });
  mesh.outgoing_.resize(mesh.position.size());
  parallel_for_each(mesh.vertex_slots(), kGrain, silent, [&](Index v) {
    const Index h = lowest[v].load(std::memory_order_relaxed);
    mesh.outgoing_[v] = h < halfedges ? h : kNone;
  });
  return mesh;
}

SurfaceMesh SurfaceMesh::from_triangles(std::vector<Vec3> positions,
                                        const std::vector<Triangle>& triangles) {
  Progress silent;
  return from_triangles(std::move(positions), triangles, silent);
}

SurfaceMesh SurfaceMesh::from_triangles(std::vector<Vec3> positions,
                                        const std::vector<Triangle>& triangles,
                                        Progress& progress) {
  const Index vertices = static_cast<Index>(positions.size());
  const Index faces = static_cast<Index>(triangles.size());
  enum class FaceDefect : char { none, unknown_vertex, repeated_vertex };
  std::vector<FaceDefect> defect(block_count(faces, kGrain), FaceDefect::none);
  std::vector<Index> origin(3 * triangles.size());
  parallel_blocks(faces, kGrain, progress, [&](Index block, Index begin, Index end) {
    for (Index f = begin; f < end && defect[block] == FaceDefect::none; ++f) {
      const Triangle& t = triangles[f];
      for (Index v : t)
        if (v < 0 || v >= vertices) defect[block] = FaceDefect::unknown_vertex;
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) defect[block] = FaceDefect::repeated_vertex;
      std::copy(t.begin(), t.end(), origin.begin() + 3 * static_cast<std::ptrdiff_t>(f));
    }
  });
  for (const FaceDefect found : defect) {
    if (found == FaceDefect::unknown_vertex)
      throw InvalidInput("a face refers to a vertex that does not exist");
    if (found == FaceDefect::repeated_vertex) throw InvalidInput("a face uses one vertex twice");
  }
  std::vector<Index> twin = match_twins(vertices, origin, progress);
  SurfaceMesh mesh = from_halfedges(std::move(positions), std::move(origin), std::move(twin));
  progress.update(1.0);
  if (std::find(mesh.outgoing_.begin(), mesh.outgoing_.end(), kNone) != mesh.outgoing_.end())
    throw InvalidInput("a vertex has no face");
  if (!mesh.is_consistent()) throw InvalidInput("a vertex joins more than one fan of faces");
  return mesh;
}

Index SurfaceMesh::find_halfedge(Index a, Index b) const {
  const Index first = outgoing_[a];
  Index h = first;
  do {
    if (target(h) == b) return h;
    h = rotate(h);
  } while (h != first);
  return kNone;
}

Vec3 SurfaceMesh::vertex_normal(Index v) const {
  Vec3 sum = Vec3::Zero();
  for_each_outgoing(v, [&](Index h) { sum += area_vector(face(h)); });
  const double length = sum.norm();
  return length > 0.0 ? Vec3(sum / length) : Vec3(0.0, 0.0, 1.0);
}

std::vector<Vec3> SurfaceMesh::vertex_normals() const {
  std::vector<Vec3> normals(position.size(), Vec3::Zero());
  Progress silent;
  parallel_for_each(vertex_slots(), kGrain, silent, [&](Index v) {
    if (!is_removed_vertex(v)) normals[v] = vertex_normal(v);
  });
  return normals;
}

bool SurfaceMesh::is_flip_legal(Index h) const {
  const Index c = opposite(h), d = opposite(twin_[h]);
  return c != d && find_halfedge(c, d) == kNone;
}

void SurfaceMesh::flip(Index h) {
  // Triangles (a, b, c) on h and (b, a, d) on its twin become (d, c, a) and (c, d, b).
  const Index o = twin_[h];
  const Index h1 = next(h), h2 = prev(h), o1 = next(o), o2 = prev(o);
  const Index a = origin_[h], b = origin_[o], c = origin_[h2], d = origin_[o2];
  const Index beyond_bc = twin_[h1], beyond_ca = twin_[h2], beyond_ad = twin_[o1],
              beyond_db = twin_[o2];
  origin_[h] = d;
  origin_[h1] = c;
  origin_[h2] = a;
  origin_[o] = c;
  origin_[o1] = d;
  origin_[o2] = b;
  link(h1, beyond_ca);
  link(h2, beyond_ad);
  link(o1, beyond_db);
  link(o2, beyond_bc);
  outgoing_[a] = h2;
  outgoing_[b] = o2;
  outgoing_[c] = h1;
  outgoing_[d] = o1;
}

bool SurfaceMesh::is_collapse_legal(Index h) const {
  const Index a = origin(h), b = target(h), c = opposite(h), d = opposite(twin_[h]);
  if (c == d) return false;
  const auto has_valence_three = [&](Index v) {
    const Index first = outgoing_[v];
    return rotate(rotate(rotate(first))) == first;
  };
  if (has_valence_three(c) || has_valence_three(d)) return false;
  const Index first_a = outgoing_[a], first_b = outgoing_[b];
  Index i = first_a;
  do {
    const Index u = target(i);
    if (u != b && u != c && u != d) {
      Index j = first_b;
      do {
        if (target(j) == u) return false;
        j = rotate(j);
      } while (j != first_b);
    }
    i = rotate(i);
  } while (i != first_a);
  return true;
}

void SurfaceMesh::collapse(Index h) {
  const Index o = twin_[h];
  const Index h1 = next(h), h2 = prev(h), o1 = next(o), o2 = prev(o);
  const Index a = origin_[h], b = origin_[o], c = origin_[h2], d = origin_[o2];
  for (Index g = rotate(h); g != h; g = rotate(g)) origin_[g] = b;
  const Index beyond_bc = twin_[h1], beyond_ca = twin_[h2], beyond_ad = twin_[o1],
              beyond_db = twin_[o2];
  link(beyond_bc, beyond_ca);
  link(beyond_ad, beyond_db);
  for (Index g : {h, h1, h2, o, o1, o2}) origin_[g] = twin_[g] = kNone;
  outgoing_[a] = kNone;
  outgoing_[b] = beyond_ca;
  outgoing_[c] = beyond_bc;
  outgoing_[d] = beyond_ad;
  removed_vertices_.add(1);
  removed_faces_.add(2);
}

void SurfaceMesh::append_slots(Index vertices, Index faces) {
  position.resize(position.size() + vertices, Vec3::Zero());
  outgoing_.resize(outgoing_.size() + vertices, kNone);
  origin_.resize(origin_.size() + 3 * static_cast<std::size_t>(faces), kNone);
  twin_.resize(origin_.size(), kNone);
}

Index SurfaceMesh::split_face(Index f, const Vec3& p) {
  const Index v = vertex_slots(), g = face_slots();
  append_slots(1, 2);
  position[v] = p;
  split_face_into(f, v, g, g + 1);
  return v;
}

void SurfaceMesh::split_face_into(Index f, Index v, Index g, Index k) {
  // (a, b, c) becomes f = (a, b, v), g = (b, c, v), k = (c, a, v).
  const Index h0 = 3 * f, h1 = h0 + 1, h2 = h0 + 2;
  const Index a = origin_[h0], b = origin_[h1], c = origin_[h2];
  const Index beyond_bc = twin_[h1], beyond_ca = twin_[h2];
  origin_[h2] = v;
  origin_[3 * g] = b;
  origin_[3 * g + 1] = c;
  origin_[3 * g + 2] = v;
  origin_[3 * k] = c;
  origin_[3 * k + 1] = a;
  origin_[3 * k + 2] = v;
  link(3 * g, beyond_bc);
  link(3 * k, beyond_ca);
  link(h1, 3 * g + 2);
  link(3 * g + 1, 3 * k + 2);
  link(3 * k + 1, h2);
  outgoing_[v] = h2;
  outgoing_[a] = h0;
  outgoing_[b] = 3 * g;
  outgoing_[c] = 3 * k;
}

bool SurfaceMesh::is_move_legal(Index v) const {
  const Index h = outgoing_[v], g = rotate(h), k = rotate(g);
  return rotate(k) == h && opposite(twin_[next(h)]) != target(k);
}

Index SurfaceMesh::move_vertex(Index v, Index f) {
  // (v, a, b) becomes (c, a, b) in place of (v, b, c) and (v, c, a).
  const Index h = outgoing_[v], g = rotate(h), k = rotate(g);
  const Index b = target(g), c = target(k);
  const Index beyond_bc = twin_[next(g)], beyond_ca = twin_[next(k)];
  origin_[h] = c;
  link(h, beyond_ca);
  link(prev(h), beyond_bc);
  outgoing_[c] = h;
  outgoing_[target(h)] = next(h);
  outgoing_[b] = prev(h);
  split_face_into(f, v, face(g), face(k));
  return face(h);
}

SurfaceMesh::Patch SurfaceMesh::copy_patch(const std::vector<Index>& faces) const {
  Patch patch;
  patch.faces = faces;
  for (const Index f : faces)
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      patch.origin.push_back(origin_[h]);
      patch.twin.push_back(twin_[h]);
    }
  return patch;
}

void SurfaceMesh::restore_patch(const Patch& patch) {
  std::size_t entry = 0;
  for (const Index f : patch.faces)
    for (Index h = 3 * f; h < 3 * f + 3; ++h, ++entry) {
      origin_[h] = patch.origin[entry];
      outgoing_[origin_[h]] = h;
      link(h, patch.twin[entry]);
    }
}

std::vector<Index> SurfaceMesh::compact() {
  Progress silent;
  return compact(silent);
}

std::vector<Index> SurfaceMesh::compact(Progress& progress) {
  std::vector<Index> place;  // of each vertex among those that are left
  const Index vertices = parallel_number(
      vertex_slots(), kGrain, progress, [&](Index v) { return !is_removed_vertex(v); }, place);
  std::vector<Vec3> kept(vertices);
  parallel_for_each(vertex_slots(), kGrain, progress, [&](Index v) {
    if (place[v] != kNone) kept[place[v]] = position[v];
  });
  const std::vector<Index> order = morton_order(kept, progress);
  std::vector<Index> rank(order.size());
  parallel_for_each(vertices, kGrain, progress, [&](Index i) { rank[order[i]] = i; });
  std::vector<Index> new_index(position.size());
  parallel_for_each(vertex_slots(), kGrain, progress,
                    [&](Index v) { new_index[v] = place[v] == kNone ? kNone : rank[place[v]]; });
  renumber(new_index, progress);
  return new_index;
}

std::vector<Index> SurfaceMesh::renumber(const std::vector<Index>& new_index) {
  Progress silent;
  return renumber(new_index, silent);
}

std::vector<Index> SurfaceMesh::renumber(const std::vector<Index>& new_index, Progress& progress) {
  const Index vertices = vertex_count(), faces = face_count(), old_faces = face_slots();
  std::vector<Vec3> moved(vertices);
  parallel_for_each(vertex_slots(), kGrain, progress, [&](Index v) {
    if (new_index[v] != kNone) moved[new_index[v]] = position[v];
  });
  position = std::move(moved);

  // Faces by their lowest vertex; those of one vertex keep their order.
  const Buckets by_vertex = sort_into_buckets(old_faces, vertices, progress, [&](Index f) {
    if (is_removed_face(f)) return kNone;
    const Triangle t = triangle(f);
    return std::min({new_index[t[0]], new_index[t[1]], new_index[t[2]]});
  });
  std::vector<Index> new_face(old_faces, kNone);
  parallel_for_each(faces, kGrain, progress, [&](Index f) { new_face[by_vertex.item[f]] = f; });

  std::vector<Index> origin(3 * static_cast<std::size_t>(faces)), twin(origin.size());
  parallel_for_each(old_faces, kGrain, progress, [&](Index f) {
    if (new_face[f] == kNone) return;
    for (Index corner = 0; corner < 3; ++corner) {
      const Index old_twin = twin_[3 * f + corner];
      origin[3 * new_face[f] + corner] = new_index[origin_[3 * f + corner]];
      twin[3 * new_face[f] + corner] = 3 * new_face[face(old_twin)] + old_twin % 3;
    }
  });
  *this = from_halfedges(std::move(position), std::move(origin), std::move(twin));
  return new_face;
}

bool SurfaceMesh::is_consistent() const {
  Progress silent;
  std::atomic<bool> is_broken{false};
  const Index halfedges = halfedge_slots();
  const Index live = parallel_sum(halfedges, kGrain, silent, Index{0}, [&](Index begin, Index end) {
    Index count = 0;
    for (Index h = begin; h < end; ++h) {
      if (origin_[h] == kNone) continue;
      ++count;
      const Index o = twin_[h];
      if (o < 0 || o >= halfedges || o == h || twin_[o] != h || origin_[o] != target(h) ||
          target(o) != origin_[h])
        is_broken = true;
    }
    return count;
  });
  if (is_broken) return false;
  // One fan per vertex: the half-edges met while walking around every vertex are all there are.
  // Links in pairs always lead back to where a walk began.
  const Index walked =
      parallel_sum(vertex_slots(), kGrain, silent, Index{0}, [&](Index begin, Index end) {
        Index count = 0;
        for (Index v = begin; v < end; ++v) {
          if (is_removed_vertex(v)) continue;
          const Index first = outgoing_[v];
          Index h = first;
          do {
            if (h < 0 || h >= halfedges || origin_[h] != v) {
              is_broken = true;
              break;
            }
            ++count;
            h = rotate(h);
          } while (h != first);
        }
        return count;
      });
  return !is_broken && walked == live;
}

std::vector<Triangle> SurfaceMesh::triangles() const {
  Progress silent;
  return parallel_collect<Triangle>(face_slots(), kGrain, silent,
                                    [&](Index begin, Index end, std::vector<Triangle>& some) {
                                      some.reserve(static_cast<std::size_t>(end - begin));
                                      for (Index f = begin; f < end; ++f)
                                        if (!is_removed_face(f)) some.push_back(triangle(f));
                                    });
}

MeshComponents connected_components(const SurfaceMesh& mesh) {
  Progress silent;
  return connected_components(mesh, silent);
}

MeshComponents connected_components(const SurfaceMesh& mesh, Progress& progress) {
  const Index vertices = mesh.vertex_slots();
  SharedSets sets(vertices, progress);
  parallel_for_each(vertices, kGrain, progress, [&](Index v) {
    if (mesh.is_removed_vertex(v)) return;
    mesh.for_each_outgoing(v, [&](Index h) {
      if (mesh.target(h) < v) sets.unite(v, mesh.target(h));
    });
  });
  MeshComponents components;
  std::vector<Index> number;  // of the lowest vertex of each component
  components.count = parallel_number(
      vertices, kGrain, progress,
      [&](Index v) { return !mesh.is_removed_vertex(v) && sets.find(v) == v; }, number);
  components.of_vertex.resize(static_cast<std::size_t>(vertices));
  parallel_for_each(vertices, kGrain, progress,
                    [&](Index v) { components.of_vertex[v] = number[sets.find(v)]; });
  return components;
}

SurfaceMesh kept_components(const SurfaceMesh& mesh, const MeshComponents& components,
                            const std::vector<char>& is_kept, Progress& progress,
                            std::vector<Index>* new_index) {
  std::vector<Index> kept(mesh.position.size(), kNone);
  std::vector<Vec3> position;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    if (!is_kept[components.of_vertex[v]]) continue;
    kept[v] = static_cast<Index>(position.size());
    position.push_back(mesh.position[v]);
  }
  std::vector<Triangle> triangles;
  for (const Triangle& t : mesh.triangles())
    if (kept[t[0]] != kNone) triangles.push_back({kept[t[0]], kept[t[1]], kept[t[2]]});
  if (new_index != nullptr) new_index->swap(kept);
  return SurfaceMesh::from_triangles(std::move(position), triangles, progress);
}

Triangle ascending_corners(const SurfaceMesh& mesh, Index f) {
  Triangle corners = mesh.triangle(f);
  std::sort(corners.begin(), corners.end());
  return corners;
}

void round_to_host(SurfaceMesh& mesh, const Frame& frame, HostScalar scalar) {
  Progress silent;
  parallel_for_each(mesh.vertex_slots(), kGrain, silent, [&](Index v) {
    mesh.position[v] = rounded_to_host(mesh.position[v], frame, scalar);
  });
}

}  // namespace shrinkwrap
