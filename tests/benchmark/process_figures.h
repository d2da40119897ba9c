// What the operating system knows about this process: its memory and its time (Linux).
#pragma once

#include <chrono>
#include <cstdint>

namespace shrinkwrap::benchmarking {

/// Physical memory in use now, in bytes; 0 if the system does not tell.
std::uint64_t resident_bytes();
/// The most since the process began or since the last reset, in bytes.
std::uint64_t peak_resident_bytes();
/// Begins a new peak at what is in use now; false if the system does not allow it.
bool reset_peak_resident_bytes();
/// Gives memory that the allocator holds in reserve back to the system.
void return_free_memory();

/// User and system time of all threads of this process, in seconds.
double processor_seconds();

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace shrinkwrap::benchmarking
