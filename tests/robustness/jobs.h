// What the runner runs: generated clouds, the gallery of degenerate ones, damaged files. Every job
// has a name that says everything about it.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "child_process.h"
#include "common/types.h"
#include "json_line.h"

namespace shrinkwrap::robustness {

struct Job {
  std::string name;  ///< "clouds:1000003"; makes the same job again
  benchmarking::JsonLine description;
  ChildLimits limits;
  Work work;  ///< says a message as to_message makes it
  // Only if asked for:
  std::vector<Vec3> points;  ///< unless they come from a file
  std::string file;          ///< its content, if they do
};

/// What is the same for all jobs of a run.
struct JobOptions {
  int threads = 1;                                              ///< as in ReconstructionOptions
  double time_limit = std::numeric_limits<double>::infinity();  ///< as in Checks
  bool with_input = false;                                      ///< keep points or file
};

/// Numbers of the jobs of one seed are this far apart.
constexpr std::uint64_t kNumbersPerSeed = 1000000;

/// How many jobs of a kind one seed has: as many as wanted, but for the gallery.
std::uint64_t most_jobs(const std::string& kind);

/// Of `count` jobs of a kind and seed, the number of the i-th: they follow each other, but those of
/// the gallery are spread over all of it. Pre: i < count <= most_jobs.
std::uint64_t job_number(const std::string& kind, std::uint64_t seed, std::uint64_t i,
                         std::uint64_t count);

/// `kind` is "clouds", "gallery" or "files".
/// Throws std::invalid_argument if there is no such job.
Job make_job(const std::string& kind, std::uint64_t number, const JobOptions& options);
/// By name.
Job make_job(const std::string& name, const JobOptions& options);

/// What a child that ended has to say: its message, or the verdict that it could not say itself.
std::string message_of(const ChildOutcome& outcome);

}  // namespace shrinkwrap::robustness
