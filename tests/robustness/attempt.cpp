#include "attempt.h"

#include <algorithm>
#include <functional>
#include <iomanip>
#include <new>
#include <ostream>
#include <sstream>

#include "expect_mesh.h"
#include "process_figures.h"

namespace shrinkwrap::robustness {
namespace {

constexpr std::size_t kNamesKept = 5;
constexpr double kSeconds = 4.0, kSecondsPerPoint = 4e-4;  // of which the time limit is a multiple

// The outcome of one run: a mesh, or how it was refused.
struct Outcome {
  Reconstruction result;
  std::string message;  ///< empty: a mesh
  Verdict verdict = Verdict::crash;
  bool has_mesh() const { return message.empty(); }
};

Outcome run(const std::vector<Vec3>& points, const ReconstructionOptions& options, bool resolved) {
  Outcome outcome;
  try {
    Progress progress;
    outcome.result = reconstruct(points, options, progress);
  } catch (const InvalidInput& error) {
    outcome.message = error.what();
    outcome.verdict = resolved ? Verdict::refused : Verdict::refused_unresolved;
  } catch (const ReconstructionFailed& error) {
    outcome.message = error.what();
    outcome.verdict = resolved ? Verdict::failed : Verdict::failed_unresolved;
  } catch (const std::bad_alloc&) {
    outcome.message = "out of memory";
    outcome.verdict = Verdict::out_of_memory;
  } catch (const std::exception& error) {
    outcome.message = error.what();
    outcome.verdict = Verdict::unexpected_exception;
  } catch (...) {
    outcome.message = "unknown exception";
    outcome.verdict = Verdict::unexpected_exception;
  }
  return outcome;
}

bool same(const Outcome& a, const Outcome& b) {
  return a.message == b.message && a.result.mesh.position == b.result.mesh.position &&
         a.result.mesh.triangles == b.result.mesh.triangles &&
         a.result.mesh.input_index == b.result.mesh.input_index;
}

// Points that were given, each once, in their order.
bool are_indices(const std::vector<Index>& left_out, std::size_t points) {
  return std::adjacent_find(left_out.begin(), left_out.end(), std::greater_equal<>()) ==
             left_out.end() &&
         (left_out.empty() ||
          (left_out.front() >= 0 && left_out.back() < static_cast<Index>(points)));
}

bool is_closed_manifold(const ResultMesh& mesh) {
  return testing::topology_of(static_cast<Index>(mesh.position.size()), mesh.triangles)
      .closed_manifold();
}

bool agrees(const Judgement& judgement, const MeshReport& report) {
  const bool counts_agree =
      report.samples_missing == judgement.missing && report.vertices_extra == judgement.extra &&
      report.closed() == judgement.closed() && report.manifold() == judgement.manifold;
  const bool counted = judgement.intersecting >= 0 && report.self_intersecting_faces >= 0;
  return counts_agree && (!counted || report.self_intersecting_faces == judgement.intersecting);
}

}  // namespace

std::vector<Verdict> verdicts_on(const Judgement& judgement, const Reconstruction& result,
                                 std::size_t points, const ReconstructionOptions& options,
                                 const Expectation& expectation) {
  std::vector<Verdict> verdicts;
  const auto if_so = [&](bool holds, Verdict verdict) {
    if (holds) verdicts.push_back(verdict);
  };
  const bool may_be_open =
      options.complete_matching.openings != CompleteMatchingOptions::Openings::close;
  if_so(!judgement.closed() && !may_be_open, Verdict::not_closed);
  if_so(!judgement.manifold, Verdict::not_manifold);
  if_so(expectation.invalid, Verdict::accepted_invalid);
  if_so(judgement.manifold && judgement.closed() && !judgement.outward, Verdict::not_outward);
  if_so(!agrees(judgement, result.report) || !are_indices(result.outliers.input_index, points),
        Verdict::dishonest_report);
  const bool resolved = expectation.resolved;
  const std::vector<Index>& left_out = result.outliers.input_index;
  if_so(resolved && count_difference(left_out, expectation.strays) > 0, Verdict::sample_left_out);
  if_so(resolved && options.outliers.exclude &&
            count_difference(expectation.far_strays, left_out) > 0,
        Verdict::stray_kept);
  for (const StageRecord& stage : result.stages)
    if (!may_be_open && !stage.mesh.triangles.empty() && !is_closed_manifold(stage.mesh)) {
      verdicts.push_back(Verdict::bad_stage_mesh);
      break;
    }

  if (!options.stop_at_parametric_surface) {
    if_so(judgement.moved > 0, Verdict::moved_sample);
    if_so(judgement.missing > 0 || judgement.repeated > 0, Verdict::missing_sample);
    if_so(judgement.extra > 0, resolved && !expectation.open ? Verdict::extra_vertices
                                                             : Verdict::extra_vertices_unresolved);
  }
  if_so(resolved && !expectation.open && !judgement.closed() && may_be_open,
        Verdict::false_opening);
  if (judgement.genus >= 0) {
    const Index most = options.initial_mesh.maximum_genus;
    if_so(most >= 0 && judgement.genus > most, Verdict::genus_beyond);
    const bool right_genus = judgement.genus == expectation.genus;
    const bool right_components = judgement.components == expectation.components;
    if_so(resolved && !right_genus, Verdict::wrong_genus);
    if_so(resolved && !right_components, Verdict::wrong_components);
    if_so(!resolved && !(right_genus && right_components), Verdict::wrong_topology_unresolved);
  }
  if_so(judgement.intersecting > 0,
        resolved ? Verdict::self_intersecting : Verdict::self_intersecting_unresolved);
  if_so(judgement.degenerate > 0,
        resolved ? Verdict::degenerate_faces : Verdict::degenerate_faces_unresolved);
  return verdicts;
}

const char* verdict_name(Verdict verdict) {
  static constexpr const char* names[kVerdictCount] = {
      "crash",
      "hang",
      "out_of_memory",
      "unexpected_exception",
      "not_closed",
      "not_manifold",
      "not_outward",
      "accepted_invalid",
      "missing_sample",
      "moved_sample",
      "dishonest_report",
      "unread_file",
      "bad_stage_mesh",
      "genus_beyond",
      "nondeterministic",
      "too_slow",
      "failed",
      "refused",
      "extra_vertices",
      "sample_left_out",
      "stray_kept",
      "false_opening",
      "wrong_genus",
      "wrong_components",
      "self_intersecting",
      "degenerate_faces",
      "wrong_topology_unresolved",
      "failed_unresolved",
      "refused_unresolved",
      "extra_vertices_unresolved",
      "self_intersecting_unresolved",
      "degenerate_faces_unresolved",
      "importer_failed",
  };
  return names[static_cast<int>(verdict)];
}

Severity severity_of(Verdict verdict) {
  if (verdict < Verdict::failed) return Severity::broken_promise;
  return verdict < Verdict::wrong_topology_unresolved ? Severity::defect : Severity::note;
}

Attempt attempt(const std::vector<Vec3>& points, ReconstructionOptions options,
                const Expectation& expectation, const Checks& checks) {
  Attempt made;
  const double before = benchmarking::processor_seconds();
  if (checks.compare_threads) options.threads = 1;
  const Outcome outcome = run(points, options, expectation.resolved);
  const double seconds = benchmarking::processor_seconds() - before;
  made.figures.add("processor_seconds", seconds);
  const double usual = kSeconds + kSecondsPerPoint * static_cast<double>(points.size());
  if (seconds > checks.time_limit * usual) made.verdicts.push_back(Verdict::too_slow);
  if (checks.compare_threads) {
    options.threads = 2;
    if (!same(outcome, run(points, options, expectation.resolved)))
      made.verdicts.push_back(Verdict::nondeterministic);
  }
  if (!outcome.has_mesh()) {
    made.figures.add("message", outcome.message);
    const bool rightly_refused =
        expectation.invalid && outcome.verdict == Verdict::refused_unresolved;
    if (!rightly_refused) made.verdicts.push_back(outcome.verdict);
    return made;
  }

  const std::vector<Index>& left_out = outcome.result.outliers.input_index;
  if (!are_indices(left_out, points.size())) {
    made.verdicts.push_back(Verdict::dishonest_report);
    return made;
  }
  // Where none may be left out, one that was is missing.
  const Judgement judgement =
      judge(points, options.outliers.exclude ? left_out : std::vector<Index>(), outcome.result.mesh,
            true);
  for (const Verdict verdict :
       verdicts_on(judgement, outcome.result, points.size(), options, expectation))
    made.verdicts.push_back(verdict);
  made.figures.add("samples", judgement.samples)
      .add("left_out", left_out.size())
      .add("samples_left_out", count_difference(left_out, expectation.strays))
      .add("far_strays", expectation.far_strays.size())
      .add("far_strays_kept", count_difference(expectation.far_strays, left_out))
      .add("vertices", judgement.vertices)
      .add("border_edges", judgement.border_edges)
      .add("missing", judgement.missing)
      .add("extra", judgement.extra)
      .add("components", judgement.components)
      .add("genus", judgement.genus)
      .add("intersecting_faces", judgement.intersecting)
      .add("degenerate_faces", judgement.degenerate)
      .add("intersecting_faces_reported", outcome.result.report.self_intersecting_faces)
      .add("max_foot_distance", outcome.result.complete_matching.max_foot_distance);
  return made;
}

std::string to_message(const Attempt& attempt) {
  std::string verdicts;
  for (const Verdict verdict : attempt.verdicts)
    verdicts += std::to_string(static_cast<int>(verdict)) + " ";
  return verdicts + "\n" + attempt.figures.text();
}

std::vector<Verdict> verdicts_in(const std::string& message) {
  std::istringstream numbers(message.substr(0, message.find('\n')));
  std::vector<Verdict> verdicts;
  for (int number; numbers >> number;) verdicts.push_back(static_cast<Verdict>(number));
  return verdicts;
}

void Tally::add(const std::string& name, const std::string& message) {
  ++attempts_;
  for (const Verdict verdict : verdicts_in(message)) add(name, verdict);
}

void Tally::add(const std::string& name, Verdict verdict) {
  Row& row = rows_[verdict];
  ++row.count;
  if (row.first.size() < kNamesKept) row.first.push_back(name);
}

bool Tally::is_clean() const {
  // The map is ordered by verdict, the worst first.
  return rows_.empty() || severity_of(rows_.begin()->first) == Severity::note;
}

void Tally::print(std::ostream& out) const {
  static constexpr const char* headings[] = {"broken promises", "defects on resolved clouds",
                                             "notes on clouds of which nothing can be expected"};
  out << attempts_ << " attempts\n";
  for (const Severity severity : {Severity::broken_promise, Severity::defect, Severity::note}) {
    out << headings[static_cast<int>(severity)] << ":\n";
    bool any = false;
    for (const auto& [verdict, row] : rows_) {
      if (severity_of(verdict) != severity) continue;
      any = true;
      out << "  " << std::left << std::setw(30) << verdict_name(verdict) << std::right
          << std::setw(7) << row.count << "   first:";
      for (const std::string& name : row.first) out << " " << name;
      out << "\n";
    }
    if (!any) out << "  none\n";
  }
}

}  // namespace shrinkwrap::robustness
