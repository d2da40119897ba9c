// What becomes of freed memory while a large cloud is reconstructed.
#pragma once

#include <cstddef>

namespace shrinkwrap {

/// While it lives, large blocks that are freed are kept for the next allocation.
///
/// glibc gives every block beyond 32 MiB back to the system when it is freed, and gets the next one
/// page by page, each filled with zeros: with 10 million samples a seventh of the run. The
/// destructor gives back what is left and sets the limits to where glibc itself moves them once
/// large blocks have been freed. Changes nothing for clouds whose arrays are below these limits,
/// nor with another C library.
class FreedMemoryIsKept {
 public:
  explicit FreedMemoryIsKept(std::size_t samples);
  ~FreedMemoryIsKept();
  FreedMemoryIsKept(const FreedMemoryIsKept&) = delete;
  FreedMemoryIsKept& operator=(const FreedMemoryIsKept&) = delete;

 private:
  bool active_;
};

}  // namespace shrinkwrap
