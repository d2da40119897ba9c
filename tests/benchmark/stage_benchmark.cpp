// stage_benchmark (--shape NAME --samples N | --cloud FILE.ply [--samples N]) [--threads T]
//                 [--progress] [--cancel-at FRACTION] [--output MESH.off]
//
// One reconstruction in one process, and one line of JSON about it: seconds and peak memory of each
// stage, the matching report, and a checksum of the result, which must not depend on the number of
// threads. Memory is what the process holds at most, less what it held before (the points given).
// --progress adds how the callback was called; --cancel-at makes it return false at that fraction
// and says how long it took until the run had ended.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "clouds.h"
#include "json_line.h"
#include "process_figures.h"
#include "reconstruct.h"

namespace shrinkwrap::benchmarking {
namespace {

struct Arguments {
  CloudChoice cloud;
  int threads = 0;
  bool report_progress = false;
  double cancel_at = std::numeric_limits<double>::infinity();
  std::string output;
};

struct StageFigures {
  std::string name;
  double begin = 0.0;
  double seconds = 0.0;
  double largest_gap = 0.0;      // longest silence, in seconds
  double largest_gap_end = 0.0;  // overall fraction that ended it
  std::uint64_t peak_bytes = 0;
};

// The progress callback: what it is told is all that is known of the stages from outside.
class Observer {
 public:
  explicit Observer(double cancel_at) : cancel_at_(cancel_at) {
    can_reset_memory_ = reset_peak_resident_bytes();
  }

  bool operator()(double fraction, const char* stage) {
    const double now = watch_.seconds();
    note_call(now, fraction);
    if (stages_.empty() || stages_.back().name != stage) {
      end_stage(now);
      stages_.push_back({stage, now});
      last_call_ = watch_.seconds();  // reading the memory figures is not the stage's silence
    }
    if (fraction >= cancel_at_ && cancelled_at_ < 0.0) cancelled_at_ = now;
    return cancelled_at_ < 0.0;
  }

  void end() {
    seconds_ = watch_.seconds();
    note_gap(seconds_, 1.0);
    end_stage(seconds_);
  }

  double seconds() const { return seconds_; }
  double seconds_from_cancel() const { return seconds_ - cancelled_at_; }
  bool was_cancelled() const { return cancelled_at_ >= 0.0; }
  bool can_reset_memory() const { return can_reset_memory_; }
  const std::vector<StageFigures>& stages() const { return stages_; }
  std::uint64_t peak_bytes() const { return peak_bytes_; }

  JsonLine progress() const {
    return JsonLine()
        .add("calls", calls_)
        .add("calls_per_second", calls_ / std::max(seconds_, 1e-9))
        .add("monotone", monotone_)
        .add("within_bounds", within_bounds_)
        .add("first_fraction", first_fraction_)
        .add("last_fraction", last_fraction_)
        .add("calls_after_cancel", calls_after_cancel_);
  }

 private:
  void end_stage(double now) {
    const std::uint64_t peak = peak_resident_bytes();
    peak_bytes_ = std::max(peak_bytes_, peak);
    if (!stages_.empty()) {
      stages_.back().seconds = now - stages_.back().begin;
      stages_.back().peak_bytes = peak;
    }
    reset_peak_resident_bytes();
  }

  void note_call(double now, double fraction) {
    note_gap(now, fraction);
    if (calls_ == 0) first_fraction_ = fraction;
    ++calls_;
    if (cancelled_at_ >= 0.0) ++calls_after_cancel_;
    monotone_ = monotone_ && fraction >= last_fraction_;
    within_bounds_ = within_bounds_ && fraction >= 0.0 && fraction <= 1.0;
    last_fraction_ = fraction;
  }

  // A silence belongs to the stage in which it began.
  void note_gap(double now, double fraction) {
    if (!stages_.empty() && now - last_call_ > stages_.back().largest_gap) {
      stages_.back().largest_gap = now - last_call_;
      stages_.back().largest_gap_end = fraction;
    }
    last_call_ = now;
  }

  double cancel_at_;
  Stopwatch watch_;
  std::vector<StageFigures> stages_;
  std::uint64_t peak_bytes_ = 0;
  bool can_reset_memory_ = false;
  double seconds_ = 0.0, cancelled_at_ = -1.0;
  long calls_ = 0;
  bool monotone_ = true, within_bounds_ = true;
  double first_fraction_ = 0.0, last_fraction_ = 0.0;
  long calls_after_cancel_ = 0;
  double last_call_ = 0.0;
};

// FNV-1a over the bytes of the mesh.
class Checksum {
 public:
  template <class Value>
  void add(const std::vector<Value>& values) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    for (std::size_t i = 0; i < values.size() * sizeof(Value); ++i)
      hash_ = (hash_ ^ bytes[i]) * 0x100000001b3ull;
  }
  std::string text() const {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash_));
    return digits;
  }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

