#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/installed_files.h"
#include "cli/verbs.h"
#include "experiment/experiment_file.h"
#include "support/atomic_file.h"

namespace granuscope {
namespace {

/// Text as one cell of a Markdown table; a bar would end the cell, even inside code.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

std::string flag_row(const CLI::Option& option) {
  const std::string type = option.get_expected_max() == 0 ? "" : option.get_type_name();
  const std::string standard = option.get_default_str();
  return fmt::format("| `{}` | {} | {} | {} |\n",
                     cell(option.nonpositional() ? option.get_name(false, true) : option.get_name(true)), cell(type),
                     standard.empty() ? "" : fmt::format("`{}`", cell(standard)), cell(option.get_description()));
}

/// A heading and a table of flags for each listed verb, from the very objects that read the command line.
std::string describe_verbs(const CLI::App& app) {
  std::string text;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_group().empty()) continue;
    text += fmt::format("### granuscope {}\n\n{}\n\n| flag | value | default | meaning |\n|---|---|---|---|\n",
                        verb->get_name(), verb->get_description());
    for (const CLI::Option* option : verb->get_options()) text += flag_row(*option);
    text += '\n';
  }
  return text;
}

}  // namespace

void add_reference_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("reference", "Print the table of experiment keys, docs/reference.md (Markdown)");
  verb->group("");  // not listed: for maintainers
  const auto verbs = std::make_shared<bool>(false);
  const auto folder = std::make_shared<std::string>();
  verb->add_flag("--verbs", *verbs, "print every verb with its flags instead");
  verb->add_option("--files", *folder, "write manual pages and completion files below this folder (share) instead");
  verb->callback([&app, &context, verbs, folder] {
    context.action = [&app, &context, verbs, folder] {
      if (!folder->empty()) {
        for (const auto& [path, text] : installed_files(app)) {
          const auto file = std::filesystem::path(*folder) / path;
          make_folder(file.parent_path());
          write_file(file, text);
        }
        return ExitCode::done;
      }
      context.out << (*verbs ? describe_verbs(app) : describe_experiment_keys());
      return ExitCode::done;
    };
  });
}

}  // namespace granuscope
