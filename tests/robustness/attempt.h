// One reconstruction and its verdicts, and the tally of many.
#pragma once

#include <iosfwd>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "json_line.h"
#include "judge.h"
#include "reconstruct.h"

namespace shrinkwrap::robustness {

/// What can be wrong, the broken promises first. One attempt may earn several.
enum class Verdict {
  // Never, whatever the input:
  crash,
  hang,
  out_of_memory,
  unexpected_exception,  ///< not of the library's own kinds
  not_closed,
  not_manifold,
  not_outward,
  accepted_invalid,  ///< a mesh of what must be refused
  missing_sample,    ///< V != N: a sample is no vertex, or two
  moved_sample,      ///< a vertex is not exactly at its sample
  dishonest_report,  ///< the library's own report says otherwise than the judge
  unread_file,       ///< one without damage, or other points than were written to it
  bad_stage_mesh,    ///< one of those that are kept is not closed, or not manifold
  genus_beyond,      ///< the greatest that was asked for
  nondeterministic,  ///< one and two threads differ
  too_slow,          ///< if a time limit was asked for
  // Not on clouds that resolve the shape:
  failed,
  refused,
  extra_vertices,   ///< V != N: vertices that are no sample
  sample_left_out,  ///< as an outlier, which it is not
  stray_kept,       ///< far from the object, as part of its surface
  false_opening,    ///< left where the object has none
  wrong_genus,
  wrong_components,
  self_intersecting,
  degenerate_faces,  ///< collinear corners
  // Known limits: honest refusals of clouds that nobody could promise, and what else is of
  // interest.
  wrong_topology_unresolved,
  failed_unresolved,
  refused_unresolved,
  extra_vertices_unresolved,
  self_intersecting_unresolved,
  degenerate_faces_unresolved,
  importer_failed,  ///< vcglib's, on a damaged file, before our part began
};
constexpr int kVerdictCount = 33;
const char* verdict_name(Verdict verdict);
enum class Severity { broken_promise, defect, note };
Severity severity_of(Verdict verdict);

/// What is known of the cloud.
struct Expectation {
  bool invalid = false;   ///< must be refused as invalid input
  bool resolved = false;  ///< dense and clean enough: must succeed, with these figures
  bool open = false;      ///< the object has openings: extra vertices are allowed
  int genus = 0;
  int components = 1;
  /// Points that are no samples of the object, ascending; and those of them that are far from it.
  std::vector<Index> strays, far_strays;
};

/// What is looked at besides the mesh.
struct Checks {
  bool compare_threads = false;  ///< reconstruct with one and with two threads, and compare
  /// A run may take this many times 4 s and 0.4 ms a sample of processor time: 1 suits a machine of
  /// today, and on a slow one nothing is known.
  double time_limit = std::numeric_limits<double>::infinity();
};

struct Attempt {
  std::vector<Verdict> verdicts;
  benchmarking::JsonLine figures;
};

/// What is wrong with the mesh of a run that was given so many `points`. Pre: `judgement` is of it.
std::vector<Verdict> verdicts_on(const Judgement& judgement, const Reconstruction& result,
                                 std::size_t points, const ReconstructionOptions& options,
                                 const Expectation& expectation);

/// Reconstructs and judges, with as many threads as the options say. Throws nothing.
Attempt attempt(const std::vector<Vec3>& points, ReconstructionOptions options,
                const Expectation& expectation, const Checks& checks);

/// A line of verdicts and a line of figures, to be sent through a pipe, and back.
std::string to_message(const Attempt& attempt);
std::vector<Verdict> verdicts_in(const std::string& message);

/// Counts verdicts and keeps the names of the first few attempts that earned each.
class Tally {
 public:
  /// `message` as to_message makes it.
  void add(const std::string& name, const std::string& message);

  bool is_clean() const;  ///< notes alone
  void print(std::ostream& out) const;

 private:
  void add(const std::string& name, Verdict verdict);

  struct Row {
    long count = 0;
    std::vector<std::string> first;
  };
  std::map<Verdict, Row> rows_;
  long attempts_ = 0;
};

}  // namespace shrinkwrap::robustness
