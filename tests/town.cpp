#include "town.h"

#include <cmath>

#include "shapes.h"

namespace shrinkwrap::testing {

Town make_town(const TownOptions& options, unsigned seed) {
  constexpr int kBlock = 20;
  constexpr double kHouse = 5.0, kTree = 3.0;
  const double height = options.height;
  const int width = options.blocks * kBlock;
  Random random(seed);
  const auto jitter = [&] { return random.uniform(-0.3, 0.3); };
  const auto from_centre = [](double x) { return std::fmod(x, kBlock) - 0.5 * kBlock; };
  Town town;
  const auto add = [&](const Vec3& point, const Vec3& normal) {
    town.points.push_back(point);
    town.outward.push_back(normal);
  };
  for (int i = 0; i < width; ++i)
    for (int j = 0; j < width; ++j) {
      const double x = i + jitter(), y = j + jitter();
      const double along = from_centre(x), across = std::abs(from_centre(y));
      const bool is_roof = std::abs(along) < kHouse && across < kHouse;
      const bool is_beyond = along >= kHouse && along < kHouse + 0.5 * height && across < kHouse;
      if (options.is_oblique && is_beyond) continue;
      add({x, y, is_roof ? height : 0.0}, Vec3::UnitZ());
    }
  for (int x = kBlock / 2; x < width; x += kBlock)
    for (int y = kBlock / 2; y < width; y += kBlock) {
      for (int i = 0; i < 4; ++i) {
        const Vec3 out = (i % 2 ? 1.0 : -1.0) * (i / 2 ? Vec3::UnitX() : Vec3::UnitY());
        if (!options.has_walls && !(options.is_oblique && out.x() < 0.0)) continue;
        const Vec3 tangent(out.y(), out.x(), 0.0);
        for (double along = -kHouse; along < kHouse; along += 1.0)
          for (double z = 0.5; z < height; z += 1.0)
            add(Vec3(x, y, z + jitter()) + kHouse * out + (along + jitter()) * tangent, out);
      }
      for (int k = 0; options.has_trees && k < 250; ++k) {
        const Vec3 out = random.direction();
        const Vec3 centre(x + 0.5 * kBlock, y + 0.5 * kBlock, 5.0);
        if (out.z() > -0.4) add(centre + kTree * out, out);
      }
    }
  return town;
}

}  // namespace shrinkwrap::testing
