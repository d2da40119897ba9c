#include "child_process.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace shrinkwrap::robustness {
namespace {

void limit(decltype(RLIMIT_CPU) resource, rlim_t value) {
  const rlimit limits = {value, value};
  setrlimit(resource, &limits);
}

void apply(const ChildLimits& limits) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(limits.processor_seconds)));
#ifndef __SANITIZE_ADDRESS__
  limit(RLIMIT_AS, limits.memory_bytes);
#endif
}

[[noreturn]] void do_work(const Work& work, int pipe) {
  work([pipe](const std::string& text) {
    for (std::size_t written = 0; written < text.size();) {
      const ssize_t n = write(pipe, text.data() + written, text.size() - written);
      if (n <= 0) _exit(3);
      written += static_cast<std::size_t>(n);
    }
  });
  // Not exit: what the parent has registered to be done at the end is the parent's.
  _exit(0);
}

}  // namespace

ChildProcess::ChildProcess(const Work& work, const ChildLimits& limits) : limit_(limits.seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  child_ = fork();
  if (child_ < 0) throw std::runtime_error("no new process");
  if (child_ == 0) {
    close(ends[0]);
    apply(limits);
    do_work(work, ends[1]);
  }
  close(ends[1]);
  pipe_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (child_ > 0) {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  if (pipe_ >= 0) close(pipe_);
}

bool ChildProcess::has_ended() {
  if (child_ < 0) return true;
  outcome_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (!killed_ && outcome_.seconds > limit_) {
    kill(child_, SIGKILL);
    killed_ = true;
  }
  int status = 0;
  if (waitpid(child_, &status, WNOHANG) != child_) return false;
  collect(status);
  return true;
}

const ChildOutcome& ChildProcess::wait() {
  while (!has_ended()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return outcome_;
}

void ChildProcess::collect(int status) {
  child_ = -1;
  char buffer[4096];
  for (ssize_t n; (n = read(pipe_, buffer, sizeof buffer)) > 0;)
    outcome_.output.append(buffer, static_cast<std::size_t>(n));
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  outcome_.end = ChildOutcome::End::crashed;
  if (WIFEXITED(status)) {
    outcome_.how = "exit code " + std::to_string(WEXITSTATUS(status));
    return;
  }
  const int signal = WTERMSIG(status);
  outcome_.how = strsignal(signal);
  // The limit of processor time ends in SIGKILL, for both its bounds are the same.
  if (killed_ || signal == SIGXCPU || signal == SIGKILL) outcome_.end = ChildOutcome::End::too_slow;
}

}  // namespace shrinkwrap::robustness
