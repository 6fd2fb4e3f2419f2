#include <fmt/ranges.h>

#include <set>

#include "cli/flag_checks.h"
#include "experiment/experiment_file.h"
#include "pipeline/pipeline.h"
#include "plot/gnuplot.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

struct NewOptions {
  std::vector<std::string> mu = {"0.1", "0.2", "0.3"};
  std::vector<std::string> errors;  ///< "c=0.001", "D=0.01"
  int layers = LatticeSpec{}.layers;
  std::string estimator = name_of(EstimatorName::multiplexed);
  std::string file;
};

/// A number behind a flag.
double number_of(const std::string& flag, const std::string& text) {
  double number = 0;
  try {
    key_fields::from_text(number, text);
  } catch (const InputError& error) {
    throw InputError("{}: {}", flag, error.what());
  }
  return number;
}

/// The friction coefficients, with what is wrong with them told of the flag, since nobody has written the file yet.
std::vector<double> friction_of(const NewOptions& options) {
  std::vector<double> friction(options.mu.size());
  bool whole = true;
  for (std::size_t k = 0; k < friction.size(); ++k) {
    friction[k] = number_of("--mu", options.mu[k]);
    whole = whole && options.mu[k].find('.') == std::string::npos;
  }
  if (friction.size() > 1 && whole && options.mu[0] == "0") {
    throw InputError("--mu {0} may have a decimal comma; write 0.{1}, or 0.0,{1} for two coefficients",
                     fmt::join(options.mu, ","), options.mu[1]);
  }
  return friction;
}

/// The commented file, without what it takes.
std::string file_text(const NewOptions& options) {
  if (estimator_named(options.estimator) == EstimatorName::paired) {
    throw InputError(
        "--estimator paired gives no c and D: piles solved from the beads of another pile follow another law; give "
        "multiplexed, point or fluctuation");
  }
  std::string text = fmt::format(
      "[friction]\nmu = [{}]  # friction coefficients, from 0 to below sqrt(3)\n\n"
      "[lattice]  # of beads; columns, windows and depths follow where they are not written\n"
      "layers = {}  # the lowest {} follow another law and are not used\n\n"
      "[response]\n"
      "# multiplexed: all loads at the top vary a little at once, the linear response; point: one bead bears twice as\n"
      "# much, the paper's procedure, which needs some twenty times the piles; fluctuation: no load at all\n"
      "estimator = \"{}\"\n"
      "samples = {}  # piles at each mu{}\n",
      fmt::join(friction_of(options), ", "), options.layers, bottom_margin, name_of(estimator_named(options.estimator)),
      options.errors.empty() ? 1024 : 256,
      options.errors.empty() ? "; a usual number: --error-of c=0.001 takes as many as an error needs"
                             : " to begin with");
  if (!options.errors.empty()) text += "\n[precision]  # piles are drawn until the standard errors are so small\n";
  std::set<std::string> asked;
  std::string none;
  for (const std::string& one : options.errors) {
    if (const std::string odd = odd_sign_in(one); !odd.empty()) throw InputError("--error-of {}: {}", one, odd);
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos || (one.substr(0, equals) != "c" && one.substr(0, equals) != "D")) {
      throw InputError("--error-of {} asks for nothing; write c=0.001 or D=0.01, and no decimal comma", one);
    }
    if (!asked.insert(one.substr(0, equals)).second) {
      throw InputError("--error-of {}: its error was given before; give one of c and one of D", one);
    }
    const double error = number_of("--error-of " + one, one.substr(equals + 1));
    if (!(error > 0)) none = one;
    text += fmt::format("{} = {}\n", one.substr(0, equals), error);
  }
  if (!none.empty()) throw InputError("--error-of {}: an error is larger than 0", none);
  return text;
}

/// Draws the first piles of each mu into a folder, so that the number that a precision takes follows from their errors;
/// not where that takes long.
bool try_beginning(Experiment experiment, const std::filesystem::path& folder, int threads) {
  constexpr double longest_trial = 15;  // seconds
  experiment.precision.most_samples = experiment.response.samples;
  RunOptions trial;
  trial.folder = folder;
  trial.only = {Stage::sample};
  trial.progress = ProgressStyle::silent;
  if (!(estimate_time(plan_run(experiment, trial), threads).seconds <= longest_trial)) return false;
  run_experiment(experiment, trial);
  return true;
}

