#include "face_meetings.h"

#include <algorithm>

#include "self_intersection.h"
#include "sort_unique.h"

namespace shrinkwrap {
namespace {

// By face slot: removed faces have no valid index, so that trees and tests leave them out.
std::vector<Triangle> slot_triangles(const SurfaceMesh& mesh) {
  std::vector<Triangle> triangles(mesh.face_slots());
  for (Index f = 0; f < mesh.face_slots(); ++f) triangles[f] = mesh.triangle(f);
  return triangles;
}

}  // namespace

FaceMeetings::FaceMeetings(const SurfaceMesh& mesh, std::int64_t max_tests, Progress& progress)
    : mesh_(mesh), test_(mesh.position), max_tests_(max_tests), tests_left_(max_tests) {
  const std::vector<Triangle> triangles = slot_triangles(mesh);
  tree_ = BoxTree(mesh.position, triangles, progress);
  for (const auto& [f, g] : self_intersections(tree_, test_, triangles, progress)) {
    met_[f].push_back(g);
    met_[g].push_back(f);
    ++pair_count_;
  }
}

std::vector<Index> FaceMeetings::faces() const {
  std::vector<Index> faces;
  faces.reserve(met_.size());
  for (const auto& entry : met_) faces.push_back(entry.first);
  std::sort(faces.begin(), faces.end());
  return faces;
}

const std::vector<Index>& FaceMeetings::faces_met_by(Index f) const {
  static const std::vector<Index> none;
  const auto found = met_.find(f);
  return found == met_.end() ? none : found->second;
}

std::vector<FaceMeetings::Pair> FaceMeetings::pairs_of(const std::vector<Index>& faces) const {
  std::vector<Pair> pairs;
  for (const Index f : faces)
    for (const Index g : faces_met_by(f)) pairs.push_back(std::minmax(f, g));
  sort_unique(pairs);
  return pairs;
}

std::vector<Index> FaceMeetings::faces_around(const std::vector<Triangle>& triangles) const {
  BoxTree::Box all = tree_.box_of(mesh_.position, triangles.front());
  for (const Triangle& t : triangles) {
    const BoxTree::Box box = tree_.box_of(mesh_.position, t);
    for (int axis = 0; axis < 3; ++axis) {
      all[axis] = std::min(all[axis], box[axis]);
      all[axis + 3] = std::max(all[axis + 3], box[axis + 3]);
    }
  }
  std::vector<Index> faces;
  tree_.for_each_overlap(all, [&](Index f) {
    if (tests_left_ == 0) return;
    --tests_left_;
    faces.push_back(f);
  });
  return faces;
}

void FaceMeetings::update_boxes(const std::vector<Index>& faces) {
  for (const Index f : faces) tree_.set_box(f, tree_.box_of(mesh_.position, mesh_.triangle(f)));
}

void FaceMeetings::replace(const std::vector<Index>& faces, const std::vector<Pair>& pairs) {
  const auto take_out = [&](Index f, Index g) {
    const auto found = met_.find(f);
    std::vector<Index>& met = found->second;
    met.erase(std::find(met.begin(), met.end(), g));
    if (met.empty()) met_.erase(found);
  };
  for (const auto& [f, g] : pairs_of(faces)) {
    take_out(f, g);
    take_out(g, f);
    --pair_count_;
  }
  for (const auto& [f, g] : pairs) {
    met_[f].push_back(g);
    met_[g].push_back(f);
    ++pair_count_;
  }
}

}  // namespace shrinkwrap
