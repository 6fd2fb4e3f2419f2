// What a run would do, estimated without doing it.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "analysis/precision.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "experiment/experiment.h"
#include "pipeline/block_files.h"
#include "pipeline/pipeline.h"
#include "pipeline/sample_stage.h"
#include "sampling/polytope.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {

struct StageRule {
  Stage stage;
  const char* name;
  std::vector<Stage> needs;
};

const std::vector<StageRule>& rules() {
  static const std::vector<StageRule> all{{Stage::sample, "sample", {}},
                                          {Stage::analyse, "analyse", {Stage::sample}},
                                          {Stage::render, "render", {}},
                                          {Stage::plot, "plot", {Stage::analyse}},
                                          {Stage::report, "report", {Stage::analyse, Stage::plot, Stage::render}}};
  return all;
}

void add_with_needs(Stage stage, std::set<Stage>& into) {
  for (const StageRule& rule : rules()) {
    if (rule.stage != stage || !into.insert(stage).second) continue;
    for (Stage need : rule.needs) add_with_needs(need, into);
  }
}

}  // namespace

std::string name_of(Stage stage) {
  for (const StageRule& rule : rules()) {
    if (rule.stage == stage) return rule.name;
  }
  return {};
}

std::set<std::string> names_of(const std::set<Stage>& stages) {
  std::set<std::string> names;
  for (const Stage stage : stages) names.insert(name_of(stage));
  return names;
}

Stage stage_named(const std::string& name) {
  for (const StageRule& rule : rules()) {
    if (name == rule.name) return rule.stage;
  }
  throw InputError("there is no stage \"{}\": known are sample, analyse, render, plot and report", name);
}

std::set<Stage> stages_needed(const std::vector<Stage>& asked_for) {
  std::set<Stage> needed;
  for (Stage stage : asked_for) add_with_needs(stage, needed);
  if (asked_for.empty()) add_with_needs(Stage::report, needed);
  return needed;
}

namespace {

const char* kind_of(const EnsembleSpec& spec) { return piles_per_sample(spec) == 2 ? "pairs of piles" : "piles"; }

/// How far an ensemble would still have to grow: from the errors of what is there, or else from those to be expected.
PlannedStep plan_growth(const Experiment& experiment, const RunOptions& options, PlannedEnsemble planned) {
  const PrecisionSpec& asked = planned.towards;
  const EnsembleSpec& spec = planned.spec;
  const bool multiplexed = spec.response.estimator == EstimatorName::multiplexed;
  Transport errors;
  const ExpectedErrors expected = expected_errors(
      spec.sampler.mu, multiplexed, multiplexed ? spec.response.epsilon : spec.response.overload, spec.lattice.columns,
      static_cast<std::uint64_t>(worth_of_sample(spec) * static_cast<double>(spec.response.samples)));
  errors.c = {0.5, expected.c, ""};
  errors.D = {0.1, expected.D, ""};
  errors.effective_samples = {thinning_times * static_cast<double>(spec.response.samples), 0, ""};  // of a chain
  const std::optional<MeasuredEnsemble> ensemble = reuse_ensemble(planned, options.folder);
  const bool there = ensemble.has_value();
  if (there) errors = measure_for_precision(planned, *ensemble, experiment.fit, options.threads);
  const PrecisionLook look = look_at_precision(asked, errors, spec.response.samples);
  std::uint64_t rounds = spec.response.samples / (group_size * static_cast<std::uint64_t>(spec.response.blocks)),
                samples = spec.response.samples;
  while (!look.unattainable && static_cast<double>(samples) < look.samples_needed) {
    rounds = next_size(rounds);
    const std::uint64_t next = rounds * group_size * static_cast<std::uint64_t>(spec.response.blocks);
    if (next > asked.most_samples) break;
    samples = next;
  }
  const bool enough = look.unattainable || static_cast<double>(samples) >= look.samples_needed;
  const std::uint64_t drawn = there && !options.of_trial ? spec.response.samples : 0;
  std::string what = fmt::format("about {} {}, {}, for the precision asked ({})", samples, kind_of(spec), planned.label,
                                 !there             ? "by a rule of thumb"
                                 : options.of_trial ? fmt::format("by the errors of {}", spec.response.samples)
                                                    : "by the errors so far");
  if (look.unattainable) what += ", which it does not reach: " + look.reason;
  if (drawn > 0 && samples != drawn) what += fmt::format(", {} of them there already", drawn);
  if (!enough) {
    what += fmt::format("; not reached: precision.most_samples = {} ends it there, about {} would be needed; raise it",
                        asked.most_samples, significant(look.samples_needed, 2));
  }
  if (!planned.replaces.empty()) what += fmt::format("; replaces the file there: {}", planned.replaces);
  return {Stage::sample, what, samples == drawn, beads_of(spec, samples - drawn), spec, samples - drawn, look.reason};
}

/// A single pile, of a law that may take long for it.
void draw_one(PlannedStep& step, const EnsembleSpec& spec) {
  if (spec.sampler.law == Law::granusolve) return;
  step.spec = spec;
  step.samples = spec.sampler.law == Law::polytope ? group_size : 1;  // a chain runs for eight
}

}  // namespace

