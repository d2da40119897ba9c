#include "common/progress.h"

#include <algorithm>

#include "common/types.h"

namespace shrinkwrap {
namespace {

// Share of the time of a run, measured on a million samples; only the evenness of the bar depends
// on it.
constexpr double kWeight[kStageCount] = {0.15, 0.01, 0.07, 0.22, 0.12, 0.10, 0.20, 0.07, 0.06};

constexpr auto kCallInterval = std::chrono::milliseconds(20);

}  // namespace

const char* stage_name(Stage stage) {
  switch (stage) {
    case Stage::samples:
      return "samples";
    case Stage::outliers:
      return "outliers";
    case Stage::orientation:
      return "orientation";
    case Stage::initial_mesh:
      return "initial mesh";
    case Stage::control_mesh:
      return "control mesh";
    case Stage::parametric_surface:
      return "parametric surface";
    case Stage::complete_matching:
      return "complete matching";
    case Stage::edge_optimisation:
      return "edge optimisation";
    case Stage::report:
      return "matching report";
  }
  return "";
}

Progress::Progress(Callback callback, std::initializer_list<Stage> stages)
    : Progress(std::move(callback), std::vector<Stage>(stages)) {}

Progress::Progress(Callback callback, const std::vector<Stage>& stages)
    : callback_(std::move(callback)) {
  double total = 0.0;
  for (Stage stage : stages) total += kWeight[static_cast<int>(stage)];
  double begin = 0.0;
  for (Stage stage : stages) {
    const int i = static_cast<int>(stage);
    stage_begin_[i] = begin;
    stage_weight_[i] = kWeight[i] / total;
    begin += stage_weight_[i];
  }
}

void Progress::begin(Stage stage) {
  if (stage != stage_) set_part(0.0, 1.0);
  stage_ = stage;
  set_range(0.0, 1.0);
  if (callback_ && std::this_thread::get_id() == owner_) call(0.0);
}

void Progress::set_range(double from, double to) {
  range_from_ = from;
  range_to_ = to;
}

void Progress::set_part(double from, double to) {
  part_from_ = from;
  part_to_ = to;
  set_range(0.0, 1.0);
}

void Progress::update(double fraction_of_stage) {
  if (cancelled()) throw Cancelled();
  if (!callback_ || std::this_thread::get_id() != owner_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_call_ < kCallInterval) return;
  last_call_ = now;
  call(range_from_ + (range_to_ - range_from_) * std::clamp(fraction_of_stage, 0.0, 1.0));
}

void Progress::call(double fraction_of_part) {
  const int i = static_cast<int>(stage_);
  const double within = part_from_ + (part_to_ - part_from_) * fraction_of_part;
  const double fraction = std::min(stage_begin_[i] + stage_weight_[i] * within, 1.0);
  const double of_run = share_from_ + (share_to_ - share_from_) * fraction;
  last_fraction_ = std::max(last_fraction_, of_run);
  if (!callback_(last_fraction_, stage_name(stage_))) {
    cancelled_.store(true, std::memory_order_relaxed);
    throw Cancelled();
  }
}

}  // namespace shrinkwrap
