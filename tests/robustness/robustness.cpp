// robustness [--from K] [--cases N] [--seconds S] [--jobs J] [--threads T]
//            [--log FILE.jsonl]
// robustness --case NUMBER [--write CLOUD.ply]
//
// Reconstructs generated clouds, each in a process of its own, and tells what went wrong. Case
// numbers say everything about a cloud, so that any of them can be run again by itself. Leaves with
// 1 if a promise was broken; what is merely short of perfect is counted and listed.
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

#include "cases.h"
#include "child_process.h"
#include "clouds.h"
#include "process_figures.h"

namespace shrinkwrap::robustness {
namespace {

constexpr std::uint64_t kCompareThreadsEvery = 20;

struct Arguments {
  std::uint64_t from = 0;
  std::uint64_t cases = std::numeric_limits<std::uint64_t>::max();
  double seconds = std::numeric_limits<double>::infinity();
  int jobs = 1;
  int threads = 1;
  bool single_case = false;
  std::string log, cloud_file;
};

std::string run_case(std::uint64_t number, const Arguments& arguments) {
  const Case generated = case_of(number);
  const CaseCloud cloud = cloud_of(generated);
  ReconstructionOptions options = options_of(generated);
  options.threads = arguments.threads;
  Attempt made = attempt(cloud.points, options, cloud.expectation,
                         number % kCompareThreadsEvery == kCompareThreadsEvery - 1);
  made.figures.add("points", cloud.points.size())
      .add("resolved", cloud.expectation.resolved)
      .add("least_feature", cloud.least_feature)
      .add("true_genus", cloud.expectation.genus)
      .add("true_components", cloud.expectation.components);
  return to_message(made);
}

// The verdict of a child that could not say it itself.
std::string message_of(const ChildOutcome& outcome) {
  if (outcome.end == ChildOutcome::End::finished) return outcome.output;
  Attempt ended;
  ended.verdicts = {outcome.end == ChildOutcome::End::crashed ? Verdict::crash : Verdict::hang};
  ended.figures.add("ended_by", outcome.how);
  return to_message(ended);
}

std::string log_line(std::uint64_t number, const ChildOutcome& outcome,
                     const std::string& message) {
  std::vector<std::string> names;
  const std::size_t end = message.find('\n');
  for (std::size_t begin = 0; begin < end;) {
    const std::size_t space = message.find(' ', begin);
    names.push_back(verdict_name(static_cast<Verdict>(std::stoi(message.substr(begin)))));
    begin = space + 1;
  }
  benchmarking::JsonLine line = describe(case_of(number));
  line.add("seconds", outcome.seconds).add("verdicts", names);
  const std::string figures = message.substr(end + 1);
  const std::string head = line.text();
  return head.substr(0, head.size() - 1) + ", " + figures.substr(1);
}

struct Running {
  std::uint64_t number;
  std::unique_ptr<ChildProcess> child;
};

int sweep(const Arguments& arguments) {
  std::ofstream log;
  if (!arguments.log.empty()) log.open(arguments.log);
  Tally tally;
  const benchmarking::Stopwatch watch;
  std::list<Running> running;
  std::uint64_t started = 0;
  while (true) {
    while (static_cast<int>(running.size()) < arguments.jobs && started < arguments.cases &&
           watch.seconds() < arguments.seconds) {
      const std::uint64_t number = arguments.from + started++;
      running.push_back({number, std::make_unique<ChildProcess>(
                                     [&] { return run_case(number, arguments); }, ChildLimits{})});
    }
    if (running.empty()) break;
    for (auto entry = running.begin(); entry != running.end();) {
      if (!entry->child->has_ended()) {
        ++entry;
        continue;
      }
      const ChildOutcome& outcome = entry->child->outcome();
      const std::string message = message_of(outcome);
      tally.count_attempt();
      tally.add(std::to_string(entry->number), message);
      if (log.is_open()) log << log_line(entry->number, outcome, message) << std::endl;
      entry = running.erase(entry);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  tally.print(std::cout);
  return tally.promise_broken() ? 1 : 0;
}

int run_one(const Arguments& arguments) {
  if (!arguments.cloud_file.empty())
    benchmarking::write_ply(arguments.cloud_file, cloud_of(case_of(arguments.from)).points, true);
  const ChildOutcome outcome =
      run_in_child([&] { return run_case(arguments.from, arguments); }, ChildLimits{});
  const std::string message = message_of(outcome);
  Tally tally;
  tally.count_attempt();
  tally.add(std::to_string(arguments.from), message);
  std::cout << log_line(arguments.from, outcome, message) << "\n";
  tally.print(std::cout);
  return tally.promise_broken() ? 1 : 0;
}

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (i + 1 == argc) return false;
    const std::string value = argv[++i];
    if (name == "--case") {
      arguments.single_case = true;
      arguments.from = std::stoull(value);
    } else if (name == "--from") {
      arguments.from = std::stoull(value);
    } else if (name == "--cases") {
      arguments.cases = std::stoull(value);
    } else if (name == "--seconds") {
      arguments.seconds = std::stod(value);
    } else if (name == "--jobs") {
      arguments.jobs = std::max(1, std::stoi(value));
    } else if (name == "--threads") {
      arguments.threads = std::stoi(value);
    } else if (name == "--log") {
      arguments.log = value;
    } else if (name == "--write") {
      arguments.cloud_file = value;
    } else {
      return false;
    }
  }
  const bool bounded = arguments.cases != std::numeric_limits<std::uint64_t>::max() ||
                       arguments.seconds != std::numeric_limits<double>::infinity();
  return arguments.single_case || bounded;
}

}  // namespace
}  // namespace shrinkwrap::robustness

int main(int argc, char** argv) {
  using namespace shrinkwrap::robustness;
  try {
    Arguments arguments;
    if (parse(argc, argv, arguments))
      return arguments.single_case ? run_one(arguments) : sweep(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "robustness: %s\n", error.what());
    return 2;
  }
  std::fprintf(stderr,
               "usage: robustness [--from K] [--cases N] [--seconds S] [--jobs J] [--threads T] "
               "[--paper] [--log FILE.jsonl]\n       robustness --case NUMBER [--write "
               "CLOUD.ply]\n--cases or --seconds is needed.\n");
  return 2;
}
