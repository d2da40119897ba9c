#include "report/plane_agreement.h"

#include <algorithm>

#include "common/parallel.h"

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

}  // namespace

std::vector<Vec3f> normals_of_points(const PointCloud& cloud) {
  Index last = kNone;
  for (const Index i : cloud.input_index) last = std::max(last, i);
  for (const NearCopy& pair : cloud.conditioning.near_copies) last = std::max(last, pair.copy);
  std::vector<Vec3f> normals(static_cast<std::size_t>(last + 1), Vec3f::Zero());
  for (Index i = 0; i < cloud.size(); ++i) normals[cloud.input_index[i]] = cloud.normal[i];
  for (const NearCopy& pair : cloud.conditioning.near_copies)
    normals[pair.copy] = normals[pair.original];
  return normals;
}

double area_across_planes(const ResultMesh& mesh, const Frame& frame,
                          const std::vector<Vec3f>& normals, Progress& progress) {
  const auto normal_of = [&](Index v) -> Vec3 {
    const std::size_t point = static_cast<std::size_t>(mesh.input_index[v]);  // kNone: a large one
    if (point >= normals.size()) return Vec3::Zero();
    return normals[point].cast<double>();
  };
  const Areas areas = parallel_sum(
      static_cast<Index>(mesh.triangles.size()), kGrain, progress, Areas{},
      [&](Index begin, Index end) {
        Areas sum;
        for (Index f = begin; f < end; ++f) {
          if (!mesh.face_quality.empty() && mesh.face_quality[f] > 0.0f) continue;
          const auto [a, b, c] = mesh.triangles[f];
          const Vec3 origin = frame.to_unit(mesh.position[a]);
          const Vec3 area = (frame.to_unit(mesh.position[b]) - origin)
                                .cross(frame.to_unit(mesh.position[c]) - origin);
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
