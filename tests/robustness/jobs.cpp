#include "jobs.h"

#include <array>
#include <limits>
#include <stdexcept>

#include "attempt.h"
#include "cases.h"
#include "files.h"
#include "gallery.h"

namespace shrinkwrap::robustness {
namespace {

constexpr std::uint64_t kCompareThreadsEvery = 20;
constexpr double kMostSeconds = 300.0;  // of the clock and of the processor, which others may use

struct GalleryVariant {
  const char* name;
  ReconstructionOptions options;
  bool keeps_expectations;  ///< of the mesh; what must be refused is refused by all
};

std::array<GalleryVariant, 8> gallery_variants() {
  const ReconstructionOptions robust;
  ReconstructionOptions in_doubles = robust, left_open = robust, surface_only = robust;
  in_doubles.host_scalar = HostScalar::double_precision;
  left_open.complete_matching.openings = CompleteMatchingOptions::Openings::leave_open;
  surface_only.stop_at_parametric_surface = true;
  ReconstructionOptions automatic = robust, every_sample = robust, open_surface = left_open;
  automatic.complete_matching.openings = CompleteMatchingOptions::Openings::automatic;
  every_sample.outliers.exclude = false;
  open_surface.stop_at_parametric_surface = true;
  return {{{"standard", robust, true},
           {"double", in_doubles, true},
           {"leave_open", left_open, false},
           {"stop_at_surface", surface_only, false},
           {"as_in_the_paper", as_in_the_paper(), false},
           {"stop_and_leave_open", open_surface, false},
           {"automatic_openings", automatic, false},
           {"every_sample", every_sample, false}}};
}

Job cloud_job(std::uint64_t number, const JobOptions& job_options) {
  Job job;
  const Case generated = case_of(number);
  job.description = describe(generated);
  if (job_options.with_input) job.points = cloud_of(generated).points;
  job.work = [generated, job_options](const Say& say) {
    const CaseCloud cloud = cloud_of(generated);
    ReconstructionOptions options = options_of(generated);
    options.threads = job_options.threads;
    const bool compare_threads =
        generated.number % kCompareThreadsEvery == kCompareThreadsEvery - 1;
    Attempt made = attempt(cloud.points, options, cloud.expectation,
                           {compare_threads, job_options.time_limit});
    made.figures.add("points", cloud.points.size())
        .add("resolved", cloud.expectation.resolved)
        .add("open", cloud.expectation.open)
        .add("least_feature", cloud.least_feature)
        .add("true_genus", cloud.expectation.genus)
        .add("true_components", cloud.expectation.components);
    say(to_message(made));
  };
  return job;
}

Job gallery_job(std::uint64_t number, const JobOptions& job_options) {
  Job job;
  const auto variants = gallery_variants();
  const std::uint64_t index = number % kNumbersPerSeed;
  const GalleryVariant& variant = variants[index % variants.size()];
  std::vector<Exhibit> exhibits = gallery(static_cast<unsigned>(number / kNumbersPerSeed));
  if (index / variants.size() >= exhibits.size())
    throw std::invalid_argument("the gallery has only " +
                                std::to_string(exhibits.size() * variants.size()) + " jobs");
  Exhibit exhibit = std::move(exhibits[index / variants.size()]);
  if (!variant.keeps_expectations) exhibit.expectation.resolved = false;
  job.description.add("exhibit", exhibit.name)
      .add("variant", variant.name)
      .add("points", exhibit.points.size())
      .add("resolved", exhibit.expectation.resolved);
  if (job_options.with_input) job.points = exhibit.points;
  const Checks checks = {true, job_options.time_limit};
  job.work = [exhibit, options = variant.options, checks](const Say& say) {
    say(to_message(attempt(exhibit.points, options, exhibit.expectation, checks)));
  };
  return job;
}

}  // namespace

std::uint64_t most_jobs(const std::string& kind) {
  if (kind != "gallery") return kNumbersPerSeed;
  static const std::uint64_t exhibits = gallery(0).size();
  return exhibits * gallery_variants().size();
}

std::uint64_t job_number(const std::string& kind, std::uint64_t seed, std::uint64_t i,
                         std::uint64_t count) {
  return seed * kNumbersPerSeed + (kind == "gallery" ? i * most_jobs(kind) / count : i);
}

Job make_job(const std::string& kind, std::uint64_t number, const JobOptions& options) {
  Job job;
  if (kind == "clouds")
    job = cloud_job(number, options);
  else if (kind == "gallery")
    job = gallery_job(number, options);
  else if (kind == "files")
    job = file_job(number, options);
  else
    throw std::invalid_argument("there are no jobs called '" + kind + "'");
  job.name = kind + ":" + std::to_string(number);
  job.limits.seconds = job.limits.processor_seconds = kMostSeconds;
  return job;
}

Job make_job(const std::string& name, const JobOptions& options) {
  const std::size_t colon = name.find(':');
  if (colon == std::string::npos)
    throw std::invalid_argument("'" + name + "' is no job: one is called 'clouds:1000003'");
  return make_job(name.substr(0, colon), std::stoull(name.substr(colon + 1)), options);
}

std::string message_of(const ChildOutcome& outcome) {
  using End = ChildOutcome::End;
  if (outcome.end == End::finished && !outcome.output.empty()) return outcome.output;
  Attempt ended;  // or it left without a word
  ended.verdicts = {outcome.end == End::too_slow ? Verdict::hang : Verdict::crash};
  ended.figures.add("ended_by", outcome.how);
  return to_message(ended);
}

}  // namespace shrinkwrap::robustness