/// Where some piles leave c and D unknown, a comment each with the reason: tried from the smallest friction on, since
/// the narrowest peaks are there, up to the first of which both are known.
std::string told_of_unknown(NewOptions options, const std::filesystem::path& folder) {
  std::vector<double> friction = friction_of(options);
  std::ranges::sort(friction);
  options.errors = {"c=1", "D=1"};
  std::string told;
  for (const double mu : friction) {
    if (mu == 0) continue;
    options.mu = {exact(mu)};
    const Experiment experiment = parse_experiment(file_text(options), "granuscope new");
    RunOptions run;
    run.folder = folder / exact(mu);
    run.of_trial = try_beginning(experiment, run.folder, worker_count(0));
    const std::string why = run.of_trial ? plan_run(experiment, run).front().unreached : "";
    if (why.empty()) break;
    told += fmt::format("# {} piles at mu = {}: {}\n", experiment.response.samples, mu, why);
  }
  return told;
}

/// What a run of it does on this machine, as comments.
std::string told_of(const std::string& text, const NewOptions& options) {
  const std::string name = options.file.empty() ? "experiment.toml" : options.file;
  const Experiment experiment = parse_experiment(text, "granuscope new");
  const int threads = worker_count(0);
  const ScratchFolder scratch("granuscope-new");
  RunOptions run;
  run.folder = scratch.path() / "trial";
  run.of_trial = experiment.precision.asked() && try_beginning(experiment, run.folder, threads);
  const std::vector<PlannedStep> plan = plan_run(experiment, run);
  std::string told = fmt::format(
      "# granuscope run {0}                  makes its report\n# granuscope run {0} --print-config   shows every key "
      "with its value\n#\n# {1} × {2} beads, on this machine {3}:\n",
      shell_word(name), experiment.lattice.columns, experiment.lattice.layers,
      in_words(estimate_time(plan, threads), threads));
  for (const PlannedStep& step : plan) {
    if (step.stage == Stage::sample) told += fmt::format("#   {}\n", step.what);
  }
  if (options.errors.empty()) told += told_of_unknown(options, scratch.path());
  return told + "\n" + text;
}

/// Nobody has written a file yet, in whose line something could be wrong.
std::string text_of_new(const NewOptions& options) {
  try {
    return told_of(file_text(options), options);
  } catch (const Interrupted&) {
    throw Interrupted("stopped on request: no file was written, and the same command begins anew");
  } catch (const InputError& error) {
    const std::string said = error.what();
    const std::string place = "granuscope new:";
    if (!said.starts_with(place)) throw;
    throw InputError("{}", said.substr(std::min(said.size(), said.find(' ', place.size()) + 1)));
  }
}

ExitCode write_new(const NewOptions& options, VerbContext& context) {
  require_suffix(options.file, ".toml");
  std::error_code none;
  if (!options.file.empty() && std::filesystem::exists(std::filesystem::symlink_status(options.file, none))) {
    throw InputError("{} is there already, and an experiment is never written over; name another file", options.file);
  }
  const std::string text = text_of_new(options);
  if (options.file.empty()) {
    context.out << text;
    return ExitCode::done;
  }
  write_file(options.file, text);
  context.wrote(options.file);
  return ExitCode::done;
}

}  // namespace

void add_new_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb =
      app.add_subcommand("new", "Write an experiment file with comments, the number of piles and the time they take");
  const auto options = std::make_shared<NewOptions>();
  listed(verb->add_option("--mu", options->mu, "friction coefficients, as 0.2,0.3"))
      ->expected(-1)
      ->capture_default_str();
  listed(verb->add_option("--error-of", options->errors,
                          "c=0.001, D=0.01 or both: the standard errors wanted, for which piles are drawn"))
      ->expected(-1);
  verb->add_option("--layers", options->layers, "layers of the piles")->capture_default_str();
  verb->add_option("--estimator", options->estimator, "multiplexed, point or fluctuation")->capture_default_str();
  verb->add_option("-o,--out", options->file, "file to write, which must not be there (default: standard output)")
      ->check(output_file());
  context.actions[verb] = [options, &context] { return write_new(*options, context); };
}

}  // namespace granuscope
