#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "cli/flag_checks.h"
#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "pipeline/pipeline.h"
#include "pipeline/run_folder.h"
#include "pipeline/shards.h"
#include "report/report.h"
#include "report/run_files.h"
#include "sampling/sampler_spec.h"
#include "support/progress.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {

struct RunVerbOptions {
  std::string config;
  std::string templates;
  std::string folder;
  std::vector<std::string> only;
  std::string shard;
  int threads = 0;
  bool dry_run = false;
  bool print_config = false;
  bool require_pdf = false;
  bool gate = false;
  bool print_key = false;
  bool quiet = false;
  bool keep_going = false;
  bool force = false;
  std::vector<std::string> overrides;

  bool from_standard_input() const { return config == "-" || is_open_already(config); }
};

void print_plan(const Experiment& experiment, const RunOptions& options, const std::vector<PlannedStep>& plan,
                int workers, std::ostream& out) {
  std::uint64_t beads = 0;
  for (const PlannedStep& step : plan) {
    beads += step.reused ? 0 : step.beads;
    out << fmt::format("{:<8} {}{}\n", name_of(step.stage), single_line(step.what),
                       step.reused ? " (there already)" : "");
  }
  for (const std::string& note : {note_of_idle_keys(experiment), note_of_short_window(experiment)}) {
    if (!note.empty()) out << note << '\n';
  }
  out << std::flush;
  require_memory(memory_needed(experiment, options.folder, workers));
  out << fmt::format("beads to draw: {:.3g}; all together {}\n", static_cast<double>(beads),
                     in_words(estimate_time(plan, workers), workers));
}

/// What was found, and where it is told at length.
void tell_found(const ReportFiles& files, VerbContext& context) {
  if (!files.summary.empty()) context.out << found_text(read_file(files.summary)) << std::flush;
  for (const auto& file : {files.html, files.summary, files.pdf.value_or("")}) {
    if (!file.empty()) context.wrote(file.string());
  }
}

/// The run leaves the resolved experiment in its folder: not in the place of the user's own file and its comments.
void require_kept(const std::string& config, const std::filesystem::path& resolved_file, const std::string& resolved) {
  std::error_code none;
  if (!std::filesystem::equivalent(config, resolved_file, none) || none || read_file(config) == resolved) return;
  throw InputError(
      "{}: the run would leave the experiment there with every default resolved, and this file with its comments would "
      "be lost; rename it or choose another --out",
      config);
}

/// One shard draws its blocks and does nothing else.
void require_shard_alone(const RunVerbOptions& given) {
  const bool more = std::ranges::any_of(given.only, [](const auto& stage) { return stage != "sample"; });
  if (!more && !given.gate && !given.require_pdf) return;
  throw InputError(
      "--shard draws some blocks of the ensembles and comes to no other stage, so that --only, --gate and "
      "--require-pdf have nothing to act on; leave them to the run that follows the last shard");
}

ExitCode tell_plan(const Experiment& experiment, const RunOptions& options, const std::optional<Shard>& shard,
                   std::ostream& out) {
  if (!options.force) require_own_results(options.folder, print_experiment(experiment));
  if (!shard && is_all_there(experiment, options)) {
    out << "everything is there already, and nothing it is made from has changed: nothing would be done\n";
    return ExitCode::done;
  }
  for (const auto& file : keep_changed(options.folder, true))
    out << fmt::format("{0} is not what the last run left there, and would be {1}{0}{2}\n", file.string(),
                       options.force ? "replaced: " : "kept as ", options.force ? "" : ".kept");
  const auto plan = shard ? plan_shard(experiment, options, *shard) : plan_run(experiment, options);
  try {
    print_plan(experiment, options, plan, worker_count(options.threads), out);
  } catch (const Interrupted&) {
    throw Interrupted("stopped on request before the time was estimated; nothing was written");
  }
  return ExitCode::done;
}

std::string environment_variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

