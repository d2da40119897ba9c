// Memory that a run can still have.
#pragma once

#include <cstdint>
#include <string>

namespace shrinkwrap {

/// Memory that the machine can still give without swapping, in bytes, or what is left to the
/// control groups of this process, such as a container's, if that is less; 0 if the system does not
/// tell. What a group holds of files, and what the system keeps of them, can be given up and does
/// not count. `root`: where /proc and /sys are, for tests.
std::uint64_t available_bytes(const std::string& root = "");

}  // namespace shrinkwrap
