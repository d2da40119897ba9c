#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cleaned_cloud.h"
#include "samples/outliers.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

// What stands on a plate: columns of samples that go up, far more densely sampled than it.
struct Block {
  double step;
  int columns, rows, layers;
  double gap;  // from the plate to the lowest row
};

// A plate of samples at distances of about 1, or around a block of 2.
std::vector<Vec3> plate_with(const Block& block, bool is_wide) {
  Random random(1);
  std::vector<Vec3> points;
  const auto add = [&](const Vec3& p, const Vec3& jitter) {
    points.push_back(p + 0.5 * jitter.cwiseProduct(random.in_cube()));
  };
  constexpr int kHalf = 30;
  for (int i = -kHalf; i < kHalf; ++i)
    for (int j = -kHalf; j < kHalf; ++j) {
      const bool is_beside = is_wide && i >= 0 && i < 20 && std::abs(j) < 10;
      if (is_beside && (i % 2 != 0 || j % 2 != 0)) continue;
      add(is_beside ? Vec3(i, j + 1.0, 0.0) : Vec3(i + 0.5, j + 0.5, 0.0), {0.1, 0.1, 0.02});
    }
  const double middle = is_wide ? 9.0 : 0.0;
  for (int row = 0; row < block.rows; ++row)
    for (int column = 0; column < block.columns; ++column)
      for (int layer = 0; layer < block.layers; ++layer)
        add({middle + block.step * (column - 0.5 * (block.columns - 1)),
             block.step * (layer - 0.5 * (block.layers - 1)), block.gap + block.step * row},
            block.step * Vec3(0.1, 0.02, 0.1));
  return points;
}

std::size_t found_of(const Block& block, bool is_wide) {
  return cleaned(plate_with(block, is_wide)).report.input_index.size();
}

std::string name_of(const Block& block) {
  return std::to_string(block.columns) + " x " + std::to_string(block.layers) + " columns of " +
         std::to_string(block.rows) + " at " + std::to_string(block.step) + ", " +
         std::to_string(block.gap) + " above";
}

// A patch of close samples on a surface of wide ones, as where something was scanned again: its own
// spacing sets it apart from the rest. The same off the surface is stray.
TEST(OutliersOfDenseParts, PatchesOfTheSurfaceAreNotStray) {
  const std::vector<Vec3> sphere = sample_shape_blue_noise(ShapeKind::sphere, 3000, 6);
  const double spacing = 0.065;
  for (const double height : {0.0, 0.2, 4.0}) {
    SCOPED_TRACE(height);
    std::vector<Vec3> points = sphere;
    Random random(7);
    for (int i = 0; i < 14; ++i) {
      const Vec3 direction = (Vec3(1, 2, 3).normalized() + 0.2 * spacing * random.in_cube());
      points.push_back((1.0 + height * spacing) * direction.normalized());
    }
    EXPECT_EQ(cleaned(points).report.input_index.size(), height > 1.0 ? 14u : 0u);
  }
}

// Each is too small to be a body of its own, and goes higher than samples of the plate see.
TEST(OutliersOfDenseParts, FinsStay) {
  for (const double step : {0.08, 0.1})
    for (const int rows : {6, 8})
      for (const double gap : {0.1, 0.3, 0.6}) {
        const Block fin = {step, 3, rows, 1, gap};
        SCOPED_TRACE(name_of(fin));
        EXPECT_EQ(found_of(fin, false), 0u);
      }
}

TEST(OutliersOfDenseParts, FinsThatBeginFartherFromThePlateThanMostSamplesAreApartStay) {
  for (const int rows : {6, 8, 9})
    for (const double gap : {0.1, 0.3}) {
      const Block fin = {0.08, 3, rows, 1, gap};
      SCOPED_TRACE(name_of(fin));
      EXPECT_EQ(found_of(fin, true), 0u);
    }
}

TEST(OutliersOfDenseParts, ThinBarsStay) {
  for (const int rows : {5, 6}) {
    const Block bar = {0.12, 2, rows, 2, 0.1};
    SCOPED_TRACE(name_of(bar));
    EXPECT_EQ(found_of(bar, false), 0u);
  }
}

// Samples of the plate, too, have most of their neighbours in a fin.
TEST(OutliersOfDenseParts, SamplesBesideThemStay) {
  for (const auto& [fin, is_wide] :
       {std::pair(Block{0.2, 4, 5, 1, 0.1}, false), {Block{0.4, 4, 5, 1, 0.1}, true}}) {
    SCOPED_TRACE(name_of(fin));
    EXPECT_EQ(found_of(fin, is_wide), 0u);
  }
}

TEST(OutliersOfDenseParts, WhatIsFartherFromThePlateThanItsSamplesAreApartIsStray) {
  const Block fin = {0.08, 3, 8, 1, 1.6};
  EXPECT_EQ(found_of(fin, false), 24u);
}

TEST(OutliersOfDenseParts, ClumpsThatAreNotFlatAreStray) {
  for (const double step : {0.12, 0.2}) {
    const Block off_plate = {step, 3, 3, 3, 0.9}, on_plate = {step, 3, 3, 3, 0.1};
    SCOPED_TRACE(step);
    EXPECT_EQ(found_of(off_plate, false), 27u);
    const std::size_t found = found_of(on_plate, false);
    EXPECT_GE(found, 9u);
    EXPECT_LE(found, 27u);
  }
}

// What is kept alone holds nothing: 7 of 732 stay, and would 105 if it did.
TEST(OutliersOfDenseParts, StrayPointsBesideThePlateHoldNoOthers) {
  const std::vector<Vec3> plate = plate_with({0.08, 3, 8, 1, 0.1}, false);
  const Index samples = static_cast<Index>(plate.size());
  Index stray = 0, found = 0, false_alarms = 0;
  for (unsigned seed = 1; seed <= 5; ++seed)
    for (const int count : {72, 180}) {
      Random random(seed);
      std::vector<Vec3> points = plate;
      for (int i = 0; i < count; ++i) {
        const Vec3 p = Vec3(60.0, 60.0, 10.0).cwiseProduct(random.in_cube());
        if (std::abs(p.z()) > 4.0) points.push_back(p);
      }
      stray += static_cast<Index>(points.size()) - samples;
      for (const Index i : cleaned(points).report.input_index)
        ++(i < samples ? false_alarms : found);
    }
  EXPECT_LE(stray - found, 30);
  EXPECT_EQ(false_alarms, 0);
}

}  // namespace
