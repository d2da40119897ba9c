// The rows of table 1 of a run: which stage left how many vertices, and how long it took.
#pragma once

#include <chrono>
#include <utility>

#include "reconstruct.h"

namespace shrinkwrap {

class Stopwatch {
 public:
  /// Seconds since the construction or the lap before.
  double lap() {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
    return seconds;
  }
  /// Does what is not to be timed.
  template <class Work>
  void stand_still_for(const Work& work) {
    const auto stopped = Clock::now();
    work();
    begin_ += Clock::now() - stopped;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

/// Adds rows to `result.stages` while the stages pass by. `make_mesh` is called only if the caller
/// wants the meshes of the stages (`keep_stages`); its time is not the stage's.
class StageLog {
 public:
  StageLog(Reconstruction& result, const ReconstructionOptions& options)
      : rows_(result.stages), keep_meshes_(options.keep_stages) {}

  /// The stage that took all the time since the row before.
  void add(Stage stage, Index vertices) {
    StageRecord row;
    row.name = stage_name(stage);
    row.vertices = vertices;
    row.seconds = watch_.lap();
    rows_.push_back(std::move(row));
  }
  template <class MakeMesh>
  void add(Stage stage, Index vertices, const MakeMesh& make_mesh) {
    add(stage, vertices);
    keep(make_mesh);
  }
  /// The last stage took longer, and left so many vertices.
  void go_on(Index vertices) {
    rows_.back().vertices = vertices;
    rows_.back().seconds += watch_.lap();
  }
  /// It turned out to be better to go on from another mesh of the last stage. The time goes to the
  /// stage that found that out.
  template <class MakeMesh>
  void replace(Index vertices, const MakeMesh& make_mesh) {
    rows_.back().vertices = vertices;
    keep(make_mesh);
  }
  /// A mesh that takes no time, and is no row of the table.
  template <class MakeMesh>
  void add_layer(const char* name, const MakeMesh& make_mesh) {
    if (!keep_meshes_) return;
    rows_.emplace_back();
    rows_.back().name = name;
    rows_.back().is_timed = false;
    keep(make_mesh);
    rows_.back().vertices = static_cast<Index>(rows_.back().mesh.position.size());
  }
  /// What went before is in the rows of another log.
  void skip() { watch_.lap(); }

 private:
  template <class MakeMesh>
  void keep(const MakeMesh& make_mesh) {
    if (keep_meshes_) watch_.stand_still_for([&] { rows_.back().mesh = make_mesh(); });
  }

  std::vector<StageRecord>& rows_;
  bool keep_meshes_;
  Stopwatch watch_;
};

}  // namespace shrinkwrap
