// add_noise INPUT.ply DEVIATION SEED OUTPUT.ply: moves every point of a cloud by a random amount in
// every coordinate: mean 0, standard deviation DEVIATION x the median sample spacing. The same
// bytes for the same seed on every machine.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "clouds.h"
#include "samples/point_cloud.h"
#include "shapes.h"

int main(int argc, char** argv) {
  using namespace shrinkwrap;
  if (argc != 5) {
    std::fprintf(stderr, "usage: add_noise INPUT.ply DEVIATION SEED OUTPUT.ply\n");
    return 2;
  }
  try {
    std::vector<Vec3> points = benchmarking::read_ply(argv[1]);
    Progress progress;
    const PointCloud cloud = prepare_samples(points, {}, progress);
    const double deviation =
        std::strtod(argv[2], nullptr) * cloud.frame.to_input_length(cloud.spacing);
    testing::Random random(std::strtoull(argv[3], nullptr, 10));
    for (Vec3& p : points)
      for (int axis = 0; axis < 3; ++axis) p[axis] += deviation * random.gaussian();
    benchmarking::write_ply(argv[4], points);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "add_noise: %s\n", error.what());
    return 1;
  }
  return 0;
}
