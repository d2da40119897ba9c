// Work that may crash, hang or eat the memory, done in a process of its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace shrinkwrap::robustness {

struct ChildLimits {
  double seconds = 120.0;           ///< of the clock; then the child is killed
  double processor_seconds = 30.0;  ///< of all its threads; then the system kills it
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< of address space (no limit under ASan)
};

struct ChildOutcome {
  enum class End { finished, crashed, too_slow };
  End end = End::finished;
  std::string how;     ///< if it did not finish: the signal or the exit code
  std::string output;  ///< what the work said
  double seconds = 0.0;
};

/// Sends text to the parent at once: what was sent before the child died is known.
using Say = std::function<void(const std::string&)>;
using Work = std::function<void(const Say&)>;

/// Pre: the parent has one thread (a forked copy of a thread pool would be dead).
class ChildProcess {
 public:
  /// Forks; the child does the work, hands over what it says (at most 60,000 bytes) and leaves.
  ChildProcess(const Work& work, const ChildLimits& limits);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  /// True once the child has ended; kills it when its time is over. Never waits.
  bool has_ended();
  /// Waits until the child has ended.
  const ChildOutcome& wait();
  /// Pre: has_ended().
  const ChildOutcome& outcome() const { return outcome_; }

 private:
  void collect(int status);

  pid_t child_ = -1;
  int pipe_ = -1;
  bool killed_ = false;
  double limit_ = 0.0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  ChildOutcome outcome_;
};

}  // namespace shrinkwrap::robustness
