#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/results.h"
#include "ensemble/ensemble_spec.h"
#include "experiment/experiment.h"
#include "pipeline/stage.h"
#include "plot/figure_captions.h"
#include "report/report.h"
#include "support/progress.h"

namespace granuscope {
class Crew;

/// How an experiment is run; nothing here changes a number.
struct RunOptions {
  std::filesystem::path folder;  ///< where everything is left; made if it is missing
  int threads = 0;               ///< 0: as many as the machine has
  std::vector<Stage> only;       ///< empty: all stages
  bool force = false;            ///< replace files of the same names that no run has written
  bool require_pdf = false;      ///< a missing PDF is an error rather than a skipped file
  bool keep_going = false;       ///< what the machine lacks is missed when it is needed, and costs its own results only
  bool of_trial = false;         ///< of a plan: the ensembles in the folder were drawn to know their errors, and are no
                                 ///< beginning
  ProgressStyle progress = ProgressStyle::automatic;
  Crew* crew = nullptr;  ///< processes that draw together with this one, if there are any
};

/// One line of a plan.
struct PlannedStep {
  Stage stage;
  std::string what;
  bool reused = false;
  std::uint64_t beads = 0;    ///< beads to be drawn
  EnsembleSpec spec = {};     ///< of an ensemble, what is to be drawn of it:
  std::uint64_t samples = 0;  ///< so many samples more
  double parallel_seconds = 0,
         serial_seconds = 0;  ///< of other work, by rules of thumb; the former is shared by threads
};

/// Whether run_experiment would find all that is asked for, made from the same, and do nothing.
bool is_all_there(const Experiment& experiment, const RunOptions& options);

/// What run_experiment would do, in order; draws nothing and writes nothing.
std::vector<PlannedStep> plan_run(const Experiment& experiment, const RunOptions& options);

/// How long a plan will take.
struct PlannedTime {
  double seconds = 0;     ///< on the clock, on threads that nobody else keeps busy
  bool at_least = false;  ///< it may also take much longer
};

/// Estimated from a trial of each ensemble on one core, and rules of thumb for what comes after it: takes seconds where
/// chains or the laws of tiny piles are asked for, else much less. Stops with Interrupted if that is asked for.
PlannedTime estimate_time(const std::vector<PlannedStep>& plan, int threads);

/// Memory that the largest of the ensembles needs that are not in the run's folder yet, while it is drawn on this many
/// threads, and the sums, in bytes.
double memory_needed(const Experiment& experiment, const std::filesystem::path& run_folder, int threads);

/// What a run leaves behind.
struct RunResult {
  Analysis analysis;                    ///< empty unless the stage analyse was needed and not all was there
  ReportFiles files;                    ///< empty unless the stage report was needed
  std::vector<std::string> unexpected;  ///< claims whose verdict is not the expected one, as sentences
  std::string failure = {};             ///< what the machine did not let be made, while all else was; empty if nothing
};

/// Does nothing where the folder holds the whole results of the same experiment by the same program and libraries. Else
/// runs the stages in order, reusing finished ensembles, and leaves in the folder what docs/guide.md lists.
/// manifest.json is written in any case, also when a stage fails or the run is interrupted; the error then goes on to
/// the caller. A figure that cannot be made ends nothing: the report says so in its place, and RunResult::failure.
RunResult run_experiment(const Experiment& experiment, const RunOptions& options);

/// The plots of the main line that the experiment asks for and that have something to show, in reading order; why
/// others have not, in `left_out`. The analysis must outlive them.
std::vector<FigurePlot> main_figures(const Experiment& experiment, const Analysis& analysis,
                                     std::vector<std::string>* left_out = nullptr);

}  // namespace granuscope
