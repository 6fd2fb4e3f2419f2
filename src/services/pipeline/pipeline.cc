#include "pipeline/pipeline.h"

#include <fmt/format.h>

#include <sys/auxv.h>

#include <algorithm>
#include <exception>
#include <map>
#include <memory>
#include <optional>

#include "analysis/claims.h"
#include "experiment/experiment_file.h"
#include "pipeline/run_folder.h"
#include "pipeline/sample_stage.h"
#include "pipeline/shards.h"
#include "plot/bead_forces.h"
#include "plot/depth_figures.h"
#include "plot/gnuplot.h"
#include "plot/main_finding.h"
#include "plot/power_law_panel.h"
#include "plot/response_field.h"
#include "plot/scaling_figures.h"
#include "report/run_files.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"
#include "support/templates.h"

namespace granuscope {
namespace {

/// Size and time of change of a program that a run starts: another one may make other files.
std::string state_of(const std::string& program) {
  const auto path = find_program(program);
  if (!path) return program + " is missing";
  std::error_code none;
  const auto changed = std::filesystem::last_write_time(*path, none).time_since_epoch().count();
  return fmt::format("{} {} {}", path->string(), std::filesystem::file_size(*path, none), changed);
}

std::set<std::string> files_of(const Figure& figure) {
  std::set<std::string> files;
  for (const auto& file : figure.data) files.insert(file.generic_string());
  for (const auto& file : {figure.screen, figure.narrow, figure.print, figure.script, figure.recipe}) {
    if (!file.empty()) files.insert(file.generic_string());
  }
  return files;
}

/// Where /proc is not mounted (sandboxes, chroot), by the name under which the system has started it.
std::filesystem::path own_program() {
  std::filesystem::path usual = "/proc/self/exe";
  if (path_exists(usual)) return usual;
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the system hands the address over as a number
  return reinterpret_cast<const char*>(::getauxval(AT_EXECFN));
}

/// One word for all that results depend on: the experiment, this program, its libraries, and the programs it runs.
std::string key_of_all(const std::string& resolved_experiment, const Provenance& provenance) {
  std::string text =
      resolved_experiment + templates_digest() + sha256_of_file(own_program()) + provenance.processor_features;
  for (const auto& [name, version] : provenance.libraries) text += fmt::format("\n{} {}", name, version);
  for (const char* program : {"gnuplot", "weasyprint"}) text += "\n" + state_of(program);
  return cache_key(text);
}

/// The run that left all that is asked for, made from the same.
std::optional<FinishedRun> find_whole_run(const std::string& made_from, const RunOptions& options) {
  const std::set<Stage> needed = stages_needed(options.only);
  std::optional<FinishedRun> there = find_finished_run(options.folder, made_from, names_of(needed));
  if (there && needed.contains(Stage::report) && options.require_pdf && !there->pdf) return {};
  return there;
}

/// One run from its first stage to its last.
class Run {
 public:
  Run(const Experiment& experiment, const RunOptions& options)
      : experiment_(experiment), options_(options), needed_(stages_needed(options.only)) {}

  RunResult go() {
    describe();
    const RunFolder folder(options_.folder);
    if (folder.leftovers_removed() > 0) {
      log_line(options_.progress, "removed what a run that was killed had half written ({})",
               how_many(folder.leftovers_removed(), "file or folder", "files and folders"));
    }
    if (reuse_all()) return std::move(result_);
    earlier_timings_ = earlier_timings(options_.folder);
    figure_files_ = earlier_figure_files(options_.folder);
    if (!options_.force) {
      require_own_results(options_.folder, data_.resolved_experiment);
      for (const auto& file : keep_changed(options_.folder))
        log_line(options_.progress, "{0} is not what the last run left there: kept as {0}.kept", file.string());
    }
    const std::optional<std::string> before = experiment_key_of_run(options_.folder);
    if (before && *before != data_.resolved_experiment_key) set_aside_results(options_.folder, figure_files_);
    mark_unfinished();
    try {
      write_file(options_.folder / "experiment.toml", data_.resolved_experiment);
      if (!options_.keep_going) check_tools();
      if (needs(Stage::sample)) sample_and_measure();
      if (needs(Stage::render)) render();
      if (needs(Stage::plot)) plot();
      if (needs(Stage::report)) report();
    } catch (const std::exception& error) {
      const auto* const known = dynamic_cast<const Error*>(&error);
      const ExitCode code = known == nullptr ? ExitCode::environment : known->exit_code();
      try {
        keep_manifest(code == ExitCode::interrupted ? "interrupted" : "failed", code, error.what());
      } catch (const std::exception&) {
        log_line(options_.progress, "manifest.json could not be written either");
      }
      throw;
    }
    // A run that has come to its ensembles knows all of their times, any other leaves them as they were.
    if (needs(Stage::sample)) earlier_timings_.clear();
    result_.failure = failures_in_words();
    if (!result_.failure.empty()) {
      result_.code = ExitCode::environment;
    } else if (sampling_.has_no_pile()) {
      result_.code = ExitCode::bad_input;
      result_.failure =
          "no pile of any ensemble could be completed, so that nothing is known; take fewer columns, more "
          "sampling.effort or another sampling.law";
    }
    const bool whole = result_.code == ExitCode::done;
    result_.analysis = data_.analysis;
    result_.unexpected = unexpected_results(data_.analysis);
    const FinishedRun finished{made_from_, names_of(needed_), result_.unexpected, result_.files.pdf.has_value()};
    if (needs(Stage::report)) remove_earlier_figures();
    keep_manifest(whole ? "done" : "failed", result_.code, result_.failure, finished);
    return std::move(result_);
  }

