#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/flag_checks.h"
#include "cli/verbs.h"
#include "experiment/experiment_file.h"
#include "history/night_page.h"
#include "history/nightly.h"
#include "support/error.h"

namespace granuscope {
namespace {

struct NightlyVerbOptions {
  std::string config, history;
  std::vector<std::string> overrides;
  std::size_t keep = 30;
  std::uint64_t grow = 0;
  int threads = 0;
  bool verbose = false;
};

ExitCode nightly(const NightlyVerbOptions& given, VerbContext& context) {
  const Experiment experiment = read_experiment(given.config, given.overrides);
  NightlyOptions options;
  options.folder = given.history;
  options.keep = given.keep;
  options.grow = given.grow;
  options.threads = given.threads;
  if (given.verbose) options.progress = ProgressStyle::automatic;
  const Night night = run_night(experiment, options);
  // cron mails what is printed: nothing, unless there is something to say.
  if (night.status == "fine") return ExitCode::done;
  context.out << "night " << describe(night) << '\n';
  return ExitCode::verdict_differs;
}

}  // namespace

void add_nightly_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "nightly",
      "Run an experiment night after night: the same samples must give the same numbers, new ones join them");
  const auto options = std::make_shared<NightlyVerbOptions>();
  verb->add_option("EXPERIMENT", options->config, "experiment file (TOML)")->required();
  verb->add_option("--history", options->history, "folder of the history")->required();
  verb->add_option("--keep", options->keep, "reports kept")->capture_default_str()->check(CLI::Range(1, 100000));
  verb->add_option(
          "--grow", options->grow,
          "samples by which the pool grows, in whole rounds of eight for each block (default: response.samples)")
      ->check(whole_number());
  verb->add_option("--set", options->overrides, "KEY=VALUE in the place of what EXPERIMENT says; may be repeated")
      ->expected(1)
      ->take_all();
  verb->add_option("-j,--threads", options->threads, "threads, 0 for all; never changes a number")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--verbose", options->verbose, "tell progress");
  verb->callback([options, &context] { context.action = [options, &context] { return nightly(*options, context); }; });
}

}  // namespace granuscope