ExitCode run(const RunVerbOptions& given, VerbContext& context) {
  if (!given.templates.empty()) use_templates(given.templates);
  const Experiment experiment =
      given.config == "-" ? read_experiment(std::cin, given.overrides) : read_experiment(given.config, given.overrides);
  const bool only_told = given.print_config || given.print_key;
  if (given.from_standard_input() && given.folder.empty() && !only_told) {
    throw InputError(
        "standard input has no name from which that of the results could be taken; give their folder by --out");
  }
  RunOptions options;
  options.keep_going = given.keep_going;
  options.force = given.force;
  if (given.quiet) options.progress = ProgressStyle::silent;
  options.folder = given.folder.empty() ? std::filesystem::path("out") / std::filesystem::path(given.config).stem()
                                        : std::filesystem::path(given.folder);
  options.threads = given.threads;
  options.crew = context.crew;
  options.require_pdf = given.require_pdf;
  for (const std::string& stage : given.only) options.only.push_back(stage_named(stage));
  if (given.require_pdf && !experiment.report.pdf) {
    throw InputError("{}: report.pdf = false contradicts --require-pdf; drop one of them", given.config);
  }
  if (given.gate && !stages_needed(options.only).contains(Stage::analyse)) {
    throw InputError(
        "--gate compares verdicts, but the stages of --only reach none, so that it would always be content; add --only "
        "analyse or drop one of them");
  }
  if (given.gate && experiment.expected_verdicts.empty())
    context.err << "--gate asks for nothing, since the experiment has no [gate.expect] (claim = \"verdict\")\n";
  if (given.print_key) {
    context.out << fmt::format("{}-{}\n", cache_key(print_experiment(experiment)), sampling_version);
    return ExitCode::done;
  }
  if (given.print_config) {
    context.out << print_experiment(experiment);
    return ExitCode::done;
  }
  require_no_history(options.folder);
  require_experiment_kept(options.folder, given.config);
  if (!given.shard.empty()) {
    require_shard_alone(given);
    const Shard shard = shard_named(given.shard, environment_variable, options.folder);
    if (given.dry_run) return tell_plan(experiment, options, shard, context.out);
    require_memory(memory_needed(experiment, options.folder, worker_count(options.threads)));
    options.threads = worker_count(options.threads);
    run_shard(experiment, options, shard);
    return ExitCode::done;
  }
  if (given.dry_run) return tell_plan(experiment, options, std::nullopt, context.out);
  if (!given.from_standard_input())
    require_kept(given.config, options.folder / "experiment.toml", print_experiment(experiment));
  require_memory(memory_needed(experiment, options.folder, worker_count(options.threads)));

  if (context.crew == nullptr && is_one_of_tasks(environment_variable)) {
    context.err
        << "mpirun or srun started several processes, of which each is a whole run: let it start granuscope-mpi "
           "run, or give --shard auto\n";
  }
  const RunResult result = run_experiment(experiment, options);
  if (!given.quiet) tell_found(result.files, context);
  if (!result.files.pdf_skipped.empty() && (!given.quiet || experiment.report.pdf))
    context.err << single_line(result.files.pdf_skipped) << '\n';
  if (given.gate || (!given.quiet && !environment_variable("CI").empty())) {
    for (const std::string& sentence : result.unexpected) context.err << fmt::format("granuscope: {}\n", sentence);
  }
  if (!result.failure.empty()) throw Error(result.code, result.failure);
  if (!given.gate) return ExitCode::done;
  return result.unexpected.empty() ? ExitCode::done : ExitCode::verdict_differs;
}

}  // namespace

void add_run_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("run", "Run an experiment: sample, analyse, plot, render and write the report");
  const auto options = std::make_shared<RunVerbOptions>();
  verb->add_option("CONFIG", options->config,
                   "experiment file (TOML), for example examples/quick.toml; - for standard input")
      ->required();
  verb->add_option("-o,--out", options->folder, "folder of the results (default: out/ and the name of CONFIG)");
  verb->add_option("--only", options->only,
                   "only this stage and what it needs: sample, analyse, render, plot or report; may be repeated")
      ->expected(1)
      ->take_all();
  verb->add_option("--shard", options->shard,
                   "draw only the blocks of shard K of N (K/N), or auto: the place of this process in a Slurm array, "
                   "srun, Open MPI or MPICH; see merge");
  verb->add_option("-j,--threads", options->threads, "threads, 0 for all; never changes a number")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_option(
          "--set", options->overrides,
          "KEY=VALUE in the place of what CONFIG says, for example --set response.samples=1024; may be repeated")
      ->expected(1)
      ->take_all();
  verb->add_flag("-q,--quiet", options->quiet, "say nothing but errors");
  verb->add_flag(
      "--keep-going", options->keep_going,
      "begin although the machine lacks something: that costs its own results only, and status 3 at the end");
  verb->add_flag("--force", options->force, "replace files in the folder that no run of granuscope has written");
  verb->add_flag("--print-key", options->print_key,
                 "print one line that names the experiment and the version of the sampling, for a cache; do nothing");
  verb->add_flag("--dry-run", options->dry_run,
                 "print what would be done and how long it takes, by a trial of some seconds at most; write nothing");
  verb->add_flag("--print-config", options->print_config,
                 "print the experiment with every default resolved; do nothing");
  verb->add_option("--templates", options->templates,
                   "folder whose files stand in for those of the same name in templates/: wording, language, colours");
  verb->add_flag("--require-pdf", options->require_pdf, "fail (status 3) if report.pdf cannot be written");
  verb->add_flag("--gate", options->gate, "end with status 1 if a claim's verdict is not the one in [gate.expect]");
  context.actions[verb] = [options, &context] { return run(*options, context); };
}

}  // namespace granuscope
