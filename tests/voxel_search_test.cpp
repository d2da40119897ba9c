#include "geometry/voxel_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shapes.h"

namespace shrinkwrap {
namespace {

using Hit = VoxelSearch::Hit;

std::vector<Hit> by_brute_force(const std::vector<Vec3>& points, const Vec3& query) {
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < points.size(); ++i)
    hits.push_back({static_cast<Index>(i), (points[i] - query).squaredNorm()});
  std::sort(hits.begin(), hits.end());
  return hits;
}

void expect_exact(const std::vector<Vec3>& points, const std::vector<Vec3>& queries) {
  const VoxelSearch search(points);
  std::vector<Hit> hits;
  for (const Vec3& query : queries) {
    SCOPED_TRACE(::testing::Message() << "query " << query.transpose());
    const std::vector<Hit> expected = by_brute_force(points, query);
    const Hit nearest = search.nearest(query);
    ASSERT_EQ(nearest.index, expected[0].index);
    ASSERT_EQ(nearest.squared_distance, expected[0].squared_distance);
    for (int k : {1, 7, 40}) {
      search.k_nearest(query, k, hits);
      ASSERT_EQ(hits.size(), std::min(points.size(), static_cast<std::size_t>(k)));
      for (std::size_t i = 0; i < hits.size(); ++i) {
        ASSERT_EQ(hits[i].index, expected[i].index) << "k = " << k << ", entry " << i;
        ASSERT_EQ(hits[i].squared_distance, expected[i].squared_distance);
      }
    }
    const auto even = [](Index i) { return i % 2 == 0; };
    const double reach = std::sqrt(expected[expected.size() / 2].squared_distance) * 1.000001;
    const Hit nearest_even = search.nearest_if(query, reach, even);
    const auto found = std::find_if(expected.begin(), expected.end(),
                                    [&](const Hit& hit) { return even(hit.index); });
    if (found != expected.end() && found->squared_distance <= reach * reach)
      ASSERT_EQ(nearest_even.index, found->index);
    else
      ASSERT_EQ(nearest_even.index, kNone);
  }
}

class RandomPoints {
 public:
  explicit RandomPoints(std::uint64_t seed) : random_(seed) {}
  Vec3 point(double spread = 1.0) {
    return spread * Vec3(random_.gaussian(), random_.gaussian(), random_.gaussian());
  }
  std::vector<Vec3> points(int count, double spread = 1.0) {
    std::vector<Vec3> result;
    for (int i = 0; i < count; ++i) result.push_back(point(spread));
    return result;
  }

 private:
  testing::Random random_;
};

// Near the points, among them, far, and absurdly far.
std::vector<Vec3> queries_for(const std::vector<Vec3>& points, RandomPoints& random) {
  std::vector<Vec3> queries = random.points(30);
  for (int i = 0; i < 30; ++i)
    queries.push_back(points[static_cast<std::size_t>(i * 7919) % points.size()] +
                      random.point(std::pow(10.0, -i / 3)));
  for (int i = 0; i < 10; ++i)
    queries.push_back(points[static_cast<std::size_t>(i) % points.size()]);
  for (double far : {10.0, 1e4, 1e12, 1e25}) queries.push_back(random.point(far));
  return queries;
}

TEST(VoxelSearch, IsExactOnRandomClouds) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomPoints random(seed);
    const int count = seed < 6 ? static_cast<int>(seed * 5) : static_cast<int>(seed * 300);
    const std::vector<Vec3> points = random.points(count);
    expect_exact(points, queries_for(points, random));
  }
}

TEST(VoxelSearch, IsExactOnASurface) {
  RandomPoints random(11);
  std::vector<Vec3> points;
  for (int i = 0; i < 4000; ++i) points.push_back(random.point().normalized());
  std::vector<Vec3> queries = queries_for(points, random);
  queries.emplace_back(0, 0, 0);  // equally far from all
  expect_exact(points, queries);
}

TEST(VoxelSearch, BreaksTiesByIndex) {
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(i % 10, i / 10 % 10, i / 100);
  std::shuffle(points.begin(), points.end(), std::mt19937(5));
  std::vector<Vec3> queries;
  for (int i = 0; i < 40; ++i) queries.emplace_back(i % 5 + 0.5, i % 4 + 0.5, i % 3);
  expect_exact(points, queries);
}

