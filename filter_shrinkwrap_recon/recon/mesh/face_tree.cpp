#include "mesh/face_tree.h"

#include "common/parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 11;
constexpr float kNowhere = std::numeric_limits<float>::infinity();

}  // namespace

FaceTree::FaceTree(const SurfaceMesh& mesh, Progress& progress)
    : mesh_(mesh), faces_(mesh.face_slots()) {
  if (faces_ == 0) return;
  Index groups = block_count(faces_, kWidth), total = 0;
  do {
    level_begin_[levels_++] = total;
    total += groups;
    if (groups == 1) break;
    groups = block_count(groups, kWidth);
  } while (true);
  group_.resize(total);

  Index children = faces_;
  for (int level = 0; level < levels_; ++level) {
    const Index nodes = block_count(children, kWidth);
    parallel_for_each(nodes, kGrain, progress, [&](Index i) {
      FloatBox nowhere;
      nowhere.low.fill(kNowhere);
      nowhere.high.fill(-kNowhere);
      for (Index lane = 0; lane < kWidth; ++lane) {
        const Index child = kWidth * i + lane;
        put(group(level, i), lane,
            child >= children ? nowhere
            : level == 0      ? box_of_face(child)
                              : box_of_group(group(level - 1, child)));
      }
    });
    children = nodes;
  }
}

FaceTree::FloatBox FaceTree::box_of_face(Index f) const {
  const Triangle t = mesh_.triangle(f);
  const Vec3 &a = mesh_.position[t[0]], &b = mesh_.position[t[1]], &c = mesh_.position[t[2]];
  FloatBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = rounded_down(std::min(std::min(a[axis], b[axis]), c[axis]));
    box.high[axis] = rounded_up(std::max(std::max(a[axis], b[axis]), c[axis]));
  }
  return box;
}

FaceTree::FloatBox FaceTree::box_of_group(const Group& group) {
  FloatBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const Lanes &low = group.low[axis], &high = group.high[axis];
    box.low[axis] = std::min(std::min(low[0], low[1]), std::min(low[2], low[3]));
    box.high[axis] = std::max(std::max(high[0], high[1]), std::max(high[2], high[3]));
  }
  return box;
}

void FaceTree::put(Group& group, Index lane, const FloatBox& box) {
  for (int axis = 0; axis < 3; ++axis) {
    group.low[axis][lane] = box.low[axis];
    group.high[axis][lane] = box.high[axis];
  }
}

}  // namespace shrinkwrap
