#include <functional>
#include <iterator>

#include "bench/suites.h"
#include "cli/flag_checks.h"
#include "plot/gnuplot.h"
#include "support/progress.h"

namespace granuscope {
namespace {

struct BenchOptions {
  std::string suite;
  OutputFile json_file;
  std::string folder;
  bool quick = false;
  AccuracyOptions accuracy;
};

/// Says what is being measured, each time a moment at which to stop if asked to.
std::function<void(const std::string&)> teller(VerbContext& context) {
  return [&context](const std::string& text) {
    throw_if_interrupted();
    context.err << text << "\n" << std::flush;
  };
}

ExitCode bench_accuracy(const BenchOptions& options, VerbContext& context) {
  AccuracyOptions accuracy = options.accuracy;
  accuracy.quick = options.quick;
  const std::string json = with_measured_with(accuracy_json(measure_accuracy(accuracy, context.err)));
  if (!options.json_file.asked()) {
    context.out << json;
  } else {
    options.json_file.write(json);
    context.wrote(options.json_file.path);
  }
  return ExitCode::done;
}

ExitCode bench_sampler(const BenchOptions& options, VerbContext& context) {
  const SamplerBench result = run_sampler_suite({}, teller(context));
  if (options.json_file.asked()) options.json_file.write(with_measured_with(sampler_bench_json(result)));
  context.out << sampler_bench_table(result);
  return ExitCode::done;
}

ExitCode bench_render(const BenchOptions& options, VerbContext& context) {
  std::error_code none;
  const std::filesystem::path folder =
      options.folder.empty() ? std::filesystem::temp_directory_path(none) : std::filesystem::path(options.folder);
  if (none) {
    throw EnvironmentError(
        "there is no folder for temporary files (TMPDIR), and so no place for the piles; name one with --folder");
  }
  remove_leftovers(folder);
  const ScratchFolder scratch(folder, "bench");
  const RenderBench result = run_render_suite(render_cases(options.quick), scratch.path(), teller(context));
  if (options.json_file.asked()) options.json_file.write(with_measured_with(render_bench_json(result)));
  context.out << render_bench_table(result);
  return ExitCode::done;
}

struct Suite {
  const char* name;
  const char* about;
  ExitCode (*run)(const BenchOptions&, VerbContext&);
};

constexpr Suite suites[] = {
    {"sampler", "time per bead of each engine, and scaling with threads", bench_sampler},
    {"accuracy", "run time against the scatter of c and D", bench_accuracy},
    {"render", "time and memory of pictures", bench_render},
};

/// "sampler, accuracy and render"; with what each is about in parentheses if asked for.
std::string names_of_suites(bool with_descriptions) {
  std::string names;
  for (std::size_t k = 0; k < std::size(suites); ++k) {
    names += k == 0 ? "" : k + 1 == std::size(suites) ? " and " : ", ";
    names += suites[k].name;
    if (with_descriptions) names += fmt::format(" ({})", suites[k].about);
  }
  return names;
}

/// A flag that belongs to another suite would change nothing.
void refuse_foreign_flags(const BenchOptions& options) {
  const auto refuse = [&](const char* flag, const char* owner) {
    throw InputError("{} belongs to the suite {} and would change nothing in {}; leave it out", flag, owner,
                     options.suite);
  };
  const AccuracyOptions usual;
  if (options.suite == "sampler" && options.quick) refuse("--quick", "render or accuracy");
  if (options.suite != "render" && !options.folder.empty()) refuse("--folder", "render");
  if (options.suite != "accuracy") {
    if (options.accuracy.threads != usual.threads) refuse("--threads", "accuracy");
    if (options.accuracy.repetitions != usual.repetitions) refuse("--repetitions", "accuracy");
  }
}

ExitCode bench(const BenchOptions& options, VerbContext& context) {
  for (const Suite& suite : suites) {
    if (options.suite != suite.name) continue;
    refuse_foreign_flags(options);
    require_suffix(options.json_file.path, ".json");
    if (options.json_file.asked()) {  // missed now, not after minutes
      options.json_file.require_free({}, "{\n  \"measured\": {\"program\":\"granuscope");
      require_writable(options.json_file.path);
    }
    try {
      return suite.run(options, context);
    } catch (const Interrupted&) {
      throw Interrupted("stopped on request: a suite measured half tells nothing, so nothing was written; start again");
    }
  }
  throw InputError("there is no suite '{}' to run; known are {}", options.suite, names_of_suites(false));
}

}  // namespace

void add_bench_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("bench", "Measure how long things take, each against its target");
  const auto options = std::make_shared<BenchOptions>();
  verb->add_option("SUITE", options->suite, "what to measure: " + names_of_suites(true))->required();
  add_output(*verb, "--json", options->json_file, "also write the numbers to this file");
  verb->add_option("--folder", options->folder,
                   "render: where piles and pictures are made for the time of the run (default: $TMPDIR or /tmp)");
  verb->add_flag("--quick", options->quick, "render, accuracy: leave out what takes minutes");
  verb->add_option("-j,--threads", options->accuracy.threads,
                   "accuracy: blocks drawn at the same time; one at a time disturbs them least")
      ->capture_default_str()
      ->check(CLI::Range(1, 4096));
  verb->add_option("--repetitions", options->accuracy.repetitions,
                   "accuracy: independent repetitions of each estimator")
      ->capture_default_str()
      ->check(CLI::Range(least_repetitions, most_blocks / repetition_blocks));
  context.actions[verb] = [options, &context] { return bench(*options, context); };
}

}  // namespace granuscope
