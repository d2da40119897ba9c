// robustness [clouds N] [gallery N] [files N] [--seed S] [--jobs J] [--threads T]
//            [--seconds S] [--time-limit TIMES] [--log FILE.jsonl]
// robustness --case NAME [--write FILE]
//
// Reconstructs clouds, each in a process of its own, and tells what went wrong. Names of cases say
// everything about them, so that any of them can be run again by itself. Leaves with 1 if a promise
// was broken or a resolved cloud came out wrong; what nobody could promise is counted and listed.
// Time is a promise only with a limit, as which 1 suits a machine of today.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "attempt.h"
#include "clouds.h"
#include "jobs.h"
#include "process_figures.h"

namespace shrinkwrap::robustness {
namespace {

struct Arguments {
  std::vector<std::pair<std::string, std::uint64_t>> kinds;  // and how many
  std::uint64_t seed = 1;
  double seconds = std::numeric_limits<double>::infinity();
  int jobs = 1;
  JobOptions options;
  std::string single_case, log, cloud_file;
};

std::string log_line(const Job& job, const ChildOutcome& outcome, const std::string& message) {
  std::vector<std::string> names;
  for (const Verdict verdict : verdicts_in(message)) names.push_back(verdict_name(verdict));
  benchmarking::JsonLine line;
  line.add("case", job.name).add("seconds", outcome.seconds).add("verdicts", names);
  // Three objects become one.
  const auto fields = [](const std::string& object) {
    return object.size() > 2 ? ", " + object.substr(1, object.size() - 2) : std::string();
  };
  const std::string head = line.text();
  return head.substr(0, head.size() - 1) + fields(job.description.text()) +
         fields(message.substr(message.find('\n') + 1)) + "}";
}

class Sweep {
 public:
  explicit Sweep(const Arguments& arguments) : arguments_(arguments) {
    if (!arguments.log.empty()) log_.open(arguments.log);
  }

  // All cases of a kind, several at a time.
  void run(const std::string& kind, std::uint64_t count) {
    std::list<Running> running;
    std::uint64_t started = 0;
    count = std::min(count, most_jobs(kind));
    while (true) {
      while (static_cast<int>(running.size()) < arguments_.jobs && started < count &&
             watch_.seconds() < arguments_.seconds)
        running.emplace_back(make_job(kind, job_number(kind, arguments_.seed, started++, count),
                                      arguments_.options));
      if (running.empty()) return;
      running.remove_if([&](Running& entry) {
        if (!entry.child->has_ended()) return false;
        note(entry.job, entry.child->outcome());
        return true;
      });
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  void run_one(const Job& job) {
    ChildProcess child(job.work, job.limits);
    child.wait();
    std::cout << log_line(job, child.outcome(), message_of(child.outcome())) << "\n";
    note(job, child.outcome());
  }

  const Tally& tally() const { return tally_; }

 private:
  struct Running {
    explicit Running(Job made)
        : job(std::move(made)), child(std::make_unique<ChildProcess>(job.work, job.limits)) {}
    Job job;
    std::unique_ptr<ChildProcess> child;
  };

  void note(const Job& job, const ChildOutcome& outcome) {
    const std::string message = message_of(outcome);
    tally_.add(job.name, message);
    if (log_.is_open()) log_ << log_line(job, outcome, message) << std::endl;
  }

  const Arguments& arguments_;
  std::ofstream log_;
  Tally tally_;
  benchmarking::Stopwatch watch_;
};

int run(const Arguments& arguments) {
  Sweep sweep(arguments);
  if (!arguments.single_case.empty()) {
    const bool write = !arguments.cloud_file.empty();
    JobOptions options = arguments.options;
    options.with_input = write;
    const Job job = make_job(arguments.single_case, options);
    if (write && job.file.empty())
      benchmarking::write_ply(arguments.cloud_file, job.points, true);
    else if (write)
      std::ofstream(arguments.cloud_file, std::ios::binary) << job.file;
    sweep.run_one(job);
  }
  for (const auto& [kind, count] : arguments.kinds) sweep.run(kind, count);
  sweep.tally().print(std::cout);
  return sweep.tally().is_clean() ? 0 : 1;
}

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "clouds" || name == "gallery" || name == "files")
      arguments.kinds.emplace_back(name, std::stoull(value));
    else if (name == "--case")
      arguments.single_case = value;
    else if (name == "--seed")
      arguments.seed = std::stoull(value);
    else if (name == "--seconds")
      arguments.seconds = std::stod(value);
    else if (name == "--jobs")
      arguments.jobs = std::max(1, std::stoi(value));
    else if (name == "--threads")
      arguments.options.threads = std::stoi(value);
    else if (name == "--time-limit")
      arguments.options.time_limit = std::stod(value);
    else if (name == "--log")
      arguments.log = value;
    else if (name == "--write")
      arguments.cloud_file = value;
    else
      return false;
  }
  return argc % 2 == 1 && (!arguments.kinds.empty() || !arguments.single_case.empty());
}

}  // namespace
}  // namespace shrinkwrap::robustness

int main(int argc, char** argv) {
  using namespace shrinkwrap::robustness;
  try {
    Arguments arguments;
    if (parse(argc, argv, arguments)) return run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "robustness: %s\n", error.what());
    return 2;
  }
  std::fprintf(stderr,
               "usage: robustness [clouds N] [gallery N] [files N] [--seed S] [--jobs J] "
               "[--threads T] [--seconds S] [--time-limit TIMES] [--log FILE.jsonl]\n"
               "       robustness --case NAME [--write FILE]   (NAME as clouds:1000003)\n");
  return 2;
}