 private:
  bool needs(Stage stage) const { return needed_.contains(stage); }

  /// Whether the folder holds all that is asked for, made from the same by the same, so that nothing is to be done.
  bool reuse_all() {
    made_from_ = key_of_all(data_.resolved_experiment, data_.provenance);
    const std::optional<FinishedRun> there = find_whole_run(made_from_, options_);
    if (!there) return false;
    if (needs(Stage::report)) {
      result_.files = files_in(options_.folder);
      if (!there->pdf) result_.files.pdf.reset();
    }
    result_.unexpected = there->unexpected;
    log_line(options_.progress, "everything is there already, and nothing it is made from has changed");
    return true;
  }

  /// What only the later stages need is missed now, not after an hour of sampling.
  void check_tools() const {
    if (needs(Stage::render)) require_backend(experiment_.force_chains);
    if (needs(Stage::plot)) require_gnuplot();
    if (needs(Stage::report) && options_.require_pdf && !find_program("weasyprint")) {
      throw EnvironmentError(
          missing_program("weasyprint", "report.pdf, which is required, cannot be written",
                          "install it with `apt-get install weasyprint`, or leave out --require-pdf"));
    }
  }

  void describe() {
    data_.started = current_time();
    data_.experiment_name = experiment_.name;
    data_.description = experiment_.description;
    data_.columns = experiment_.lattice.columns;
    data_.layers = experiment_.lattice.layers;
    data_.seed = experiment_.sampling.seed;
    data_.overload = experiment_.response.overload;
    data_.resolved_experiment = print_experiment(experiment_);
    data_.changed_experiment = print_changes(experiment_);
    data_.headline = experiment_.report.headline;
    data_.resolved_experiment_key = cache_key(data_.resolved_experiment);
    data_.law_description =
        law_description(experiment_.sampling.model.is_beads() ? name_of(experiment_.sampling.law)
                                                              : name_of(experiment_.sampling.model.name));
    std::set<Law> drawn;
    for (const StudyEnsemble& one : studies_.ensembles(experiment_)) drawn.insert(one.spec.sampler.law);
    for (const Law law : all_laws) {
      if ((experiment_.sampling.model.is_beads() && law == experiment_.sampling.law) || !drawn.contains(law)) continue;
      data_.other_law_descriptions.emplace_back(name_of(law), law_description(name_of(law)));
    }
    data_.provenance = collect_provenance();
    if (!needs(Stage::render) || !experiment_.force_chains.show) {
      data_.skipped.emplace_back("No picture was asked for, so no GL context was made.");
    }
  }

  /// Until the run has ended, the folder may hold the results of an earlier one beside the new experiment: nobody is to
  /// take them for its own. Written again with each ensemble, so that a kill does not make forgotten what it took.
  void mark_unfinished() {
    keep_manifest("unfinished", std::nullopt,
                  "the run is at work or was killed, so that what is here may be of an earlier one; the same command "
                  "goes on from there");
  }

