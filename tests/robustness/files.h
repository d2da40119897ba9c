// Files of points, whole and damaged, read by vcglib's importers.
#pragma once

#include <cstdint>

#include "jobs.h"

namespace shrinkwrap::robustness {

/// A file in one of several formats, made from a number: mostly damaged, by cutting it off,
/// changing bytes or words, or false counts. It is written to the folder of temporary files,
/// imported in a process of its own, reconstructed and judged, and a mesh in it is measured.
Job file_job(std::uint64_t number, const JobOptions& options);

}  // namespace shrinkwrap::robustness
