#include "complete_matching/openings.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/sort_unique.h"
#include "complete_matching/border_notches.h"
#include "complete_matching/isolated_samples.h"
#include "geometry/triangle_geometry.h"

namespace shrinkwrap {
namespace {

// Chooses the faces that stay.
class OpeningCutter {
 public:
  OpeningCutter(const SurfaceMesh& mesh, Index first_extra)
      : mesh_(mesh), first_extra_(first_extra), stays_(mesh.face_slots(), 1) {}

  // Drops these faces, but for what must stay and with what must go too. Returns what goes.
  std::vector<Index> cut(const std::vector<Index>& faces, Progress& progress) {
    for (const Index f : faces) set_stays(f, 0);
    // Dropping can only shrink what stays; the pinches and lost samples that it cannot mend are
    // mended by keeping faces, which can only grow it: both come to an end.
    const std::vector<Index> along_borders = changed_;
    mend(progress, [&](Index v) {
      if (fans(v) > 1) drop_small_fans(v);
    });
    changed_.insert(changed_.end(), along_borders.begin(), along_borders.end());
    mend(progress, [&](Index v) {
      if (fans(v) > 1 || (v < first_extra_ && staying_faces(v) == 0)) keep_all_faces(v);
    });
    std::vector<Index> dropped;
    for (Index f = 0; f < mesh_.face_slots(); ++f)
      if (!stays_[f]) dropped.push_back(f);
    return dropped;
  }

 private:
  // Calls `mend_vertex` for the vertices around changed faces until none is left.
  template <class MendVertex>
  void mend(Progress& progress, const MendVertex& mend_vertex) {
    while (!changed_.empty()) {
      std::vector<Index> pending;
      pending.swap(changed_);
      sort_unique(pending);
      for (const Index v : pending) mend_vertex(v);
      progress.update(0.5);
    }
  }

  void set_stays(Index f, char stays) {
    if (stays_[f] == stays) return;
    stays_[f] = stays;
    for (const Index v : mesh_.triangle(f)) changed_.push_back(v);
  }
  bool stays(Index h) const { return stays_[SurfaceMesh::face(h)] != 0; }
  bool begins_fan(Index h) const { return stays(h) && !stays(mesh_.twin(h)); }

  Index fans(Index v) const {
    Index count = 0;
    mesh_.for_each_outgoing(v, [&](Index h) { count += begins_fan(h); });
    return count;
  }
  Index staying_faces(Index v) const {
    Index count = 0;
    mesh_.for_each_outgoing(v, [&](Index h) { count += stays(h); });
    return count;
  }

  // Drops the fans of v but the largest, as far as no sample loses its last face.
  void drop_small_fans(Index v) {
    std::vector<std::vector<Index>> fan;
    Index h = mesh_.outgoing(v);
    while (!begins_fan(h)) h = mesh_.rotate(h);
    const Index first = h;
    do {
      if (begins_fan(h)) fan.emplace_back();
      if (stays(h)) fan.back().push_back(SurfaceMesh::face(h));
      h = mesh_.rotate(h);
    } while (h != first);
    std::size_t largest = 0;
    for (std::size_t i = 1; i < fan.size(); ++i)
      if (fan[i].size() > fan[largest].size()) largest = i;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      if (i == largest) continue;
      for (const Index f : fan[i]) {
        bool loses_a_sample = false;
        for (const Index u : mesh_.triangle(f))
          loses_a_sample = loses_a_sample || (u < first_extra_ && staying_faces(u) <= 1);
        if (!loses_a_sample) set_stays(f, 0);
      }
    }
  }

  void keep_all_faces(Index v) {
    mesh_.for_each_outgoing(v, [&](Index h) { set_stays(SurfaceMesh::face(h), 1); });
  }

  const SurfaceMesh& mesh_;
  Index first_extra_;
  std::vector<char> stays_;     // per face
  std::vector<Index> changed_;  // corners of the faces that changed
};

// The faces of a list, ascending, that hang together by edges.
struct Patches {
  std::vector<Index> of_face;  // per entry of the list
  Index count = 0;
};

Patches find_patches(const SurfaceMesh& mesh, const std::vector<Index>& faces) {
  const auto place_of = [&](Index f) {
    const auto found = std::lower_bound(faces.begin(), faces.end(), f);
    return found != faces.end() && *found == f ? static_cast<Index>(found - faces.begin()) : kNone;
  };
  Patches patches;
  patches.of_face.assign(faces.size(), kNone);
  std::vector<Index> stack;
  for (std::size_t seed = 0; seed < faces.size(); ++seed) {
    if (patches.of_face[seed] != kNone) continue;
    patches.of_face[seed] = patches.count;
    stack.push_back(static_cast<Index>(seed));
    while (!stack.empty()) {
      const Index f = faces[stack.back()];
      stack.pop_back();
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index place = place_of(SurfaceMesh::face(mesh.twin(h)));
        if (place == kNone || patches.of_face[place] != kNone) continue;
        patches.of_face[place] = patches.count;
        stack.push_back(place);
      }
    }
    ++patches.count;
  }
  return patches;
}

std::vector<Index> marked_faces(const std::vector<char>& is_marked) {
  std::vector<Index> faces;
  for (std::size_t f = 0; f < is_marked.size(); ++f)
    if (is_marked[f]) faces.push_back(static_cast<Index>(f));
  return faces;
}

