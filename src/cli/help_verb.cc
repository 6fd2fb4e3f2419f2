#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/verbs.h"
#include "experiment/nearest_name.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

/// What somebody may have meant who wrote a file where a verb belongs; "" if it is none.
std::string verb_for_file(const std::string& word) {
  if (word.ends_with(".toml")) return "run " + word;
  if (word.ends_with(".h5")) return "render " + word;
  std::error_code none;
  return std::filesystem::is_regular_file(word, none) ? "run " + word : "";
}

}  // namespace

const CLI::App& verb_named(const CLI::App& app, const std::string& name) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == name) return *verb;
    if (!verb->get_group().empty()) verbs.push_back(verb->get_name());
  }
  const auto told = [&]() -> std::string {
    if (const std::string command = verb_for_file(name); !command.empty()) {
      return fmt::format("did you mean: granuscope {}?", command);
    }
    const auto meant = nearest_name(name, verbs);
    return meant ? fmt::format("did you mean {}?", *meant) : fmt::format("the verbs are {}", fmt::join(verbs, ", "));
  };
  throw InputError(fmt::format("there is no verb \"{}\"; {}", name, told()));
}

void add_help_verb(CLI::App& app, VerbContext& context) {
  CLI::App* help = app.add_subcommand("help", "Print what this program, or one of its verbs, can be asked for");
  const auto verb = std::make_shared<std::string>();
  help->add_option("VERB", *verb, "the verb (all of them in short if not given)");
  help->callback([verb, &app, &context] {
    context.action = [verb, &app, &context] {
      // app.help() would be that of the verb help.
      const auto formatter = app.get_formatter();
      context.out << (verb->empty() ? formatter->make_help(&app, "granuscope", CLI::AppFormatMode::Normal)
                                    : verb_named(app, *verb).help("granuscope"));
      return ExitCode::done;
    };
  });
  CLI::App* version = app.add_subcommand("version", "Print the version, as --version does");
  version->group("");  // not listed: the flag is
  version->callback([&context] {
    context.action = [&context] {
      context.out << provenance_line(collect_provenance()) << '\n';
      return ExitCode::done;
    };
  });
}

}  // namespace granuscope
