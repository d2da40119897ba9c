// Work that may fail without the run failing.
#pragma once

#include <new>

#include "common/types.h"

namespace shrinkwrap {

/// Runs `work`; false if it failed or memory did not suffice. What is only tried fails no run, but
/// Cancelled goes on to the caller.
template <class Work>
bool attempted(const Work& work) {
  try {
    work();
    return true;
  } catch (const ReconstructionFailed&) {
  } catch (const InvalidInput&) {
  } catch (const std::bad_alloc&) {
  }
  return false;
}

}  // namespace shrinkwrap
