#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/verbs.h"
#include "experiment/experiment_file.h"
#include "experiment/nearest_name.h"
#include "support/template_file.h"

namespace granuscope {
namespace {

constexpr std::string_view folder = "examples/";
constexpr std::string_view extension = ".toml";

std::vector<std::string> names_of_examples() {
  std::vector<std::string> names;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.name.starts_with(folder)) continue;
    const std::string_view name = file.name.substr(folder.size());
    names.emplace_back(name.substr(0, name.size() - extension.size()));
  }
  return names;
}

std::string text_of_example(const std::string& name) {
  return std::string(template_file(fmt::format("{}{}{}", folder, name, extension)));
}

ExitCode print_example(std::string name, VerbContext& context) {
  const std::vector<std::string> names = names_of_examples();
  if (name.empty()) {
    for (const std::string& known : names) {
      const Experiment experiment = parse_experiment(text_of_example(known), known);
      context.out << fmt::format("{:<16}{}\n", known, experiment.name);
    }
    context.err << "granuscope example quick >quick.toml    writes one of them, and\n"
                   "granuscope run quick.toml               makes its report in out/quick\n";
    return ExitCode::done;
  }
  if (name.ends_with(extension)) name.resize(name.size() - extension.size());
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const auto meant = nearest_name(name, names);
    throw InputError(fmt::format("there is no example {}; {}built in are {}", name,
                                 meant ? fmt::format("did you mean {}? ", *meant) : "", fmt::join(names, ", ")));
  }
  context.out << text_of_example(name);
  return ExitCode::done;
}

}  // namespace

void add_example_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("example", "Print a built-in experiment, to be run or changed");
  const auto name = std::make_shared<std::string>();
  verb->add_option("NAME", *name, "which one, for example quick (a list if not given)");
  verb->callback([name, &context] { context.action = [name, &context] { return print_example(*name, context); }; });
}

}  // namespace granuscope
