#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include "bench/accuracy_suite.h"
#include "bench/render_suite.h"
#include "bench/sampler_suite.h"
#include "cli/verbs.h"
#include "support/atomic_file.h"

namespace granuscope {
namespace {

struct BenchOptions {
  std::string suite;
  std::string json_file;
  std::string folder;
  bool quick = false;
  AccuracyOptions accuracy;
};

ExitCode bench_accuracy(const BenchOptions& options, VerbContext& context) {
  const std::string json = accuracy_json(measure_accuracy(options.accuracy, context.err));
  if (options.json_file.empty()) {
    context.out << json;
  } else {
    write_file(options.json_file, json);
    context.err << fmt::format("wrote {}\n", options.json_file);
  }
  return ExitCode::done;
}

ExitCode bench_sampler(const BenchOptions& options, VerbContext& context) {
  const SamplerBench result =
      run_sampler_suite({}, [&](const std::string& text) { context.err << text << "\n"
                                                                       << std::flush; });
  if (!options.json_file.empty()) write_file(options.json_file, sampler_bench_json(result));
  context.out << sampler_bench_table(result);
  return ExitCode::done;
}

ExitCode bench_render(const BenchOptions& options, VerbContext& context) {
  const std::filesystem::path folder =
      options.folder.empty() ? std::filesystem::temp_directory_path() / fmt::format("granuscope-bench-{}", ::getpid())
                             : std::filesystem::path(options.folder);
  const bool made_here = options.folder.empty();
  const RenderBench result = run_render_suite(render_cases(options.quick), folder, [&](const std::string& text) {
    context.err << text << "\n" << std::flush;
  });
  if (made_here) std::filesystem::remove_all(folder);
  if (!options.json_file.empty()) write_file(options.json_file, render_bench_json(result));
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

ExitCode bench(const BenchOptions& options, VerbContext& context) {
  for (const Suite& suite : suites) {
    if (options.suite == suite.name) return suite.run(options, context);
  }
  throw InputError(fmt::format("there is no suite '{}' to run; known are {}", options.suite, names_of_suites(false)));
}

}  // namespace

void add_bench_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("bench", "Measure how long things take, each against its target");
  const auto options = std::make_shared<BenchOptions>();
  verb->add_option("SUITE", options->suite, "what to measure: " + names_of_suites(true))->required();
  verb->add_option("--json", options->json_file, "also write the numbers to this file");
  verb->add_option("--folder", options->folder, "where piles and pictures are made for the time of the run");
  verb->add_flag("--quick", options->quick, "leave out what takes minutes");
  verb->add_option("--threads", options->accuracy.threads,
                   "accuracy: repetitions drawn at the same time; one at a time disturbs them least")
      ->capture_default_str()
      ->check(CLI::Range(1, 4096));
  verb->add_option("--repetitions", options->accuracy.repetitions,
                   "accuracy: independent repetitions of each estimator")
      ->capture_default_str()
      ->check(CLI::Range(2, 100000));
  verb->callback([options, &context] { context.action = [options, &context] { return bench(*options, context); }; });
}

}  // namespace granuscope
