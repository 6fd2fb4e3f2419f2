#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/flag_checks.h"
#include "cli/verbs.h"
#include "history/comparison.h"
#include "support/atomic_file.h"

namespace granuscope {
namespace {

struct CompareVerbOptions {
  std::string before, after;
  OutputFile json;
  bool gate = false;
};

ExitCode compare(const CompareVerbOptions& given, VerbContext& context) {
  if (given.json.asked()) require_writable(given.json.path);
  const Comparison comparison = compare_runs(given.before, given.after);
  for (const std::string& line : describe(comparison)) context.out << line << '\n';
  if (given.json.asked()) given.json.write(json_text(comparison), {given.before, given.after});
  const bool comparable = comparison.likeness != Likeness::other_experiment;
  return given.gate && (!comparable || comparison.alarms()) ? ExitCode::verdict_differs : ExitCode::done;
}

}  // namespace

void add_compare_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb =
      app.add_subcommand("compare",
                         "Compare two runs: same numbers, same experiment, other samples of it, or another one. Ends "
                         "with 0, whatever it finds, unless --gate is given; with 2 if there is nothing to compare");
  const auto options = std::make_shared<CompareVerbOptions>();
  verb->add_option("OLD", options->before, "folder of a run, or its summary.json")->required();
  verb->add_option("NEW", options->after, "folder of another run, or its summary.json")->required();
  add_output(*verb, "--json", options->json, "file for the answer as JSON, every number with it");
  verb->add_flag(
      "--gate", options->gate,
      "end with status 1 if the same experiment has other numbers beyond rounding, if a number moved between "
      "samples, or if the experiments cannot be compared");
  verb->callback([options, &context] { context.action = [options, &context] { return compare(*options, context); }; });
}

}  // namespace granuscope
