// VoxelSearch against nanoflann and, where its headers are at hand, the KdTree of vcglib: building,
// nearest and 16 nearest, for queries near the samples (in order and shuffled) and far from them.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <memory>
#include <nanoflann.hpp>
#include <random>

#include "geometry/voxel_search.h"
#ifdef SHRINKWRAP_HAVE_VCGLIB
#include <vcg/space/index/kdtree/kdtree.h>
#include <vcg/space/point3.h>
#endif

namespace shrinkwrap {
namespace {

constexpr int kNeighbours = 16;
constexpr Index kQueries = 1 << 16;

std::vector<Vec3> bumpy_sphere(Index count) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points;
  for (Index i = 0; i < count; ++i) {
    const Vec3 d = Vec3(normal(random), normal(random), normal(random)).normalized();
    points.push_back(d * (0.7 + 0.15 * std::sin(4 * d.x() + 1) * std::cos(5 * d.y()) +
                          0.07 * std::sin(9 * d.z())));
  }
  return points;
}

struct Scene {
  std::vector<Vec3> points, near_ordered, near_shuffled, far;
};

const Scene& scene(Index count) {
  static std::map<Index, Scene> scenes;
  Scene& scene = scenes[count];
  if (!scene.points.empty()) return scene;
  // In the order of the voxels, as the samples of a PointCloud are.
  scene.points = VoxelSearch(bumpy_sphere(count)).ordered_points();
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  const double spacing = 3.0 / std::sqrt(count);
  for (Index q = 0; q < kQueries; ++q) {
    const auto sample = static_cast<std::size_t>(q) * scene.points.size() / kQueries;
    scene.near_ordered.push_back(scene.points[sample] +
                                 0.5 * spacing *
                                     Vec3(normal(random), normal(random), normal(random)));
    scene.far.push_back(Vec3(normal(random), normal(random), normal(random)));
  }
  scene.near_shuffled = scene.near_ordered;
  std::shuffle(scene.near_shuffled.begin(), scene.near_shuffled.end(), random);
  return scene;
}

class Ours {
 public:
  explicit Ours(const std::vector<Vec3>& points) : search_(points) {}
  double nearest(const Vec3& query) { return search_.nearest(query).squared_distance; }
  double nearest_k(const Vec3& query) {
    search_.k_nearest(query, kNeighbours, hits_);
    return hits_.back().squared_distance;
  }

 private:
  VoxelSearch search_;
  std::vector<VoxelSearch::Hit> hits_;
};

class Nanoflann {
 public:
  explicit Nanoflann(const std::vector<Vec3>& points)
      : points_{points}, tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {
    tree_.buildIndex();
  }
  double nearest(const Vec3& query) {
    tree_.knnSearch(query.data(), 1, index_, distance_);
    return distance_[0];
  }
  double nearest_k(const Vec3& query) {
    tree_.knnSearch(query.data(), kNeighbours, index_, distance_);
    return distance_[kNeighbours - 1];
  }

 private:
  struct Points {
    const std::vector<Vec3>& points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points[i][static_cast<Eigen::Index>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  Points points_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3,
                                      std::uint32_t>
      tree_;
  std::uint32_t index_[kNeighbours];
  double distance_[kNeighbours];
};

#ifdef SHRINKWRAP_HAVE_VCGLIB
class Vcglib {
 public:
  explicit Vcglib(const std::vector<Vec3>& points) {
    for (const Vec3& p : points) points_.emplace_back(p.x(), p.y(), p.z());
    tree_ = std::make_unique<Tree>(
        vcg::ConstDataWrapper<vcg::Point3d>(points_.data(), static_cast<int>(points_.size())));
  }
  double nearest(const Vec3& query) {
    unsigned int index = 0;
    double distance = 0.0;
    tree_->doQueryClosest({query.x(), query.y(), query.z()}, index, distance);
    return distance;
  }
  double nearest_k(const Vec3& query) {
    tree_->doQueryK({query.x(), query.y(), query.z()}, kNeighbours, queue_);
    return queue_.getTopWeight();
  }

 private:
  using Tree = vcg::KdTree<double>;
  std::vector<vcg::Point3d> points_;
  std::unique_ptr<Tree> tree_;
  Tree::PriorityQueue queue_;
};
#endif

template <class Search>
void build(benchmark::State& state) {
  const auto& points = scene(static_cast<Index>(state.range(0))).points;
  for (auto _ : state) {
    Search search(points);
    benchmark::DoNotOptimize(search.nearest(points[0]));
  }
}

template <class Search, class Query>
void ask(benchmark::State& state, std::vector<Vec3> Scene::*queries, const Query& query) {
  const Scene& data = scene(static_cast<Index>(state.range(0)));
  Search search(data.points);
  double sum = 0.0;
  for (auto _ : state)
    for (const Vec3& q : data.*queries) sum += query(search, q);
  benchmark::DoNotOptimize(sum);
  state.SetItemsProcessed(state.iterations() * kQueries);
}

template <class Search, std::vector<Vec3> Scene::*queries>
void nearest(benchmark::State& state) {
  ask<Search>(state, queries, [](Search& search, const Vec3& q) { return search.nearest(q); });
}

template <class Search, std::vector<Vec3> Scene::*queries>
void nearest_16(benchmark::State& state) {
  ask<Search>(state, queries, [](Search& search, const Vec3& q) { return search.nearest_k(q); });
}

template <class Search>
void register_all(const std::string& name) {
  const auto add = [&](const std::string& what, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark((name + "/" + what).c_str(), function)
        ->Arg(34000)
        ->Arg(1000000)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime();
  };
  add("build", build<Search>);
  add("nearest/near", nearest<Search, &Scene::near_ordered>);
  add("nearest/near_shuffled", nearest<Search, &Scene::near_shuffled>);
  add("nearest/far", nearest<Search, &Scene::far>);
  add("16_nearest/near", nearest_16<Search, &Scene::near_ordered>);
  add("16_nearest/far", nearest_16<Search, &Scene::far>);
}

}  // namespace
}  // namespace shrinkwrap

int main(int argc, char** argv) {
  shrinkwrap::register_all<shrinkwrap::Ours>("voxel_search");
  shrinkwrap::register_all<shrinkwrap::Nanoflann>("nanoflann");
#ifdef SHRINKWRAP_HAVE_VCGLIB
  shrinkwrap::register_all<shrinkwrap::Vcglib>("vcglib");
#endif
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
