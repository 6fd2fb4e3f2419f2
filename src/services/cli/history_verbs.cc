#include <unistd.h>

#include <algorithm>

#include "cli/flag_checks.h"
#include "experiment/experiment_file.h"
#include "history/night_book.h"
#include "history/nightly.h"
#include "pipeline/run_folder.h"

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
  if (given.verbose && given.grow > 0 && samples_of_night(experiment, given.grow) != given.grow) {
    context.err << fmt::format("--grow {} is rounded up to {}, whole rounds of eight samples for each block\n",
                               given.grow, samples_of_night(experiment, given.grow));
  }
  require_experiment_kept(given.history, given.config);
  const Night night = run_night(experiment, options);
  // cron mails what is printed: nothing, unless there is something to say. Who sits before a terminal wants to look.
  if (::isatty(STDERR_FILENO) != 0) {
    context.err << fmt::format("{}the history is in {}\n", night.status == "fine" ? describe(night) + "; " : "",
                               (std::filesystem::path(given.history) / "index.html").string());
  }
  if (night.status == "fine") return ExitCode::done;
  context.out << "night " << describe(night) << '\n';
  // What the machine lacked says nothing against the numbers.
  const bool machine_only =
      std::ranges::all_of(night.alarms, [](const Alarm& one) { return one.state != "open" || one.kind == lacking; });
  return machine_only ? ExitCode::environment : ExitCode::verdict_differs;
}

}  // namespace

void add_nightly_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "nightly",
      "Run an experiment night after night: the same samples must give the same numbers, new ones join them. Prints "
      "nothing and ends with 0 if all is well, 1 if the night alarms, 3 if the machine lacks something (a figure that "
      "could not be made, say, while the numbers are fine), 4 if stopped, 5 if another night is at work");
  const auto options = std::make_shared<NightlyVerbOptions>();
  verb->add_option("EXPERIMENT", options->config, "experiment file (TOML)")->required();
  verb->add_option("--history", options->history, "folder of the history")->required();
  verb->add_option("--keep", options->keep, "reports kept")->capture_default_str()->check(CLI::Range(1, 100000));
  verb->add_option("--grow", options->grow,
                   "samples by which the pool grows, at least 1, rounded up to whole rounds of eight for each block "
                   "(default: response.samples)")
      ->check([](const std::string& text) {
        return text.find_first_not_of('0') == std::string::npos
                   ? "a pool that does not grow is no measurement; give 1 or more"
                   : "";
      });
  verb->add_option("--set", options->overrides, "KEY=VALUE in the place of what EXPERIMENT says; may be repeated")
      ->expected(1)
      ->take_all();
  verb->add_option("-j,--threads", options->threads, "threads, 0 for all; never changes a number")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--verbose", options->verbose, "tell progress");
  context.actions[verb] = [options, &context] { return nightly(*options, context); };
}

namespace {

struct HistoryVerbOptions {
  std::string folder, action, format = "json";
  std::int64_t night = 0;
  bool json = false;
};

ExitCode history(const HistoryVerbOptions& given, VerbContext& context) {
  const bool of_one = given.action == "show" || given.action == "forget" || given.action == "accept";
  if (!of_one && given.night != 0) {
    throw InputError("{} takes no night, and {} is one; leave it out, or say show {}", given.action, given.night,
                     given.night);
  }
  if (given.json && given.action == "export") {
    throw InputError("--json is of list and show; export has --format, which is json unless given");
  }
  if (of_one && given.night < 1) {
    throw InputError(given.action + " needs the number of a night; `granuscope history DIR list` shows them");
  }
  if (!std::filesystem::exists(std::filesystem::path(given.folder) / "history.sqlite")) {
    require_no_lost_history(given.folder);
    throw InputError(given.folder + ": there is no history in this folder; `granuscope nightly` makes one");
  }
  if (given.action == "accept") {
    accept_night(given.folder, given.night);
    return ExitCode::done;
  }
  if (given.action == "forget") {
    forget_night(given.folder, given.night);
    return ExitCode::done;
  }
  const NightBook book(given.folder, DatabaseUse::read);
  if (given.json && (given.action == "list" || given.action == "show")) {
    context.out << json_text(given.action == "show" ? std::vector<Night>{book.night(given.night)} : book.last(0));
  } else if (given.action == "list") {
    for (const Night& night : book.last(0)) context.out << describe(night) << '\n';
  } else if (given.action == "show") {
    context.out << table_text(book.night(given.night));
  } else {
    context.out << (given.format == "csv" ? csv_text(book.last(0)) : json_text(book.last(0)));
  }
  return ExitCode::done;
}

}  // namespace

void add_history_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("history", "What became of the nights: list, show, export, forget, accept");
  const auto options = std::make_shared<HistoryVerbOptions>();
  verb->add_option("DIR", options->folder, "folder of the history, as nightly --history made it")->required();
  verb->add_option(
          "ACTION", options->action,
          "list; show NIGHT; export; forget NIGHT: remove its record; accept NIGHT: its alarms are the new normal "
          "from here on, and the night stays")
      ->required()
      ->check(CLI::IsMember({"list", "show", "export", "forget", "accept"}));
  verb->add_option("NIGHT", options->night, "number of a night");
  verb->add_flag("--json", options->json, "of list and show: one JSON object instead of a table");
  verb->add_option("--format", options->format, "of export: csv (the primary numbers) or json (all)")
      ->capture_default_str()
      ->transform(CLI::IsMember({"csv", "json"}, CLI::ignore_case));
  context.actions[verb] = [options, &context] { return history(*options, context); };
}

}  // namespace granuscope
