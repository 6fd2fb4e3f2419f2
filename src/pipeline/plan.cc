// What a run would do, foretold without doing it.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "analysis/precision.h"
#include "ensemble/estimator.h"
#include "experiment/experiment_check.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/pipeline.h"
#include "pipeline/side_stage.h"
#include "sampling/sampler.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

const char* kind_of(const EnsembleSpec& spec) { return piles_per_sample(spec) == 2 ? "pairs of piles" : "piles"; }

/// How far an ensemble would still have to grow: from the errors of what is there, or else from those to be expected.
PlannedStep plan_growth(const Experiment& experiment, const RunOptions& options, PlannedEnsemble planned) {
  const PrecisionSpec& asked = experiment.precision;
  const EnsembleSpec& spec = planned.spec;
  const bool multiplexed = spec.estimator == EstimatorName::multiplexed;
  Transport errors;
  const ExpectedErrors expected =
      expected_errors(spec.sampler.mu, multiplexed, multiplexed ? spec.epsilon : spec.overload, spec.lattice.columns,
                      spec.opposite ? worth_of_opposite_pair * spec.samples : spec.samples);
  errors.c = {0.5, expected.c, ""};
  errors.D = {0.1, expected.D, ""};
  const std::optional<MeasuredEnsemble> ensemble = reuse_ensemble(planned, options.folder);
  const bool there = ensemble.has_value();
  if (there) errors = measure_transport(*ensemble, experiment.fit, {}, options.threads).transport;
  const PrecisionLook look = look_at_precision(asked, errors, spec.samples);
  std::uint64_t rounds = spec.samples / (group_size * static_cast<std::uint64_t>(spec.blocks)), samples = spec.samples;
  while (!look.hopeless && static_cast<double>(samples) < look.samples_needed) {
    rounds = next_size(rounds);
    const std::uint64_t next = rounds * group_size * static_cast<std::uint64_t>(spec.blocks);
    if (next > asked.most_samples) break;
    samples = next;
  }
  const bool enough = look.hopeless || static_cast<double>(samples) >= look.samples_needed;
  const std::uint64_t drawn = there ? spec.samples : 0;
  std::string what = fmt::format("about {} {}, {}, for the precision asked ({})", samples, kind_of(spec), planned.label,
                                 there ? "by the errors so far" : "by a rule of thumb");
  if (there) what += fmt::format(", {} of them there already", drawn);
  if (!enough) what += fmt::format("; about {} would be needed", significant(look.samples_needed, 2));
  if (!planned.replaces.empty()) what += fmt::format("; replaces the file there: {}", planned.replaces);
  return {Stage::sample, what, samples == drawn, beads_of(spec, samples - drawn)};
}

}  // namespace

std::vector<PlannedStep> plan_run(const Experiment& experiment, const RunOptions& options) {
  const std::set<Stage> needed = stages_needed(options.only);
  std::vector<PlannedStep> steps;
  if (needed.contains(Stage::sample)) {
    const auto add = [&](const PlannedEnsemble& planned) {
      if (planned.grows_from > 0) {
        steps.push_back(plan_growth(experiment, options, planned));
        return;
      }
      const std::uint64_t begun =
          std::min(planned.spec.samples, planned.begun * group_size * static_cast<std::uint64_t>(planned.spec.blocks));
      const std::uint64_t beads = beads_of(planned.spec, planned.spec.samples - begun);
      const std::string continued = begun == 0 ? "" : fmt::format(", {} of them there already", begun);
      const std::string replaces =
          planned.replaces.empty() ? "" : fmt::format("; replaces the file there: {}", planned.replaces);
      steps.push_back({Stage::sample,
                       fmt::format("{} {}, {}{}{}", planned.spec.samples, kind_of(planned.spec), planned.label,
                                   continued, replaces),
                       planned.reusable, planned.reusable ? 0 : beads});
    };
    for (const PlannedEnsemble& planned : plan_ensembles(experiment, options.folder)) add(planned);
    for (const SideEnsemble& side : plan_side_ensembles(experiment, options.folder)) add(side.planned);
  }
  if (needed.contains(Stage::analyse)) {
    steps.push_back({Stage::analyse, fmt::format("fits at {} friction coefficients", experiment.mu.size()), false, 0});
  }
  if (needed.contains(Stage::render) && experiment.force_chains.draw) {
    steps.push_back({Stage::render, "force chains", false,
                     static_cast<std::uint64_t>(experiment.force_chains.columns) *
                         static_cast<std::uint64_t>(experiment.force_chains.computed_layers())});
  }
  if (needed.contains(Stage::plot)) steps.push_back({Stage::plot, "figures", false, 0});
  if (needed.contains(Stage::report)) steps.push_back({Stage::report, "report", false, 0});
  return steps;
}

double memory_needed(const Experiment& experiment, int threads) {
  double drawing = 0;
  const auto consider = [&](const PlannedEnsemble& planned) {
    drawing = std::max(drawing, drawing_memory(planned.spec));
  };
  for (const PlannedEnsemble& planned : plan_ensembles(experiment, {})) consider(planned);
  for (const SideEnsemble& side : plan_side_ensembles(experiment, {})) consider(side.planned);
  return drawing * threads + estimate_memory(experiment);
}

}  // namespace granuscope
