// Memory of a run, known before it starts.
#pragma once

#include <cstdint>

#include "common/types.h"

namespace shrinkwrap {

/// Peak memory of `reconstruct` for that many samples with so many neighbours each, in bytes: the
/// input and result arrays and what the hungriest stage holds at once. The most that was measured
/// on random and on structured clouds; linear in `samples`.
std::uint64_t estimated_peak_bytes(std::uint64_t samples, int neighbours = 16);

/// Memory that the machine can still give without swapping, in bytes; 0 if the system does not
/// tell.
std::uint64_t available_bytes();

/// Throws InvalidInput, with both figures, if that many samples cannot fit.
/// `limit`: bytes that may be used; 0 means what the machine has available (and no check where that
/// is unknown). `keep_stages`: the meshes of the stages take as much again.
void require_memory_for(std::uint64_t samples, std::uint64_t limit = 0, int neighbours = 16,
                        bool keep_stages = false);

}  // namespace shrinkwrap
