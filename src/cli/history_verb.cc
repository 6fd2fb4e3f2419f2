#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/verbs.h"
#include "history/night_page.h"
#include "history/nightly.h"
#include "support/error.h"

namespace granuscope {
namespace {

struct HistoryVerbOptions {
  std::string folder, action, format = "json";
  std::int64_t night = 0;
};

ExitCode history(const HistoryVerbOptions& given, VerbContext& context) {
  const bool of_one = given.action == "show" || given.action == "forget" || given.action == "accept";
  if (of_one && given.night < 1) {
    throw InputError(given.action + " needs the number of a night; `granuscope history DIR list` shows them");
  }
  if (!std::filesystem::exists(std::filesystem::path(given.folder) / "history.sqlite")) {
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
  const NightBook book(given.folder);
  if (given.action == "list") {
    for (const Night& night : book.last(0)) context.out << describe(night) << '\n';
  } else if (given.action == "show") {
    context.out << json_text({book.night(given.night)});
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
  verb->add_option("--format", options->format, "of export: csv (the primary numbers) or json (all)")
      ->capture_default_str()
      ->check(CLI::IsMember({"csv", "json"}));
  verb->callback([options, &context] { context.action = [options, &context] { return history(*options, context); }; });
}

}  // namespace granuscope
