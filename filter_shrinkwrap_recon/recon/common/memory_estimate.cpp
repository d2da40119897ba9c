#include "common/memory_estimate.h"

#include <algorithm>
#include <string>

#include "common/available_memory.h"

namespace shrinkwrap {
namespace {

// The most that was measured of closed shapes is 514 (complete matching, two threads) beside 24 for
// the input, of noise of one spacing 640 (signs of normals), of sheets, whose matching may be made
// twice, 700.
constexpr std::uint64_t kBytesPerSample = 700;
// 4.2 for each neighbour beyond 16 (128, on scan lines: 1,001 in all).
constexpr std::uint64_t kBytesPerNeighbour = 5;
constexpr int kFewNeighbours = 16;
constexpr std::uint64_t kBaseBytes = std::uint64_t{32} << 20;

// To a tenth, with a point whatever the locale of the host is.
std::string in_gibibytes(std::uint64_t bytes) {
  const std::uint64_t tenths = (bytes >> 20) * 10 / 1024;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " GiB";
}

}  // namespace

std::uint64_t estimated_peak_bytes(std::uint64_t samples, int neighbours) {
  const std::uint64_t more = static_cast<std::uint64_t>(std::max(neighbours - kFewNeighbours, 0));
  return kBaseBytes + samples * (kBytesPerSample + more * kBytesPerNeighbour);
}

void require_memory_for(const RunSize& size, std::uint64_t limit) {
  const std::uint64_t available = limit > 0 ? limit : available_bytes();
  const bool is_of_mesh = size.vertices > size.samples;
  const std::uint64_t elements = std::max(size.samples, size.vertices);
  const std::uint64_t of_stages = size.keeps_stages ? elements * kBytesPerSample : 0;
  const std::uint64_t needed = estimated_peak_bytes(elements, size.neighbours) + of_stages;
  if (available == 0 || needed <= available) return;
  const std::string what = is_of_mesh
                               ? "a mesh of " + std::to_string(size.vertices) + " vertices"
                               : "reconstructing " + std::to_string(size.samples) + " points";
  throw InvalidInput(what + (size.keeps_stages ? " and keeping the mesh of every stage" : "") +
                     " needs about " + in_gibibytes(needed) + " of memory, and " +
                     in_gibibytes(available) +
                     " are available: " + (size.keeps_stages ? "keep no stages, " : "") +
                     (is_of_mesh ? "choose a smaller mesh or fewer subdivisions, " : "") +
                     "close other programs, or thin the cloud out (for example with a point cloud "
                     "simplification filter) and try again");
}

}  // namespace shrinkwrap
