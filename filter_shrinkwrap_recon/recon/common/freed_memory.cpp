#include "common/freed_memory.h"

#include <limits>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace shrinkwrap {
namespace {

// The largest arrays hold 64 bytes a sample: with fewer samples they stay below 32 MiB.
constexpr std::size_t kLeastSamples = 500000;

}  // namespace

#ifdef __GLIBC__

namespace {

constexpr int kGlibcLargestThreshold = 32 << 20;  // where its own adjustment ends
constexpr int kNoLimit = std::numeric_limits<int>::max();

}  // namespace

FreedMemoryIsKept::FreedMemoryIsKept(std::size_t samples) : active_(samples >= kLeastSamples) {
  if (!active_) return;
  // Older versions take no more than their own largest.
  if (mallopt(M_MMAP_THRESHOLD, kNoLimit) == 0) mallopt(M_MMAP_THRESHOLD, kGlibcLargestThreshold);
  mallopt(M_TRIM_THRESHOLD, -1);  // never
}

FreedMemoryIsKept::~FreedMemoryIsKept() {
  if (!active_) return;
  mallopt(M_MMAP_THRESHOLD, kGlibcLargestThreshold);
  mallopt(M_TRIM_THRESHOLD, 2 * kGlibcLargestThreshold);
  malloc_trim(0);
}

#else

FreedMemoryIsKept::FreedMemoryIsKept(std::size_t samples) : active_(samples >= kLeastSamples) {}
FreedMemoryIsKept::~FreedMemoryIsKept() = default;

#endif

}  // namespace shrinkwrap
