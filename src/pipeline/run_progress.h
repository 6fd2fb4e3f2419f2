#pragma once
#include <chrono>

#include "experiment/experiment.h"
#include "pipeline/ensemble_stage.h"
#include "support/progress.h"

namespace granuscope {

/// How far a run is as a whole, and how long it will still take: its steps by rules of thumb for what they cost, at the
/// pace of those that are done. Tells it between two steps, every ten seconds at most.
class RunProgress {
 public:
  explicit RunProgress(ProgressStyle style) : style_(style), started_(Clock::now()), told_(started_) {}

  /// A step of the run that is still to come, in seconds on a usual core.
  void expect(double cost) { total_ += cost; }
  /// A step that was expected is done.
  void finish(double cost);

  /// "whole run: 43 %, about 54 s left"; empty where nothing can be said.
  static std::string line(double done, double total, double seconds);

 private:
  using Clock = std::chrono::steady_clock;
  ProgressStyle style_;
  Clock::time_point started_, told_;
  double total_ = 0, done_ = 0;
};

/// Rules of thumb, by what runs on one core of a cloud machine took, in seconds.
inline constexpr double seconds_for_pictures = 0.4, seconds_for_figures = 1, seconds_for_report = 3;

/// Drawing what is missing of an ensemble, on so many threads.
double seconds_to_draw(const PlannedEnsemble& planned, int threads);
/// Fits of its profiles, in all and without each block, on one thread.
double seconds_for_fits(const EnsembleSpec& spec);

}  // namespace granuscope
