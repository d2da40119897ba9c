#include "common/memory_estimate.h"

#include <gtest/gtest.h>

#include <string>

#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap {
namespace {

constexpr std::uint64_t kGibibyte = std::uint64_t{1} << 30;

TEST(MemoryEstimate, IsLinearInTheSamples) {
  const std::uint64_t base = estimated_peak_bytes(0);
  const std::uint64_t million = estimated_peak_bytes(1'000'000) - base;
  EXPECT_GT(million, 0u);
  EXPECT_EQ(estimated_peak_bytes(10'000'000) - base, 10 * million);
}

TEST(MemoryEstimate, NeighboursCount) {
  EXPECT_EQ(estimated_peak_bytes(1000, 8), estimated_peak_bytes(1000));
  EXPECT_EQ(estimated_peak_bytes(1000, 16), estimated_peak_bytes(1000));
  const std::uint64_t needed = estimated_peak_bytes(1'000'000, 128);
  EXPECT_GE(needed, std::uint64_t{1'001'000'000}) << "measured";
  EXPECT_NO_THROW(require_memory_for({1'000'000, 128}, needed));
  EXPECT_THROW(require_memory_for({1'000'000, 128}, needed - 1), InvalidInput);
}

TEST(MemoryEstimate, TenMillionSamplesFitIntoTwelveGibibytes) {
  EXPECT_LE(estimated_peak_bytes(10'000'000), 12 * kGibibyte);
  EXPECT_NO_THROW(require_memory_for({10'000'000}, 12 * kGibibyte));
}

TEST(MemoryEstimate, AcceptsWhatJustFitsAndRefusesOneByteLess) {
  const std::uint64_t needed = estimated_peak_bytes(3'000'000);
  EXPECT_NO_THROW(require_memory_for({3'000'000}, needed));
  EXPECT_THROW(require_memory_for({3'000'000}, needed - 1), InvalidInput);
}

TEST(MemoryEstimate, RefusalTellsBothFiguresAndARemedy) {
  try {
    require_memory_for({2'000'000'000}, 4 * kGibibyte);
    FAIL() << "2 billion samples were accepted in 4 GiB";
  } catch (const InvalidInput& refusal) {
    const std::string text = refusal.what();
    EXPECT_NE(text.find("2000000000 points"), std::string::npos) << text;
    EXPECT_NE(
        text.find(" " + std::to_string(estimated_peak_bytes(2'000'000'000) / kGibibyte) + "."),
        std::string::npos)
        << text;
    EXPECT_NE(text.find("4.0 GiB"), std::string::npos) << text;
    EXPECT_NE(text.find("thin"), std::string::npos) << text;
  }
}

TEST(MemoryEstimate, RefusalOfKeptStagesTellsThePointsThereAre) {
  EXPECT_NO_THROW(require_memory_for({5'000'000}, 6 * kGibibyte));
  try {
    require_memory_for({5'000'000, 16, true}, 6 * kGibibyte);
    FAIL() << "twice 5 million samples were accepted in 6 GiB";
  } catch (const InvalidInput& refusal) {
    const std::string text = refusal.what();
    EXPECT_NE(text.find("5000000 points"), std::string::npos) << text;
    EXPECT_NE(text.find("keep no stages"), std::string::npos) << text;
  }
}

TEST(MemoryEstimate, RefusalOfALargeMeshTellsItsVertices) {
  try {
    require_memory_for({1000, 16, false, 50'000'000}, 4 * kGibibyte);
    FAIL() << "50 million vertices were accepted in 4 GiB";
  } catch (const InvalidInput& refusal) {
    const std::string text = refusal.what();
    EXPECT_NE(text.find("a mesh of 50000000 vertices"), std::string::npos) << text;
    EXPECT_NE(text.find("smaller mesh"), std::string::npos) << text;
    EXPECT_EQ(text.find("1000 points"), std::string::npos) << text;
  }
}

TEST(MemoryEstimate, MoreNeighboursCountBesideKeptStages) {
  const std::uint64_t stages = estimated_peak_bytes(1'000'000) - estimated_peak_bytes(0);
  const std::uint64_t needed = estimated_peak_bytes(1'000'000, 128) + stages;
  EXPECT_NO_THROW(require_memory_for({1'000'000, 128, true}, needed));
  EXPECT_THROW(require_memory_for({1'000'000, 128, true}, needed - 1), InvalidInput);
}

TEST(MemoryEstimate, TheBoundingBoxOfTheStartCounts) {
  const auto points = testing::sample_shape(testing::ShapeKind::sphere, 1000, 1);
  ReconstructionOptions options = as_in_the_paper();
  options.memory_limit = estimated_peak_bytes(100000);
  Progress silent;
  options.initial_mesh.levels = 8;  // 393,218 vertices
  EXPECT_THROW(reconstruct(points, options, silent), InvalidInput);
  options.initial_mesh.levels = -1;
  EXPECT_NO_THROW(reconstruct(points, options, silent));
}

TEST(MemoryEstimate, RefusesBeforeAnyWorkIsDone) {
  const auto points = testing::sample_shape(testing::ShapeKind::sphere, 1000, 1);
  ReconstructionOptions options;
  options.memory_limit = 1;
  int calls = 0;
  Progress progress(
      [&](double, const char*) {
        ++calls;
        return true;
      },
      stages_of(options));
  EXPECT_THROW(reconstruct(points, options, progress), InvalidInput);
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace shrinkwrap