  /// What an earlier run of another experiment plotted, and this one does not, is no figure of this folder any more.
  void remove_earlier_figures() {
    std::set<std::string> own;
    if (needs(Stage::render) && experiment_.force_chains.show) own.insert(pile_files.begin(), pile_files.end());
    for (const Figure& figure : data_.figures) own.merge(files_of(figure));
    for (const std::string& file : figure_files_) {
      remove_if_there(set_aside(options_.folder, file));
      if (!own.contains(file)) remove_if_there(options_.folder / file);
    }
    figure_files_ = std::move(own);
  }

  void measure_studies() {
    for (const auto& study : studies_) {
      if (!study->asked()) continue;
      study->begin(experiment_, options_.threads);
      for (const StudyEnsemble& one : study->ensembles(experiment_)) {
        PlannedEnsemble planned = plan_ensemble(one, options_.folder);
        const double cost = seconds_to_draw(planned, threads_);
        MeasuredEnsemble ensemble = sampling_.obtain(planned);
        const PrecisionOutcome enough = sampling_.reach_precision(planned, ensemble);
        if (!enough.reason.empty()) log_line(options_.progress, "{}: {}", planned.label, enough.reason);
        progress_.finish(cost);
        if (!needs(Stage::analyse)) continue;
        timed(data_.timings, "analyse", [&] { study->add(one, ensemble); });
      }
      if (!needs(Stage::analyse)) continue;
      timed(data_.timings, study->seconds() > 0 ? study->id() : "analyse", [&] { study->finish(); });
      progress_.finish(study->seconds());
    }
  }

  void judge_studies() {
    for (const auto& study : studies_) {
      for (OtherReading& reading : study->readings()) data_.analysis.readings.push_back(std::move(reading));
      for (Claim& claim : study->claims(experiment_.claims)) data_.analysis.claims.push_back(std::move(claim));
      data_.studies[study->id()] = study->json();
      for (ReportPart& part : study->parts()) {
        if (part.place == ReportPart::Place::page_1 && !takes_page_1(study->id())) continue;
        data_.parts.push_back(std::move(part));
      }
    }
    const bool told = std::ranges::any_of(
        data_.parts, [](const ReportPart& part) { return part.place == ReportPart::Place::page_1; });
    if (!told && !experiment_.report.about.empty()) {
      leave_out(
          fmt::format("Page 1 is not about {}, as report.about says: nothing was measured that it could tell there.",
                      experiment_.report.about));
    }
    tell_smaller_friction(data_.analysis);
    expect_verdicts(data_.analysis.claims, experiment_.expected_verdicts);
  }

  /// Whether page 1 is about this study: the one that the experiment names, or, where the main line found nothing, the
  /// first that has something to say.
  bool takes_page_1(const std::string& study) {
    if (about_.empty()) {
      const bool main_line = has_main_finding(without_imprecise_points(data_.analysis));
      if (!experiment_.report.about.empty()) {
        about_ = experiment_.report.about;
      } else if (!main_line) {
        about_ = study;
      }
    }
    return about_ == study;
  }

  /// Drawing an ensemble and fitting it.
  double cost_of(const PlannedEnsemble& planned) const {
    return seconds_to_draw(planned, threads_) + seconds_for_fits(planned.spec) / threads_;
  }

  void expect_steps(const std::vector<PlannedEnsemble>& ensembles) {
    for (const PlannedEnsemble& planned : ensembles) progress_.expect(cost_of(planned));
    for (const auto& study : studies_) {
      if (!study->asked()) continue;
      for (const StudyEnsemble& one : study->ensembles(experiment_)) {
        progress_.expect(seconds_to_draw(plan_ensemble(one, options_.folder), threads_));
      }
      if (needs(Stage::analyse)) progress_.expect(study->seconds());
    }
    if (needs(Stage::render)) progress_.expect(seconds_for_pictures);
    if (needs(Stage::plot)) progress_.expect(seconds_for_figures);
    if (needs(Stage::report)) progress_.expect(seconds_for_report);
  }

  /// Piles of slow laws show no progress for long: how long all takes comes before the first of them.
  void tell_time() {
    const SamplerSpec& sampler = experiment_.sampling;
    const bool slow = sampler.law == Law::polytope || sampler.model.name == ModelName::diluted_beads;
    if (!slow || options_.progress == ProgressStyle::silent || options_.crew != nullptr) return;
    const PlannedTime time = estimate_time(plan_run(experiment_, options_), threads_);
    log_line(options_.progress, "all together {}", in_words(time, threads_));
  }

