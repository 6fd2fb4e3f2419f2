#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis/results.h"
#include "ensemble/ensemble_spec.h"
#include "experiment/experiment.h"
#include "model/pile.h"
#include "plot/figure_captions.h"
#include "render/scene.h"
#include "report/report.h"
#include "report/report_data.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
/// The stages of a run and what each needs: analyse needs sample, plot needs analyse, report needs analyse, plot and
/// render.
enum class Stage {
  sample,   ///< ensembles/*.h5
  analyse,  ///< fits, slopes, exponents, claims (kept in memory)
  render,   ///< piles/*.h5 and figures/force-chains.png
  plot,     ///< figures/*.svg, *.pdf with scripts and data
  report,   ///< summary.json, claims.xml, summary.md, report.html, report.pdf
};

std::string name_of(Stage stage);
std::set<std::string> names_of(const std::set<Stage>& stages);
/// Throws InputError naming the stages.
Stage stage_named(const std::string& name);

/// The stages asked for with all that they need; everything if none is asked for.
std::set<Stage> stages_needed(const std::vector<Stage>& asked_for);

/// Does a piece of work and adds its wall time to the line of a stage; a new line if there is none. Throws Interrupted
/// instead if that was asked for.
template <typename Work>
void timed(std::vector<StageTiming>& timings, const std::string& stage, Work work) {
  throw_if_interrupted();
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  for (StageTiming& timing : timings) {
    if (timing.stage == stage) {
      timing.seconds += elapsed.count();
      return;
    }
  }
  timings.push_back({stage, elapsed.count(), false});
}

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
  std::uint64_t beads = 0;     ///< beads to be drawn
  EnsembleSpec spec = {};      ///< of an ensemble, what is to be drawn of it:
  std::uint64_t samples = 0;   ///< so many samples more
  std::string unreached = {};  ///< why no number of them reaches the precision asked for
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

/// "roughly 2 min on 4 threads, by a trial of the first piles".
std::string in_words(const PlannedTime& time, int threads);

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
  std::string failure = {};             ///< what could not be made, while all else was; empty if nothing
  ExitCode code = ExitCode::done;       ///< environment: the machine lacks what it takes; bad_input: no pile came of it
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

/// A rendered picture as a figure of the report, and what is to be said about how it was made.
struct PictureOutcome {
  Figure figure;
  std::vector<std::pair<std::string, std::string>> environment;    ///< GL backend, why it was chosen, renderer
  std::vector<std::string> checks;                                 ///< how the pile's audit came out
  std::vector<std::string> skipped;                                ///< what was left out of the picture, counted
  std::vector<std::pair<std::string, std::string>> not_kept = {};  ///< files beside it that could not be written, why
};

/// The pile of the pictures as an ensemble of its own, at any friction coefficient, so that its load and the command
/// that draws it again are written once.
EnsembleSpec pile_spec(const Experiment& experiment, double mu);
/// Whether a picture compares that pile with the one under a uniform load.
bool needs_pair(const Experiment& experiment);

/// The pile of the force-chain picture (size, load, seed and sample), at any friction coefficient.
/// Throws InputError if it could not be completed.
Pile pile_for_figures(const Experiment& experiment, double mu);

/// Throws EnvironmentError if OpenGL is asked for by name for the pictures and cannot be started.
void require_backend(const ForceChainSpec& chains);

/// Draws the pile that the experiment names (piles/force-chains.h5) and its pictures: force chains, and as asked for
/// the weights of its beads and how they change with the overload. A picture that could not be rendered says why
/// (Figure::failure). Throws InputError if the pile could not be completed.
std::vector<PictureOutcome> render_pile_pictures(const Experiment& experiment, const std::filesystem::path& run_folder,
                                                 const Provenance& provenance);

/// The picture of a response_field (figures/response-field.png).
PictureOutcome render_response_field(const Experiment& experiment, Field field, const Transport& transport,
                                     const std::filesystem::path& run_folder, const Provenance& provenance);

}  // namespace granuscope