void add_report(JsonLine& line, const Reconstruction& result) {
  const MeshReport& report = result.report;
  line.add("vertices", report.vertices)
      .add("closed", report.closed())
      .add("manifold", report.manifold())
      .add("outward", report.outward())
      .add("matched", report.complete_matching())
      .add("extra_vertices", report.vertices_extra)
      .add("components", report.components)
      .add("genus", report.genus)
      .add("self_intersecting_faces", report.self_intersecting_faces)
      .add("spacing", result.spacing)
      .add("mean_foot_distance", result.complete_matching.mean_foot_distance)
      .add("max_foot_distance", result.complete_matching.max_foot_distance);
  Checksum checksum;
  checksum.add(result.mesh.position);
  checksum.add(result.mesh.input_index);
  checksum.add(result.mesh.triangles);
  line.add("checksum", checksum.text());
}

void write_off(const std::string& name, const ResultMesh& mesh) {
  std::ofstream file(name);
  file.precision(17);
  file << "OFF\n" << mesh.position.size() << " " << mesh.triangles.size() << " 0\n";
  for (const Vec3& p : mesh.position) file << p.x() << " " << p.y() << " " << p.z() << "\n";
  for (const auto& [a, b, c] : mesh.triangles) file << "3 " << a << " " << b << " " << c << "\n";
  if (!file) throw InvalidInput("cannot write " + name);
}

int run(const Arguments& arguments) {
  const std::vector<Vec3> points = make_cloud(arguments.cloud);
  return_free_memory();
  const std::uint64_t baseline = resident_bytes();

  ReconstructionOptions options;
  options.threads = arguments.threads;
  Reconstruction result;
  std::string error;
  Observer observer(arguments.cancel_at);
  const double processor_before = processor_seconds();
  {
    Progress progress([&](double fraction, const char* stage) { return observer(fraction, stage); },
                      stages_of(options));
    try {
      result = reconstruct(points, options, progress);
    } catch (const Cancelled&) {
      // The observer knows.
    } catch (const std::exception& thrown) {
      error = thrown.what();
    }
    observer.end();
  }
  const double processor = processor_seconds() - processor_before;

  const auto over_baseline = [&](std::uint64_t bytes) {
    return bytes > baseline ? bytes - baseline : std::uint64_t{0};
  };
  std::vector<JsonLine> stages;
  for (const StageFigures& stage : observer.stages())
    stages.push_back(JsonLine()
                         .add("name", stage.name)
                         .add("seconds", stage.seconds)
                         .add("largest_gap_seconds", stage.largest_gap)
                         .add("largest_gap_end", stage.largest_gap_end)
                         .add("peak_bytes", over_baseline(stage.peak_bytes)));
  JsonLine line;
  line.add("program", "shrink wrap")
      .add("cloud", arguments.cloud.name())
      .add("samples", points.size())
      .add("threads", arguments.threads)
      .add("seconds", observer.seconds())
      .add("processor_seconds", processor)
      .add("stages", stages)
      .add("memory_per_stage", observer.can_reset_memory())
      .add("baseline_bytes", baseline)
      .add("peak_bytes", over_baseline(observer.peak_bytes()))
      .add("bytes_per_sample", static_cast<double>(over_baseline(observer.peak_bytes())) /
                                   static_cast<double>(std::max<std::size_t>(points.size(), 1)));
  if (arguments.report_progress) line.add("progress", observer.progress());
  if (observer.was_cancelled())
    line.add("cancelled_after_seconds", observer.seconds_from_cancel());
  else if (error.empty())
    add_report(line, result);
  else
    line.add("error", error);
  std::printf("%s\n", line.text().c_str());
  if (!arguments.output.empty()) write_off(arguments.output, result.mesh);
  return error.empty() ? 0 : 1;
}

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--progress") {
      arguments.report_progress = true;
      continue;
    }
    if (i + 1 == argc) return false;
    const std::string value = argv[++i];
    if (name == "--threads")
      arguments.threads = std::stoi(value);
    else if (name == "--cancel-at")
      arguments.cancel_at = std::stod(value);
    else if (name == "--output")
      arguments.output = value;
    else if (!arguments.cloud.take(name, value))
      return false;
  }
  return !arguments.cloud.name().empty();
}

}  // namespace
}  // namespace shrinkwrap::benchmarking

int main(int argc, char** argv) {
  using namespace shrinkwrap::benchmarking;
  try {
    Arguments arguments;
    if (parse(argc, argv, arguments)) return run(arguments);
    std::fprintf(stderr,
                 "usage: stage_benchmark (--shape NAME --samples N | --cloud FILE.ply [--samples "
                 "N]) [--threads T]\n       [--progress] [--cancel-at FRACTION] [--output "
                 "MESH.off]\n");
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stage_benchmark: %s\n", error.what());
    return 1;
  }
}
