#include "mesh/face_meetings.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/sort_unique.h"
#include "mesh/self_intersection.h"

namespace shrinkwrap {
namespace {

// By face slot: removed and absent faces have no valid index, so that trees and tests leave them
// out.
std::vector<Triangle> slot_triangles(const SurfaceMesh& mesh, const std::vector<Index>& absent) {
  std::vector<Triangle> triangles(mesh.face_slots());
  for (Index f = 0; f < mesh.face_slots(); ++f) triangles[f] = mesh.triangle(f);
  for (const Index f : absent) triangles[f] = {kNone, kNone, kNone};
  return triangles;
}

}  // namespace

FaceMeetings::FaceMeetings(const SurfaceMesh& mesh, std::int64_t max_tests, Progress& progress,
                           std::vector<Index> absent_faces)
    : mesh_(mesh),
      absent_faces_(std::move(absent_faces)),
      test_(mesh.position),
      max_tests_(max_tests),
      tests_left_(max_tests) {
  const std::vector<Triangle> triangles = slot_triangles(mesh, absent_faces_);
  tree_ = BoxTree(mesh.position, triangles, progress);
  const std::size_t clusters = static_cast<std::size_t>(std::max(tree_.cluster_count(), 1));
  const std::size_t most = std::max(kPairsPerFace * triangles.size(), kLeastPairs) / clusters;
  const KeptMeetings found = keep_meetings(tree_, test_, triangles, most, progress);
  faces_at_first_ = static_cast<Index>(found.faces.size());
  has_all_pairs_ = found.has_all_pairs;
  pair_count_ = static_cast<Index>(found.pairs.size());
  std::vector<Index> count(triangles.size(), 0);
  for (const auto& [f, g] : found.pairs) {
    ++count[f];
    ++count[g];
  }
  met_.reserve(found.faces.size());
  for (const auto& [f, g] : found.pairs)
    for (const auto& [face, other] : {std::make_pair(f, g), std::make_pair(g, f)}) {
      std::vector<Index>& met = met_[face];
      if (met.empty()) met.reserve(static_cast<std::size_t>(count[face]));
      met.push_back(other);
    }
}

FaceMeetings::FaceMeetings(const FaceMeetings& whole, const std::vector<Index>& patch,
                           std::int64_t max_tests)
    : mesh_(whole.mesh_),
      test_(whole.test_),
      tree_(whole.tree_, whole.box_around(patch)),
      has_all_pairs_(whole.has_all_pairs_),
      max_tests_(max_tests),
      tests_left_(max_tests) {
  std::set_intersection(whole.absent_faces_.begin(), whole.absent_faces_.end(), patch.begin(),
                        patch.end(), std::back_inserter(absent_faces_));
  replace({}, whole.pairs_of(patch));
}

BoxTree::Box FaceMeetings::box_around(const std::vector<Index>& faces) const {
  std::vector<Triangle> triangles;
  for (const Index f : faces) triangles.push_back(mesh_.triangle(f));
  return tree_.box_of(mesh_.position, triangles);
}

void FaceMeetings::take_over(const std::vector<Index>& patch, const FaceMeetings& part) {
  replace(patch, part.pairs_of(patch));
  update_boxes(patch);
  tests_left_ -= part.tests();
}

std::vector<Index> FaceMeetings::all_faces(Progress& progress) const {
  if (has_all_pairs_) return faces();
  return self_intersecting_faces(tree_, test_, slot_triangles(mesh_, absent_faces_), progress);
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
  std::vector<Index> faces;
  tree_.for_each_overlap(tree_.box_of(mesh_.position, triangles), [&](Index f) {
    if (tests_left_ == 0) return;
    --tests_left_;
    faces.push_back(f);
  });
  return faces;
}

void FaceMeetings::update_boxes(const std::vector<Index>& faces) {
  const auto is_absent = [&](Index f) {
    return std::binary_search(absent_faces_.begin(), absent_faces_.end(), f);
  };
  for (const Index f : faces)
    if (!is_absent(f)) tree_.set_box(f, tree_.box_of(mesh_.position, mesh_.triangle(f)));
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
