#include "plane_agreement.h"

#include <algorithm>

#include "parallel.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr double kAcross = 0.3;  // cosine

struct Areas {
  double all = 0.0, across = 0.0;
  void operator+=(const Areas& other) {
    all += other.all;
    across += other.across;
  }
};

// The normal of each point of the input that is a sample.
std::vector<Vec3f> by_input_index(const PointCloud& cloud, const std::vector<Vec3f>& normals) {
  if (cloud.size() == 0) return {};
  std::vector<Vec3f> result(
      *std::max_element(cloud.input_index.begin(), cloud.input_index.end()) + 1, Vec3f::Zero());
  for (Index i = 0; i < cloud.size(); ++i) result[cloud.input_index[i]] = normals[i];
  return result;
}

}  // namespace

double area_across_planes(const ResultMesh& mesh, const PointCloud& cloud,
                          const std::vector<Vec3f>& normals, Progress& progress) {
  const std::vector<Vec3f> normal_of_input = by_input_index(cloud, normals);
  const auto normal_of = [&](Index v) -> Vec3 {
    const std::size_t input = static_cast<std::size_t>(mesh.input_index[v]);  // kNone: a large one
    return input < normal_of_input.size() ? Vec3(normal_of_input[input].cast<double>())
                                          : Vec3(Vec3::Zero());
  };
  const Areas areas = parallel_sum(
      static_cast<Index>(mesh.triangles.size()), kGrain, progress, Areas{},
      [&](Index begin, Index end) {
        Areas sum;
        for (Index f = begin; f < end; ++f) {
          const auto [a, b, c] = mesh.triangles[f];
          const Vec3 origin = cloud.frame.to_unit(mesh.position[a]);
          const Vec3 area = (cloud.frame.to_unit(mesh.position[b]) - origin)
                                .cross(cloud.frame.to_unit(mesh.position[c]) - origin);
          const double size = area.norm();
          sum.all += size;
          if (area.dot(normal_of(a) + normal_of(b) + normal_of(c)) < 3.0 * kAcross * size)
            sum.across += size;
        }
        return sum;
      });
  return areas.all > 0.0 ? areas.across / areas.all : 0.0;
}

}  // namespace shrinkwrap