std::vector<PlannedStep> plan_run(const Experiment& experiment, const RunOptions& options) {
  const std::set<Stage> needed = stages_needed(options.only);
  std::vector<PlannedStep> steps;
  double fits = 0;
  if (needed.contains(Stage::sample)) {
    const auto add = [&](const PlannedEnsemble& planned) {
      fits += seconds_for_fits(planned.spec);
      if (planned.grows_from > 0) {
        steps.push_back(plan_growth(experiment, options, planned));
        return;
      }
      const std::uint64_t begun =
          planned.blocks_there > 0 ? BlockFiles(planned, options.folder).samples() : samples_there(planned);
      const std::uint64_t left = planned.reusable ? 0 : planned.spec.response.samples - begun;
      std::string continued = begun == 0 || planned.reusable ? "" : fmt::format(", {} of them there already", begun);
      if (planned.blocks_there > 0) {
        continued =
            fmt::format(", {} of {} blocks drawn by shards", planned.blocks_there, planned.spec.response.blocks);
      }
      const std::string replaces =
          planned.replaces.empty() ? "" : fmt::format("; replaces the file there: {}", planned.replaces);
      steps.push_back({Stage::sample,
                       fmt::format("{} {}, {}{}{}", planned.spec.response.samples, kind_of(planned.spec), planned.label,
                                   continued, replaces),
                       planned.reusable, beads_of(planned.spec, left), planned.spec, left});
    };
    for (const PlannedEnsemble& planned : plan_ensembles(experiment, options.folder)) add(planned);
    for (const StudyEnsemble& one : experiment.studies.ensembles(experiment)) add(plan_ensemble(one, options.folder));
  }
  if (needed.contains(Stage::analyse)) {
    steps.push_back(
        {Stage::analyse,
         fmt::format("fits of {}, layers {} to {}", how_many(experiment.scan_values().size(), "main ensemble"),
                     experiment.fit.first_layer, experiment.fit.last_layer),
         false, 0});
    steps.back().parallel_seconds = fits;
    for (const auto& study : experiment.studies) steps.back().serial_seconds += study->seconds();
  }
  if (needed.contains(Stage::render) && experiment.force_chains.show) {
    steps.push_back({Stage::render, "force chains", false,
                     static_cast<std::uint64_t>(experiment.force_chains.columns) *
                         static_cast<std::uint64_t>(experiment.force_chains.computed_layers())});
    steps.back().serial_seconds = seconds_for_pictures;
    draw_one(steps.back(), pile_spec(experiment, experiment.force_chains.mu));
    if (experiment.sampling.model.has_contacts() && needs_pair(experiment)) {
      EnsembleSpec uniform = pile_spec(experiment, experiment.force_chains.mu);
      uniform.load = Load::uniform;
      steps.push_back({Stage::render, "their pile under a uniform load", false, Lattice(uniform.lattice).beads()});
      draw_one(steps.back(), uniform);
    }
  }
  if (needed.contains(Stage::plot)) {
    steps.push_back({Stage::plot, "figures", false, 0});
    steps.back().serial_seconds = seconds_for_figures;
    const double mu = experiment.figures.profile_mu;
    const bool another = !experiment.force_chains.show || mu != experiment.force_chains.mu;
    if (experiment.sampling.model.has_contacts() && experiment.figures.bead_forces && another)
      draw_one(steps.back(), pile_spec(experiment, mu));
  }
  if (needed.contains(Stage::report)) {
    steps.push_back({Stage::report, "report", false, 0});
    steps.back().serial_seconds = seconds_for_report;
  }
  return steps;
}

PlannedTime estimate_time(const std::vector<PlannedStep>& plan, int threads) {
  // Whether the pilot of a chain takes a second or an hour shows only when it has run for some time; of other laws the
  // first few piles tell enough.
  constexpr double all_chains = 8, longest_chain = 3, shortest_chain = 0.1, all_others = 4, longest_other = 0.3,
                   shortest_other = 0.004;  // seconds
  const auto is_chain = [](const PlannedStep& step) { return step.spec.sampler.law == Law::polytope; };
  auto chains = static_cast<double>(std::ranges::count_if(plan, is_chain));
  double left = all_chains;
  const auto is_other = [&](const PlannedStep& step) { return step.samples > 0 && !is_chain(step); };
  const auto others = static_cast<double>(std::ranges::count_if(plan, is_other));
  const double for_other = std::clamp(all_others / std::max(1.0, others), shortest_other, longest_other);
  PlannedTime planned;
  for (const PlannedStep& step : plan) {
    planned.seconds += step.parallel_seconds / threads + step.serial_seconds;
    if (step.samples == 0) continue;
    const double start = processor_seconds();
    const double share =
        is_chain(step) ? std::clamp(left / std::max(1.0, chains), shortest_chain, longest_chain) : for_other;
    const TimeEstimate one = estimate_time(step.spec, share);
    planned.seconds += one.on_threads(step.samples, threads);
    planned.at_least = planned.at_least || one.at_least;
    if (!is_chain(step)) continue;
    left -= processor_seconds() - start;
    chains -= 1;
  }
  return planned;
}

std::string in_words(const PlannedTime& time, int threads) {
  return fmt::format("roughly {}{} on {}, by a trial of the first piles", describe_duration(time.seconds),
                     time.at_least ? " or more" : "", threads == 1 ? "one thread" : fmt::format("{} threads", threads));
}

double memory_needed(const Experiment& experiment, const std::filesystem::path& run_folder, int threads) {
  double drawing = 0;
  const auto consider = [&](const PlannedEnsemble& planned) {
    if (!planned.reusable) drawing = std::max(drawing, drawing_memory(planned.spec));
  };
  for (const PlannedEnsemble& planned : plan_ensembles(experiment, run_folder)) consider(planned);
  for (const StudyEnsemble& one : experiment.studies.ensembles(experiment)) consider(plan_ensemble(one, run_folder));
  return drawing * threads + estimate_memory(experiment);
}

}  // namespace granuscope