// Drops the faces that are to be dropped, a few more or less: those that borders pinch off go too,
// and samples that have no face left are joined to a border, or keep theirs. What stays so that no
// sample is lost spans an opening all the same. Returns the number of samples joined.
std::size_t drop(CompleteMatching& matching, Index samples, const std::vector<Index>& wanted,
                 Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  std::vector<char> is_dropped(static_cast<std::size_t>(mesh.face_slots()), 0);
  for (const Index f : cut_openings(mesh, wanted, 0, progress)) is_dropped[f] = 1;
  const std::vector<Index> joining = join_isolated_samples(mesh, samples, is_dropped, progress);
  matching.opening_faces = cut_openings(mesh, marked_faces(is_dropped), samples, progress);
  std::vector<Index> spanning = wanted;
  const auto add = [&](const std::vector<Index>& faces) {
    spanning.insert(spanning.end(), faces.begin(), faces.end());
  };
  add(joining);
  add(matching.opening_faces);
  add(matching.spanning_faces);
  sort_unique(spanning);
  matching.spanning_faces = std::move(spanning);
  return joining.size();
}

double longest_edge(const SurfaceMesh& mesh, Index f) {
  const Triangle t = mesh.triangle(f);
  return shrinkwrap::longest_edge(mesh.position[t[0]], mesh.position[t[1]], mesh.position[t[2]]);
}

}  // namespace

void leave_openings(CompleteMatching& matching, const PointCloud& cloud, Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  std::vector<char> is_dropped(static_cast<std::size_t>(mesh.face_slots()), 0);
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    const Triangle t = mesh.triangle(f);
    is_dropped[f] = std::max({t[0], t[1], t[2]}) >= cloud.size();
  }
  matching.report.notches_filled = fill_border_notches(mesh, cloud, is_dropped, progress);
  const std::size_t joined = drop(matching, cloud.size(), marked_faces(is_dropped), progress);
  // As it is when it comes back from a layer: later stages depend on where the one-rings begin.
  if (matching.report.notches_filled > 0 || joined > 0)
    mesh = SurfaceMesh::from_triangles(std::move(mesh.position), mesh.triangles());
}

std::vector<Index> cut_openings(const SurfaceMesh& mesh, const std::vector<Index>& faces,
                                Index first_extra, Progress& progress) {
  return OpeningCutter(mesh, first_extra).cut(faces, progress);
}

Index extra_vertices_kept(const SurfaceMesh& mesh, Index samples,
                          const std::vector<Index>& opening_faces) {
  std::vector<char> is_kept(static_cast<std::size_t>(mesh.vertex_slots() - samples), 0);
  for (Index v = samples; v < mesh.vertex_slots(); ++v)
    mesh.for_each_outgoing(v, [&](Index h) {
      if (!std::binary_search(opening_faces.begin(), opening_faces.end(), SurfaceMesh::face(h)))
        is_kept[v - samples] = 1;
    });
  return static_cast<Index>(std::count(is_kept.begin(), is_kept.end(), 1));
}

void measure_openings(const CompleteMatching& matching, double spacing, OpeningsReport& report) {
  const std::vector<Index>& open = matching.opening_faces;
  std::vector<Index> spanning;
  std::set_difference(matching.spanning_faces.begin(), matching.spanning_faces.end(), open.begin(),
                      open.end(), std::back_inserter(spanning));
  report.spanned = find_patches(matching.mesh, spanning).count;
  report.left_open = find_patches(matching.mesh, open).count;
  report.longest_edge = 0.0;
  for (const Index f : spanning)
    report.longest_edge = std::max(report.longest_edge, longest_edge(matching.mesh, f) / spacing);
}

OpeningsReport decide_openings(CompleteMatching& matching, const PointCloud& cloud,
                               const CompleteMatchingOptions& options, Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  std::vector<Index>& spanning = matching.spanning_faces;
  OpeningsReport report;
  report.notches_filled = matching.report.notches_filled;
  if (spanning.empty()) return report;
  if (options.openings == CompleteMatchingOptions::Openings::leave_open) {
    // Whether leave_openings has made them or they come back from a layer: so both give the same.
    drop(matching, cloud.size(), spanning, progress);
    measure_openings(matching, cloud.spacing, report);
    return report;
  }
  const Patches patches = find_patches(mesh, spanning);
  std::vector<double> width(static_cast<std::size_t>(patches.count), 0.0);  // of each patch
  for (std::size_t i = 0; i < spanning.size(); ++i) {
    double& widest = width[patches.of_face[i]];
    widest = std::max(widest, longest_edge(mesh, spanning[i]) / cloud.spacing);
  }
  const bool is_automatic = options.openings == CompleteMatchingOptions::Openings::automatic;
  const auto is_left_open = [&](Index patch) {
    return is_automatic && width[patch] > options.widest_opening;
  };
  bool is_any_left_open = false;
  for (Index patch = 0; patch < patches.count; ++patch)
    is_any_left_open = is_any_left_open || is_left_open(patch);
  if (is_any_left_open) {
    std::vector<char> is_wide(static_cast<std::size_t>(mesh.face_slots()), 0);
    std::vector<Index> spanned;
    for (std::size_t i = 0; i < spanning.size(); ++i)
      if (is_left_open(patches.of_face[i]))
        is_wide[spanning[i]] = 1;
      else
        spanned.push_back(spanning[i]);
    report.notches_filled = fill_border_notches(mesh, cloud, is_wide, progress);
    spanning = std::move(spanned);
    drop(matching, cloud.size(), marked_faces(is_wide), progress);
  }
  measure_openings(matching, cloud.spacing, report);
  return report;
}

}  // namespace shrinkwrap
