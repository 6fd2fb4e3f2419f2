#include <CLI/CLI.hpp>

#include "cli/verbs.h"
#include "experiment/experiment_file.h"

namespace granuscope {

void add_reference_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("reference", "Print the table of experiment keys that README shows (Markdown)");
  verb->group("");  // not listed: for maintainers
  verb->callback([&context] {
    context.action = [&context] {
      context.out << describe_experiment_keys();
      return ExitCode::done;
    };
  });
}

}  // namespace granuscope