  void sample_and_measure() {
    tell_time();
    std::vector<MeasuredTransport> measured;
    for (const std::string& note : {note_of_idle_keys(experiment_), note_of_short_window(experiment_)}) {
      if (!note.empty()) leave_out(note);
    }
    if (options_.crew != nullptr) sampling_.draw_by_crew(all_ensembles(experiment_, options_.folder));
    SamplerCounts counts;
    std::vector<PlannedEnsemble> ensembles = plan_ensembles(experiment_, options_.folder);
    expect_steps(ensembles);
    for (PlannedEnsemble& planned : ensembles) {
      const double cost = cost_of(planned);
      MeasuredEnsemble ensemble = sampling_.obtain(planned);
      const PrecisionOutcome precision = sampling_.reach_precision(planned, ensemble);
      counts += ensemble.record.counts;
      if (planned.spec.response.samples < experiment_.response.samples) {
        data_.skipped.push_back(
            fmt::format("At {} every pile is the same: {} of {} samples were drawn, one group for each block.",
                        experiment_.scanned().at(planned.spec.sampler), planned.spec.response.samples,
                        experiment_.response.samples));
      }
      if (!needs(Stage::analyse)) {
        progress_.finish(cost);
        continue;
      }
      timed(data_.timings, "analyse", [&] {
        measured.push_back(
            measure_transport(ensemble, experiment_.fit, recorded_layers(ensemble.spec), options_.threads));
        measured.back().transport.precision = precision;
        measured.back().transport.scan = &experiment_.scanned();
        for (const auto& study : studies_) {
          if (study->asked()) study->add_main(experiment_, ensemble);
        }
        if (experiment_.response_field.show && needs(Stage::render) &&
            measured.back().transport.scanned() == experiment_.shown_value(experiment_.figures.profile_mu)) {
          field_transport_ = measured.back().transport;
          field_ = response_field(ensemble, *field_transport_);
        }
      });
      progress_.finish(cost);
    }
    sampling_.tell_rounding(counts);
    measure_studies();
    sampling_.tell_reuse();
    forget_shards(options_.folder);
    if (!needs(Stage::analyse)) return;
    timed(data_.timings, "analyse", [&] {
      data_.analysis = analyse(std::move(measured), experiment_.fit, experiment_.claims);
      judge_studies();
    });
    log_line(options_.progress, "fitted c, D and the exponents");
  }

  void render() {
    if (!experiment_.force_chains.show) return;
    timed(data_.timings, "render", [&] {
      try_figure([&] {
        for (PictureOutcome& picture : render_pile_pictures(experiment_, options_.folder, data_.provenance)) {
          add_picture(std::move(picture));
        }
      });
      if (field_transport_ && !field_.rows.empty()) {
        try_figure([&] {
          add_picture(render_response_field(experiment_, field_, *field_transport_, options_.folder, data_.provenance));
        });
      }
      // The force chains, a page wide, behind the narrow ones, which fill the page before.
      if (data_.figures.size() > 1) std::rotate(data_.figures.begin(), data_.figures.begin() + 1, data_.figures.end());
    });
    log_line(options_.progress, "rendered the pictures");
    progress_.finish(seconds_for_pictures);
  }

  void add_picture(PictureOutcome picture) {
    if (data_.figures.empty()) {  // what rendered them is one for all
      data_.environment.insert(data_.environment.end(), picture.environment.begin(), picture.environment.end());
    }
    keep_figure(std::move(picture.figure));
    for (const auto& [what, why] : picture.not_kept) note_failure(what, why);
    data_.checks.insert(data_.checks.end(), picture.checks.begin(), picture.checks.end());
    data_.skipped.insert(data_.skipped.end(), picture.skipped.begin(), picture.skipped.end());
  }

  void leave_out(const std::string& sentence) {
    data_.skipped.push_back(sentence);
    log_line(options_.progress, sentence);
  }

  /// A figure with nothing to show (InputError) is left out with its reason: the numbers that are known, and the
  /// reasons why others are not, are still to be reported.
  template <typename Make>
  void try_figure(Make make) {
    try {
      make();
    } catch (const InputError& nothing_to_show) {
      leave_out(fmt::format("A figure is left out: {}.", nothing_to_show.what()));
    }
  }

  template <typename Make>
  void add_figure(Make make) {
    try_figure([&] { keep_figure(make()); });
  }

