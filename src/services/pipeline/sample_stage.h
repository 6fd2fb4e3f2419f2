#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "analysis/precision.h"
#include "analysis/transport.h"
#include "experiment/experiment.h"
#include "model/pile.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/pipeline.h"
#include "report/report_data.h"
#include "sampling/sampler_spec.h"
#include "support/progress.h"

namespace granuscope {
/// Obtains the ensembles of one run, one after the other, and keeps account of it in the data of the report.
class SampleStage {
 public:
  /// `earlier`: what each stage took in an earlier run. `drawn` is called whenever an ensemble has been drawn. All must
  /// outlive this object.
  SampleStage(const Experiment& experiment, const RunOptions& options, ReportData& data,
              const std::map<std::string, StageTiming>& earlier, std::function<void()> drawn)
      : experiment_(experiment), options_(options), data_(data), earlier_(earlier), drawn_(std::move(drawn)) {}

  MeasuredEnsemble obtain(PlannedEnsemble& planned);

  /// Lets the crew, if there is one, draw what is not there of these ensembles.
  void draw_by_crew(const std::vector<PlannedEnsemble>& ensembles);

  /// Lets a growing ensemble grow until its c and D are as precise as asked, which is looked at after whole steps only.
  PrecisionOutcome reach_precision(PlannedEnsemble& planned, MeasuredEnsemble& ensemble);

  /// Tells how many ensembles were there already.
  void tell_reuse();

  /// A bead that only rounding puts outside its band is put onto its end; how often is part of the numerics. `counts`:
  /// of the main ensembles.
  void tell_rounding(const SamplerCounts& counts);

 private:
  std::string time_for(const EnsembleSpec& spec, std::uint64_t samples) const;

  const Experiment& experiment_;
  const RunOptions& options_;
  ReportData& data_;
  const std::map<std::string, StageTiming>& earlier_;
  std::function<void()> drawn_;
  std::set<std::filesystem::path> drawn_by_crew_;        ///< in this run: they are there, and yet not reused
  std::size_t obtained_ = 0, reused_ = 0;                ///< ensembles
  double drawn_in_this_run_ = 0, drawn_in_seconds_ = 0;  ///< beads, for the time that is left
};

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
inline constexpr double seconds_for_pictures = 0.4, seconds_for_figures = 1, seconds_for_report = 5;

/// Drawing what is missing of an ensemble, on so many threads.
double seconds_to_draw(const PlannedEnsemble& planned, int threads);
/// Fits of its profiles, in all and without each block, on one thread.
double seconds_for_fits(const EnsembleSpec& spec);

/// The choices that shape a law, one sentence each, as the report states them (templates/law/<name>.txt, one a line).
std::vector<std::string> law_description(const std::string& law);

/// Processes that draw together with this one, in a folder that all of them see.
class Crew {
 public:
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  virtual ~Crew() = default;

  /// Draws what is not there of these ensembles of the experiment, and returns when all are whole in the folder, or at
  /// least each of their blocks is in its file (block_files.h). Those that are reusable are left alone. What goes wrong
  /// with one of them is thrown here.
  virtual void draw(const Experiment& experiment, const RunOptions& options,
                    const std::vector<PlannedEnsemble>& ensembles) = 0;
};

}  // namespace granuscope