TEST(VoxelSearch, BearsCoincidentPoints) {
  RandomPoints random(2);
  std::vector<Vec3> points = random.points(200);
  for (int i = 0; i < 3000; ++i) points.push_back(Vec3(0.5, 0.25, 0.125));
  for (int i = 0; i < 30; ++i) points.push_back(points[3]);
  std::shuffle(points.begin(), points.end(), std::mt19937(6));
  expect_exact(points, queries_for(points, random));
  expect_exact(std::vector<Vec3>(50, Vec3(1, 2, 3)), {Vec3(0, 0, 0), Vec3(1, 2, 3)});
}

TEST(VoxelSearch, BearsClustersFarFinerThanItsKeys) {
  RandomPoints random(3);
  std::vector<Vec3> points = random.points(300, 1e-9);
  const std::vector<Vec3> finer = random.points(300, 1e-16);
  points.insert(points.end(), finer.begin(), finer.end());
  points.emplace_back(1, 1, 1);
  expect_exact(points, queries_for(points, random));
}

TEST(VoxelSearch, BearsLinesAndPlanes) {
  RandomPoints random(4);
  std::vector<Vec3> line, plane;
  for (const Vec3& p : random.points(500)) {
    line.emplace_back(p.x(), 0, 0);
    plane.emplace_back(p.x(), p.y(), 1e-3);
  }
  expect_exact(line, queries_for(line, random));
  expect_exact(plane, queries_for(plane, random));
}

TEST(VoxelSearch, OfNothingFindsNothing) {
  for (const VoxelSearch& search : {VoxelSearch(), VoxelSearch(std::vector<Vec3>())}) {
    EXPECT_TRUE(search.empty());
    EXPECT_EQ(search.nearest({0, 0, 0}).index, kNone);
    std::vector<Hit> hits{Hit()};
    search.k_nearest({0, 0, 0}, 3, hits);
    EXPECT_TRUE(hits.empty());
    EXPECT_TRUE(search.groups(100).empty());
  }
  const VoxelSearch one({Vec3(1, 1, 1)});
  EXPECT_EQ(one.nearest_if({0, 0, 0}, 1.0, [](Index) { return true; }).index, kNone);
  EXPECT_EQ(one.nearest_if({0, 0, 0}, 9.0, [](Index) { return false; }).index, kNone);
  EXPECT_EQ(one.nearest_if({0, 0, 0}, 9.0, [](Index) { return true; }).index, 0);
}

TEST(VoxelSearch, GroupsSplitTheOrder) {
  RandomPoints random(8);
  std::vector<Vec3> points = random.points(5000);
  const VoxelSearch search(points);
  for (Index most : {VoxelSearch::kLeafPoints, Index{100}, Index{10000}}) {
    Index next = 0;
    for (const VoxelSearch::Range& group : search.groups(most)) {
      EXPECT_EQ(group.begin, next);
      EXPECT_GT(group.end, group.begin);
      EXPECT_LE(group.end - group.begin, most);
      next = group.end;
    }
    EXPECT_EQ(next, 5000);
  }
  for (Index i = 0; i < 5000; ++i)
    EXPECT_EQ(search.ordered_points()[i], points[search.ordered_index()[i]]);
}

TEST(VoxelSearch, VisitsAllPointsNearABoxInOrder) {
  RandomPoints random(9);
  const std::vector<Vec3> points = random.points(3000);
  const VoxelSearch search(points);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 a = random.point(), b = random.point();
    const Vec3 low = a.cwiseMin(b), high = a.cwiseMax(b);
    const double distance = 0.1 * trial;
    std::vector<char> visited(points.size(), 0);
    Index last = -1;
    search.for_each_near_box(low, high, distance, [&](VoxelSearch::Range range) {
      EXPECT_GT(range.begin, last);
      last = range.end - 1;
      for (Index i = range.begin; i < range.end; ++i) visited[search.ordered_index()[i]] = 1;
      return true;
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 inside = points[i].cwiseMax(low).cwiseMin(high);
      EXPECT_TRUE(visited[i] || (points[i] - inside).norm() > distance) << "point " << i;
    }
    int calls = 0;
    search.for_each_near_box(low, high, 100.0, [&](VoxelSearch::Range) { return ++calls < 3; });
    EXPECT_EQ(calls, 3);
  }
}

}  // namespace
}  // namespace shrinkwrap