  void keep_figure(Figure figure) {
    if (!figure.failure.empty()) note_failure("figure " + figure.id, figure.failure);
    figure_files_.merge(files_of(figure));
    data_.figures.push_back(std::move(figure));
  }

  void note_failure(const std::string& what, const std::string& why) {
    log_line(options_.progress, "{} could not be made: {}", what, why);
    failures_.emplace_back(what, why);
  }

  /// One sentence for all: where gnuplot fails once it mostly fails for the same reason again.
  std::string failures_in_words() const {
    if (failures_.empty()) return {};
    std::vector<std::string> names;
    for (const auto& [what, why] : failures_) names.push_back(what);
    return fmt::format("{} could not be made, while all else was made: {}", enumeration(names),
                       failures_.front().second);
  }

  void plot() {
    timed(data_.timings, "plot", [&] {
      const FigureSpec& figures = experiment_.figures;
      if (figures.bead_forces && experiment_.sampling.model.has_contacts()) {
        const BeadForcesSpec spec{std::min(BeadForcesSpec{}.layer, experiment_.force_chains.layers - 1)};
        add_figure([&] {
          return plot_bead_forces(
              pile_for_figures(experiment_, experiment_.sampler_at(experiment_.shown_value(figures.profile_mu)).mu),
              spec, options_.folder);
        });
        // The paper's Fig. 1 has this one on the left, the force chains on the right.
        if (data_.figures.size() > 1) std::rotate(data_.figures.begin(), data_.figures.end() - 1, data_.figures.end());
      }
      std::vector<std::string> left_out;
      const std::vector<FigurePlot> plots = main_figures(experiment_, data_.analysis, &left_out);
      for (const std::string& sentence : left_out) leave_out(sentence);
      for (const FigurePlot& plot_one : plots) add_figure([&] { return plot_one(options_.folder); });
      for (const auto& study : studies_) {
        const std::size_t before = data_.figures.size();
        for (const FigurePlot& plot_one : study->figures(data_.analysis)) {
          add_figure([&] { return plot_one(options_.folder); });
        }
        const bool wanted = about_.empty() ? first_of_study_.empty() : about_ == study->id();
        if (wanted && data_.figures.size() > before) first_of_study_ = data_.figures[before].id;
      }
    });
    choose_key_figure();
    note_version("gnuplot");
    log_line(options_.progress, "plotted the figures");
    progress_.finish(seconds_for_figures);
  }

  /// The figure of page 1 comes first: the one that the experiment names, or the first of the study that page 1 is
  /// about, or what the main line found, or else the first of a study.
  void choose_key_figure() {
    const auto find = [&](const std::string& id) {
      return std::ranges::find_if(data_.figures, [&](const Figure& one) { return one.id == id; });
    };
    const std::string& named = experiment_.report.key_figure;
    auto chosen = find(!named.empty() ? named : about_.empty() ? main_finding_id : first_of_study_);
    if (!named.empty() && chosen == data_.figures.end()) {
      leave_out(fmt::format("Page 1 has no figure: report.key_figure names {}, which this run does not make.", named));
    }
    for (const std::string& instead : {first_of_study_, std::string(transport_with_depth_id)}) {
      if (named.empty() && chosen == data_.figures.end()) chosen = find(instead);
    }
    if (chosen == data_.figures.end()) return;
    data_.key_figure = chosen->id;
    std::rotate(data_.figures.begin(), chosen, chosen + 1);
  }

  void report() {
    const PdfPolicy policy = options_.require_pdf     ? PdfPolicy::required
                             : experiment_.report.pdf ? PdfPolicy::if_possible
                                                      : PdfPolicy::none;
    if (policy != PdfPolicy::none) note_version("weasyprint");
    timed(data_.timings, "report", [&] { result_.files = write_report(data_, options_.folder, policy); });
    if (!result_.files.pdf_skipped.empty()) data_.skipped.push_back(result_.files.pdf_skipped);
    log_line(options_.progress, "wrote the report");
  }

  void note_version(const std::string& program) {
    if (const auto installed = find_installed_program(program)) {
      data_.environment.emplace_back(program, installed->failure.empty() ? installed->version : installed->failure);
    }
  }

