#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/flag_checks.h"
#include "cli/verbs.h"
#include "report/finished_run.h"
#include "report/number_list.h"
#include "support/atomic_file.h"

namespace granuscope {

void add_numbers_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("numbers", "Print every number of a finished run, for the text of a paper");
  const auto folder = std::make_shared<std::string>();
  const auto format = std::make_shared<std::string>("tex");
  verb->add_option("OUT", *folder, "folder of the run")->required();
  verb->add_option("--format", *format, "tex (\\granuscope{beta} writes 2.522(50)), csv or json")
      ->capture_default_str();
  const auto target = std::make_shared<OutputFile>();
  add_output(*verb, "-o,--out", *target, "file to write (standard output if not given)");
  verb->callback([folder, format, target, &context] {
    context.action = [folder, format, target, &context] {
      require_results_of_last_run(*folder, "report");
      const auto file = std::filesystem::path(*folder) / "summary.json";
      std::error_code none;
      if (!std::filesystem::is_regular_file(file, none)) {
        throw InputError(file.string() +
                         ": there is no such file, and so no numbers; name the folder of a finished run");
      }
      const std::string list = list_numbers(read_file(file), *format);
      if (!target->asked()) {
        context.out << list;
      } else {
        target->write(list, {*folder});
        context.err << "wrote " << target->path << '\n';
      }
      return ExitCode::done;
    };
  });
}

}  // namespace granuscope
