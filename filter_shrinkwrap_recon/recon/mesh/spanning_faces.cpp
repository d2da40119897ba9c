#include "mesh/spanning_faces.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <tuple>

#include "common/sort_unique.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

bool is_of_samples(const SurfaceMesh& mesh, Index f, const ExtraVertices& extra) {
  const Triangle t = mesh.triangle(f);
  return std::none_of(t.begin(), t.end(), [&](Index v) { return extra.has(v); });
}

// Chooses from some faces (ascending) those that span an opening, one by one: those with a vertex
// that is no sample, then, of those next to one that spans, the one with the longest edge.
class SpanningGrowth {
 public:
  // `spans`: which of the other faces do.
  template <class Spans>
  SpanningGrowth(const SurfaceMesh& mesh, const std::vector<Index>& faces,
                 const ExtraVertices& extra, const Spans& spans)
      : mesh_(mesh), extra_(extra) {
    for (const Index f : faces) apart_.insert(entry(f));
    for (const Index f : faces)
      for_each_across(f, [&](Index g) {
        if (!std::binary_search(faces.begin(), faces.end(), g) && spans(g)) move_up(f);
      });
  }

  // Pre: not more often than there are faces.
  Index next() {
    const bool is_apart =
        next_to_.empty() || (!apart_.empty() && has_extra_vertex(*apart_.begin()));
    std::set<Entry>& from = is_apart ? apart_ : next_to_;
    const Index f = std::get<2>(*from.begin());
    from.erase(from.begin());
    for_each_across(f, [&](Index g) { move_up(g); });
    return f;
  }

 private:
  using Entry = std::tuple<bool, double, Index>;  // in the order of choice

  Entry entry(Index f) const {
    const Triangle t = mesh_.triangle(f);
    const std::vector<Vec3>& p = mesh_.position;
    return {is_of_samples(mesh_, f, extra_), -longest_edge(p[t[0]], p[t[1]], p[t[2]]), f};
  }
  static bool has_extra_vertex(const Entry& entry) { return !std::get<0>(entry); }
  template <class Fn>
  void for_each_across(Index f, const Fn& fn) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) fn(SurfaceMesh::face(mesh_.twin(h)));
  }
  // The face, if it is one to choose from, has a neighbour that spans.
  void move_up(Index f) {
    const auto found = apart_.find(entry(f));
    if (found == apart_.end()) return;
    next_to_.insert(*found);
    apart_.erase(found);
  }

  const SurfaceMesh& mesh_;
  const ExtraVertices extra_;
  std::set<Entry> next_to_, apart_;  // a face that spans, and from any
};

}  // namespace

void restore_spanning_faces(const SurfaceMesh& mesh, const std::vector<std::vector<Index>>& sets,
                            const ExtraVertices& extra, std::vector<Index>& spanning) {
  if (spanning.empty()) return;
  const auto spans = [&](Index f) {
    return std::binary_search(spanning.begin(), spanning.end(), f);
  };
  const auto has_extra = [&](Index f) { return !is_of_samples(mesh, f, extra); };
  std::vector<Index> before, now, others;
  for (const std::vector<Index>& faces : sets) {
    const auto count = std::max(std::count_if(faces.begin(), faces.end(), spans),
                                std::count_if(faces.begin(), faces.end(), has_extra));
    if (count == 0) continue;
    std::copy_if(faces.begin(), faces.end(), std::back_inserter(before), spans);
    SpanningGrowth growth(mesh, faces, extra, spans);
    for (std::ptrdiff_t i = 0; i < count; ++i) now.push_back(growth.next());
  }
  sort_unique(before);
  sort_unique(now);
  std::set_difference(spanning.begin(), spanning.end(), before.begin(), before.end(),
                      std::back_inserter(others));
  spanning.clear();
  std::set_union(others.begin(), others.end(), now.begin(), now.end(),
                 std::back_inserter(spanning));
}

}  // namespace shrinkwrap
