#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "analysis/precision.h"
#include "ensemble/ensemble_runner.h"
#include "experiment/experiment.h"
#include "model/pile.h"
#include "pipeline/pipeline.h"
#include "report/report_data.h"
#include "sampling/sampler_spec.h"
#include "support/progress.h"

namespace granuscope {

/// One ensemble: what it is, what for, and where it is kept.
struct PlannedEnsemble {
  std::string label;  ///< "mu = 0.3", in messages and timings
  EnsembleSpec spec;
  std::filesystem::path file;    ///< relative to the run's folder
  bool reusable = false;         ///< the file is there and holds exactly this ensemble
  std::string replaces = {};     ///< why a file that is there cannot be used: it will be replaced
  std::uint64_t grows_from = 0;  ///< 0: fixed; else the samples from which it grows until `towards` is reached
  PrecisionSpec towards = {};
  std::string notes = {};                              ///< lines of the stored configuration beside those of the spec
  std::shared_ptr<const EnsembleRecord> smaller = {};  ///< the beginning of this ensemble, to go on from
  std::uint64_t begun = 0;          ///< groups that a run that was stopped has left behind (part_file)
  std::uint64_t groups_before = 0;  ///< groups in `smaller`
  int blocks_there = 0;             ///< files of single blocks that shards have left (block_files.h)
};

/// Samples of it that need not be drawn again: those of a smaller one, or of a run that was stopped.
std::uint64_t samples_there(const PlannedEnsemble& planned);

/// Where an ensemble is kept while it is being drawn, so that a kill loses little of it: relative to the run's folder.
std::filesystem::path part_file(const PlannedEnsemble& planned);

/// The count in the line "key=count" of a configuration text; 0 if there is none.
std::uint64_t count_in(const std::string& configuration, const std::string& key);

/// The first settings in which two configurations differ: "seed = 2 where 1 is there, samples = ...".
std::string describe_difference(const std::string& there, const std::string& wanted);

/// Samples in one group of each block.
std::uint64_t round_of(const EnsembleSpec& spec);

/// Finds out whether the run's folder holds exactly this ensemble already, or something that it will replace; no folder
/// (an empty path) holds nothing. Throws EnvironmentError if a file that may be it cannot be opened.
void look_for(PlannedEnsemble& planned, const std::filesystem::path& run_folder);

/// The size, one of the steps from that of `planned` on, at which samples_needed are there, or the last one allowed.
std::uint64_t expected_samples(const PlannedEnsemble& planned, double samples_needed);

/// What look_at_precision looks at: c and D, if they are asked for, or the effective samples of a study's ensemble.
Transport measure_for_precision(const PlannedEnsemble& planned, const MeasuredEnsemble& ensemble, const FitSpec& fit,
                                int threads);

/// One ensemble for each friction coefficient of the experiment. Without friction every pile is the same, so that one
/// group of samples for each block is enough. Only the layers that the fits and figures need are recorded. Where a
/// precision is asked for, an ensemble begins with response.samples, or with what the folder holds of it already.
std::vector<PlannedEnsemble> plan_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder);

/// One of the ensembles of a study.
PlannedEnsemble plan_ensemble(const StudyEnsemble& asked, const std::filesystem::path& run_folder);

/// When an ensemble that is being drawn is kept beside its place; nothing here changes a number.
struct PartPolicy {
  double seconds = 20;  ///< at least from one part to the next
  double look = 1;      ///< seconds of drawing between two looks at the clock: long against starting threads
};

/// Draws groups `done` .. and all further ones of what `record` holds; `keep` is handed what is there now and then.
void draw_in_pieces(const EnsembleSpec& spec, const SamplerSpec& measured, std::uint64_t done, EnsembleRecord& record,
                    int threads, Progress* progress, const PartPolicy& parts,
                    const std::function<void(std::uint64_t groups)>& keep);

/// The sampler of the ensemble; what has to be measured first may take minutes, and is told.
SamplerSpec measure_sampler(const PlannedEnsemble& planned, ProgressStyle progress);

/// Reads the ensemble if it can be reused, and draws nothing. One that turns out to be damaged is none, and
/// planned.reusable becomes false.
std::optional<MeasuredEnsemble> reuse_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder);

/// Reads the ensemble if it can be reused, otherwise draws it and keeps it: a finished ensemble survives whatever
/// happens later, and the next run goes on from there. What is drawn of an unfinished one is kept
/// now and then (part_file) and continued by the next run, with the same bytes. One that turns out to be damaged is
/// drawn again, and planned.reusable becomes false.
MeasuredEnsemble obtain_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder, int threads,
                                 ProgressStyle progress, const PartPolicy& parts = {});

/// Makes of a growing ensemble the next larger one, which goes on from `record`. False, and unchanged, if that would
/// exceed towards.most_samples.
bool grow(PlannedEnsemble& planned, EnsembleRecord record, const std::filesystem::path& run_folder);

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

  /// Lets a growing ensemble grow until it is as precise as asked, which is looked at after whole steps only.
  PrecisionOutcome reach_precision(PlannedEnsemble& planned, MeasuredEnsemble& ensemble);

  /// Whether ensembles were obtained, and no pile of any could be completed.
  bool has_no_pile() const { return obtained_ > 0 && completed_ == 0; }

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
  std::uint64_t completed_ = 0;                          ///< piles
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
