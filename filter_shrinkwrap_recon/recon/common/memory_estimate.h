// Memory of a run, known before it starts.
#pragma once

#include <cstdint>

#include "common/types.h"

namespace shrinkwrap {

/// Peak memory of `reconstruct` for that many samples with so many neighbours each, in bytes: the
/// input and result arrays and what the hungriest stage holds at once. The most that was measured
/// on random and on structured clouds; linear in `samples`.
std::uint64_t estimated_peak_bytes(std::uint64_t samples, int neighbours = 16);

/// What a run is to hold.
struct RunSize {
  std::uint64_t samples = 0;
  int neighbours = 16;         ///< of each
  bool keeps_stages = false;   ///< the meshes of the stages take as much again
  std::uint64_t vertices = 0;  ///< of a mesh that may have more: then these count as samples do
};

/// Throws InvalidInput, with both figures, if a run cannot fit. `limit`: bytes that may be used; 0
/// means what is available (available_memory.h; no check where that is unknown).
void require_memory_for(const RunSize& size, std::uint64_t limit = 0);

}  // namespace shrinkwrap