  /// The manifest of a run that did not end well. That it cannot be written either must not hide why.
  void keep_manifest(const std::string& status, std::optional<ExitCode> code, const std::string& error,
                     const FinishedRun& finished = {}) {
    const auto number = code ? std::optional(static_cast<int>(*code)) : std::nullopt;
    write_manifest(data_, options_.folder, {status, number, error, finished, earlier_timings_, figure_files_});
  }

  const Experiment& experiment_;
  const RunOptions& options_;
  std::set<Stage> needed_;
  ReportData data_;
  Field field_;  ///< the mean response at figures.response_profiles.mu, for its picture
  std::optional<Transport> field_transport_;
  std::string about_;                                          ///< id of the study that page 1 is about; empty: none
  std::string first_of_study_;                                 ///< id of the first figure of that one, or of any
  Studies studies_ = experiment_.studies;                      ///< with what they measure
  std::vector<std::pair<std::string, std::string>> failures_;  ///< what could not be made, and why
  RunResult result_;
  RunProgress progress_{options_.progress};
  int threads_ = worker_count(options_.threads);
  std::string made_from_;                               ///< one word for all that the results depend on
  std::map<std::string, StageTiming> earlier_timings_;  ///< by stage
  std::set<std::string> figure_files_;                  ///< of figures in the folder, of earlier runs, too
  SampleStage sampling_{experiment_, options_, data_, earlier_timings_, [this] { mark_unfinished(); }};
};

}  // namespace

bool is_all_there(const Experiment& experiment, const RunOptions& options) {
  return find_whole_run(key_of_all(print_experiment(experiment), collect_provenance()), options).has_value();
}

RunResult run_experiment(const Experiment& experiment, const RunOptions& options) {
  return Run(experiment, options).go();
}

std::vector<FigurePlot> main_figures(const Experiment& experiment, const Analysis& analysis,
                                     std::vector<std::string>* left_out) {
  using Folder = const std::filesystem::path&;
  FigureSpec asked = experiment.figures;
  const auto clear = std::make_shared<const Analysis>(without_imprecise_points(analysis));
  // One point tells nothing about how c and D depend on each other, or on what is scanned.
  const auto values = std::ranges::count_if(
      clear->results, [](const Transport& one) { return !one.exact && one.c.known() && one.D.known(); });
  const auto leave_out = [&](std::initializer_list<bool*> figures, const std::string& why) {
    const bool any = std::ranges::any_of(figures, [](const bool* one) { return *one; }) &&
                     std::ranges::any_of(clear->results, [](const Transport& one) { return !one.exact; });
    for (bool* one : figures) *one = false;
    if (any && left_out != nullptr) left_out->push_back(why);
  };
  const std::string& symbol = experiment.scanned().symbol;
  if (values < 2) {
    leave_out({&asked.propagation_against_diffusion, &asked.propagation_and_thrust, &asked.scaling_with_friction},
              fmt::format(
                  "The figures of c and D against {0} and each other are left out: both are precise enough at {1} {0}.",
                  symbol, values == 0 ? "no" : "only one"));
  } else if (!has_exponents(*clear)) {
    leave_out({&asked.scaling_with_friction},
              fmt::format("The figure of the exponents is left out: {}.", clear->scaling.gamma.exponent.reason));
  }
  std::vector<FigurePlot> figures;
  if (has_main_finding(*clear)) figures.emplace_back([clear](Folder run) { return plot_main_finding(*clear, run); });
  if (asked.response_profiles) {
    const ResponseProfilesSpec spec{experiment.shown_value(asked.profile_mu), asked.profile_layers,
                                    experiment.lattice.layers};
    figures.emplace_back([&analysis, spec](Folder run) { return plot_response_profiles(analysis.results, spec, run); });
  }
  if (asked.transport_with_depth) {
    const TransportWithDepthSpec spec{experiment.shown_value(asked.profile_mu)};
    figures.emplace_back([clear, spec](Folder run) { return plot_transport_with_depth(*clear, spec, run); });
  }
  if (asked.propagation_against_diffusion) {
    figures.emplace_back([clear](Folder run) { return plot_propagation_against_diffusion(*clear, run); });
  }
  if (asked.scaling_with_friction) {
    figures.emplace_back([clear](Folder run) { return plot_scaling_with_friction(*clear, run); });
  }
  if (asked.propagation_and_thrust) {
    figures.emplace_back([clear](Folder run) { return plot_propagation_and_thrust(*clear, run); });
  }
  return figures;
}

}  // namespace granuscope
