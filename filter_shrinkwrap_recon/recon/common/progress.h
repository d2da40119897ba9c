// Progress and cancellation of a run: declared stages, one monotone fraction, one callback on the
// caller's thread.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <initializer_list>
#include <thread>
#include <vector>

namespace shrinkwrap {

/// The stages of the method, in order. A run declares which of them it will pass.
enum class Stage {
  samples,
  outliers,
  orientation,
  initial_mesh,
  control_mesh,
  parametric_surface,
  complete_matching,
  edge_optimisation,
  report,
};
constexpr int kStageCount = 9;

/// Short name for progress bars, logs and tables, for example "control mesh".
const char* stage_name(Stage stage);

/// Maps the work of the declared stages to one fraction in [0, 1] that never falls, calls the
/// callback at most every 20 ms, only from the thread that constructed the object, and throws
/// Cancelled after it returned false.
///
/// A stage calls `begin(stage)` first, and again where it goes on after another one, and
/// `update(fraction)` often; both are cheap. `update` may be
/// called from worker threads: there it only records, and throws Cancelled if a cancel is pending.
class Progress {
 public:
  /// Receives the overall fraction and the name of the current stage; returns false to cancel.
  using Callback = std::function<bool(double fraction, const char* stage)>;

  Progress() = default;  ///< silent, never cancelled
  Progress(Callback callback, std::initializer_list<Stage> stages);
  Progress(Callback callback, const std::vector<Stage>& stages);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Enters a stage and tells the callback at once. Undeclared stages are allowed and advance
  /// nothing (used when stages are run on their own).
  void begin(Stage stage);
  /// Maps all of the current stage to [from, to] of its share until another stage begins, for a
  /// stage that is made of several functions, or runs one of them twice: each calls `begin` and
  /// `set_range` as if it were alone.
  void set_part(double from, double to);
  /// Reports the fraction done of the current stage, in [0, 1]. Throws Cancelled.
  void update(double fraction_of_stage);
  /// Maps `update` of the code that follows to [from, to] of the current stage. Sub-ranges do not
  /// nest.
  void set_range(double from, double to);
  /// The fraction of the whole run at which a declared stage begins.
  double begin_of(Stage stage) const { return stage_begin_[static_cast<int>(stage)]; }
  /// True once the callback has asked to stop.
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  friend class ProgressShare;
  void call(double fraction_of_part);

  Callback callback_;
  std::thread::id owner_ = std::this_thread::get_id();
  double stage_begin_[kStageCount] = {};
  double stage_weight_[kStageCount] = {};
  Stage stage_ = Stage::samples;
  double range_from_ = 0.0, range_to_ = 1.0;  // of the part
  double part_from_ = 0.0, part_to_ = 1.0;    // of the stage
  double share_from_ = 0.0, share_to_ = 1.0;  // of the run
  double last_fraction_ = 0.0;
  std::chrono::steady_clock::time_point last_call_{};
  std::atomic<bool> cancelled_{false};
};

/// While it lives, the whole run is mapped to [from, to] of what it was mapped to before: for a run
/// that may have to begin again, or from some stage on. Shares nest.
class ProgressShare {
 public:
  ProgressShare(Progress& progress, double from, double to)
      : progress_(progress), from_(progress.share_from_), to_(progress.share_to_) {
    progress.share_from_ = from_ + (to_ - from_) * from;
    progress.share_to_ = from_ + (to_ - from_) * to;
  }
  ~ProgressShare() {
    progress_.share_from_ = from_;
    progress_.share_to_ = to_;
  }
  ProgressShare(const ProgressShare&) = delete;
  ProgressShare& operator=(const ProgressShare&) = delete;

 private:
  Progress& progress_;
  double from_, to_;
};

}  // namespace shrinkwrap
