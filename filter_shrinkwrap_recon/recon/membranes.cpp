#include "membranes.h"

#include <algorithm>
#include <cmath>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;

// Per vertex: its distance from the samples in spacings, or 0 where a foot nearby shows that it is
// at most `low`.
std::vector<float> distances_above(const SurfaceMesh& surface, const SampleFeet& feet,
                                   const PointCloud& cloud, const VoxelSearch& search, double low,
                                   Progress& progress) {
  std::vector<float> distance(surface.position.size(), 0.0f);
  parallel_for_each(surface.vertex_slots(), kGrain, progress, [&](Index v) {
    const Vec3& p = surface.position[v];
    // The nearest sample is no farther than any other, and its own spacing at least the median.
    const double enough = low * cloud.spacing * low * cloud.spacing;
    const Index first = surface.outgoing(v);
    Index h = first;
    do {
      const Index f = SurfaceMesh::face(h);
      for (Index i = feet.begin[f]; i < feet.begin[f + 1]; ++i)
        if ((cloud.position[feet.by_face[i]] - p).squaredNorm() <= enough) return;
      h = surface.rotate(h);
    } while (h != first);
    const VoxelSearch::Hit hit = search.nearest(p);
    const double spacing =
        std::max(cloud.spacing, static_cast<double>(cloud.local_spacing[hit.index]));
    const double spacings = std::sqrt(hit.squared_distance) / spacing;
    if (spacings > low) distance[v] = static_cast<float>(spacings);
  });
  return distance;
}

}  // namespace

Membranes find_membranes(const SurfaceMesh& surface, const SampleFeet& feet,
                         const PointCloud& cloud, const VoxelSearch& search, double low,
                         double high, Progress& progress) {
  const std::vector<float> distance = distances_above(surface, feet, cloud, search, low, progress);
  Membranes membranes;
  std::vector<Index> stack;
  for (Index seed = 0; seed < surface.vertex_slots(); ++seed) {
    if (!(distance[seed] > high)) continue;
    if (membranes.count == 0) membranes.is_membrane.assign(distance.size(), 0);
    if (membranes.is_membrane[seed]) continue;
    ++membranes.count;
    membranes.is_membrane[seed] = 1;
    stack.push_back(seed);
    while (!stack.empty()) {
      const Index v = stack.back();
      stack.pop_back();
      surface.for_each_outgoing(v, [&](Index h) {
        const Index u = surface.target(h);
        if (membranes.is_membrane[u] || distance[u] <= 0.0f) return;
        membranes.is_membrane[u] = 1;
        stack.push_back(u);
      });
    }
  }
  return membranes;
}

namespace {

// Chooses the faces that stay.
class OpeningCutter {
 public:
  OpeningCutter(const SurfaceMesh& mesh, Index first_extra)
      : mesh_(mesh), first_extra_(first_extra), stays_(mesh.face_slots(), 1) {}

  std::vector<Index> cut(Progress& progress) {
    for (Index f = 0; f < mesh_.face_slots(); ++f) {
      const Triangle t = mesh_.triangle(f);
      if (std::max({t[0], t[1], t[2]}) >= first_extra_) set_stays(f, 0);
    }
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
      std::sort(pending.begin(), pending.end());
      pending.erase(std::unique(pending.begin(), pending.end()), pending.end());
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

}  // namespace

std::vector<Index> faces_of_openings(const SurfaceMesh& mesh, Index first_extra,
                                     Progress& progress) {
  return OpeningCutter(mesh, first_extra).cut(progress);
}

}  // namespace shrinkwrap
