#include "ensemble/ensemble_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "ensemble/fluctuation_estimator.h"
#include "sampling/random_key.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
std::string name_of(Load load) { return load == Load::uniform ? "uniform" : "point"; }

Load load_named(const std::string& name) {
  for (Load load : {Load::uniform, Load::point}) {
    if (name_of(load) == name) return load;
  }
  throw InputError(fmt::format("there is no load \"{}\": known are uniform and point", name));
}

SampleRange samples_of(const EnsembleSpec& spec, std::uint64_t group) {
  const auto from = [&](std::uint64_t number) { return std::min(number * group_size, spec.response.samples); };
  return {from(group), from(group + 1)};
}

std::uint64_t groups_of(const EnsembleSpec& spec) {
  return spec.response.samples / group_size + (spec.response.samples % group_size != 0 ? 1 : 0);
}

std::uint64_t group_of_block(const EnsembleSpec& spec, int block, std::uint64_t from) {
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks), at = static_cast<std::uint64_t>(block);
  return from + (at + blocks - from % blocks) % blocks;
}

std::uint64_t samples_in_block(const EnsembleSpec& spec, int block, std::uint64_t groups) {
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks);
  std::uint64_t samples = 0;
  for (std::uint64_t group = group_of_block(spec, block, 0); group < groups; group += blocks)
    samples += samples_of(spec, group).size();
  return samples;
}

std::vector<int> recorded_layers(const EnsembleSpec& spec) {
  std::vector<int> layers = spec.layers;
  if (layers.empty()) {
    layers.resize(static_cast<std::size_t>(spec.lattice.layers));
    std::iota(layers.begin(), layers.end(), 0);
  } else if (!loads_one_bead(spec.response.estimator) && layers.front() != 0) {
    layers.insert(layers.begin(), 0);
  }
  return layers;
}

namespace {

Problem find_fluctuation_problem(const EnsembleSpec& spec) {
  if (auto found = find_gravity_problem(spec.sampler, spec.response)) return found;
  const FluctuationPlan plan = fluctuation_plan(spec);
  if (plan.lags.size() < 2) return problem("layers", "there is no lag to measure; name layers beside layer 0");
  if (!plan.bases.empty()) return {};
  const int unused = bottom_margin_of(spec.sampler.model);
  return problem(
      "layers",
      "{} layers are too few for the estimator fluctuation: {} of saturated fluctuations, a reference of {}, "
      "{} of response and {} at the bottom need {}; each base beyond the first one takes {} more",
      spec.lattice.layers, plan.layers_needed - plan.reference - plan.lags.back() - unused - 1, plan.reference,
      plan.lags.back(), unused + 1, plan.layers_needed, spec.response.base_step);
}

/// What of the estimators makes no sense with a model other than the beads.
Problem find_model_problem(const EnsembleSpec& spec) {
  const ModelSpec& model = spec.sampler.model;
  if (model.is_beads()) return {};
  if (auto found = find_problem(model, spec.lattice)) return found;
  const EstimatorName estimator = spec.response.estimator;
  if (estimator == EstimatorName::paired) {
    return problem(
        "estimator",
        "the estimator paired keeps the split of each bead, which the model {} does not have; choose another",
        name_of(model.name));
  }
  if (estimator == EstimatorName::fluctuation && model.has_contacts()) {
    return problem("estimator",
                   "the estimator fluctuation averages over layers of deep piles that are alike, while those of {} are "
                   "small and solved as a whole; choose point or multiplexed",
                   name_of(model.name));
  }
  return {};
}

}  // namespace

Problem find_gravity_problem(const SamplerSpec& sampler, const ResponseSpec& response) {
  if (sampler.bead_weight == 0 || response.estimator != EstimatorName::fluctuation) return {};
  return problem("estimator",
                 "the estimator fluctuation averages over layers that are alike, which those of beads of weight {} are "
                 "not: their mean weight grows with depth; choose point, paired or multiplexed",
                 sampler.bead_weight);
}

Problem find_problem(const EnsembleSpec& spec) {
  if (auto found = find_problem(spec.lattice)) return found;
  if (auto found = find_problem(spec.sampler)) return found;
  if (auto found = find_problem(spec.response, spec.lattice)) return found;
  if (auto found = find_model_problem(spec)) return found;
  const EstimatorName estimator = spec.response.estimator;
  if (estimator != EstimatorName::point && spec.load != Load::point) {
    return problem("load", "the estimator {} brings its own loads; leave the load at point", name_of(estimator));
  }
  if (spec.record_H && (estimator != EstimatorName::multiplexed || is_scalar(spec.sampler.model))) {
    return problem("record_H", "the response of H is recorded by the estimator multiplexed, of models that have an H");
  }
  if (std::adjacent_find(spec.layers.begin(), spec.layers.end(), std::greater_equal<>()) != spec.layers.end()) {
    return problem("layers", "the recorded layers are not ascending: each may be named once, from the top down");
  }
  for (const int layer : spec.layers) {
    if (layer < 0 || layer >= spec.lattice.layers) {
      return problem("layers", "layer {} is outside the lattice of {} layers (0 to {})", layer, spec.lattice.layers,
                     spec.lattice.layers - 1);
    }
  }
  if (estimator == EstimatorName::fluctuation) return find_fluctuation_problem(spec);
  return {};
}

void validate(const EnsembleSpec& spec) { refuse(find_problem(spec)); }

std::string configuration_text(const EnsembleSpec& spec) {
  const auto& [sampler, lattice, response, load, layers, record_profiles, record_H] = spec;
  const bool multiplexed = response.estimator == EstimatorName::multiplexed;
  const bool overloaded = loads_one_bead(response.estimator) && load == Load::point;
  std::string text;
  const auto add = [&](const char* key, const auto& value) { text += fmt::format("{}={}\n", key, value); };
  add("sampling_version", sampling_version);
  text += configuration_text(sampler.model);
  add("law", name_of(sampler.law));
  add("mu", exact(sampler.mu));
  add("seed", sampler.seed);
  if (sampler.load_angle != 0) add("load_angle", exact(sampler.load_angle));
  if (sampler.load_offset != 0) add("load_offset", exact(sampler.load_offset));
  if (sampler.bead_weight != 0) add("bead_weight", exact(sampler.bead_weight));
  add("effort", exact(sampler.effort));
  add("max_tries", sampler.max_tries);
  add("layer_order", name_of(sampler.order));
  add("repair_rules", name_of(sampler.rules));
  add("lambda", exact(sampler.lambda));
  add("burn_in", sampler.burn_in);
  add("thinning", sampler.thinning);
  add("columns", lattice.columns);
  add("layers", lattice.layers);
  add("load", name_of(load));
  add("estimator", name_of(response.estimator));
  // What an estimator does not use changes no number.
  add("overload", overloaded ? exact(response.overload) : "0");
  add("epsilon", multiplexed ? exact(response.epsilon) : "0");
  add("opposite", response.opposite);
  add("sign_run", response.sign_run);
  if (response.estimator == EstimatorName::fluctuation) {
    add("reference_lag", response.reference_lag);
    add("first_base", response.first_base);
    add("base_step", response.base_step);
  }
  // Files of before hold no forces of redrawn beads.
  if (response.estimator == EstimatorName::paired) add("paired_sums", 3);
  // Files of before hold no response of H.
  if (record_H) add("multiplexed_sums", 2);
  add("samples", response.samples);
  add("blocks", response.blocks);
  add("recorded_layers", fmt::format("{}", fmt::join(recorded_layers(spec), ",")));
  add("profiles", record_profiles);
  return text;
}

std::vector<double> top_load(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  if (spec.load == Load::point && loads_one_bead(spec.response.estimator))
    load[static_cast<std::size_t>(lattice.middle())] += spec.response.overload;
  return load;
}

namespace {

/// Of the models whose piles can fail.
std::string flags_of_model(const SamplerSpec& sampler) {
  if (sampler.model.is_beads()) return "--law " + name_of(sampler.law);
  const DilutedBeadsSpec& diluted = sampler.model.diluted_beads;
  return fmt::format("--model {} --opened-share {} --least-slack {}", name_of(sampler.model.name), exact(diluted.share),
                     exact(diluted.least_slack));
}

}  // namespace

std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample) {
  const EstimatorName estimator = spec.response.estimator;
  const bool multiplexed = estimator == EstimatorName::multiplexed;
  const std::string load = estimator == EstimatorName::point         ? name_of(spec.load)
                           : estimator == EstimatorName::fluctuation ? name_of(Load::uniform)
                                                                     : name_of(estimator);
  std::string command =
      fmt::format("granuscope sample {} --mu {} --columns {} --layers {} --load {}", flags_of_model(spec.sampler),
                  exact(spec.sampler.mu), spec.lattice.columns, spec.lattice.layers, load);
  if (multiplexed) command += fmt::format(" --epsilon {}", exact(spec.response.epsilon));
  if (spec.response.opposite) command += " --opposite";
  if (spec.response.sign_run != 1) command += fmt::format(" --sign-run {}", spec.response.sign_run);
  if (loads_one_bead(estimator) && spec.load == Load::point && spec.response.overload != 1.0)
    command += fmt::format(" --overload {}", exact(spec.response.overload));
  if (spec.sampler.load_angle != 0) command += fmt::format(" --load-angle={}", exact(spec.sampler.load_angle));
  if (spec.sampler.load_offset != 0) command += fmt::format(" --load-offset={}", exact(spec.sampler.load_offset));
  if (spec.sampler.bead_weight != 0) command += fmt::format(" --bead-weight {}", exact(spec.sampler.bead_weight));
  if (spec.sampler.effort != SamplerSpec{}.effort) command += fmt::format(" --effort {}", exact(spec.sampler.effort));
  if (spec.sampler.max_tries != SamplerSpec{}.max_tries)
    command += fmt::format(" --max-tries {}", spec.sampler.max_tries);
  if (spec.sampler.law == Law::polytope) {
    command += fmt::format(" --lambda {}", exact(spec.sampler.lambda));
    if (spec.sampler.burn_in > 0) command += fmt::format(" --burn-in {}", spec.sampler.burn_in);
    if (spec.sampler.thinning > 0) command += fmt::format(" --thinning {}", spec.sampler.thinning);
  }
  if (spec.sampler.rules != SamplerSpec{}.rules) command += " --repair-rules " + name_of(spec.sampler.rules);
  if (spec.sampler.order != SamplerSpec{}.order) command += " --layer-order " + name_of(spec.sampler.order);
  return command + fmt::format(" --seed {} --sample {} --out pile.h5", spec.sampler.seed, sample);
}

int longest_run(const LatticeSpec& lattice) { return std::max(1, lattice.columns / 8); }

Problem find_problem(const ResponseSpec& spec, const LatticeSpec& lattice) {
  if (!(spec.epsilon >= least_epsilon && spec.epsilon < epsilon_limit)) {
    return problem(
        "epsilon",
        "{} cannot be measured: some top beads carry 1 - epsilon, and one without load has no solution beside "
        "loaded ones at small friction, while the response is divided by epsilon; give {} to less than {} "
        "(0.25 is usual)",
        spec.epsilon, least_epsilon, epsilon_limit);
  }
  if (spec.estimator != EstimatorName::multiplexed && (spec.opposite || spec.sign_run != ResponseSpec{}.sign_run)) {
    return problem(spec.opposite ? "opposite" : "sign_run",
                   "it belongs to the estimator multiplexed and would change nothing under {}; leave it out, or "
                   "choose that estimator",
                   name_of(spec.estimator));
  }
  const ResponseSpec usual;
  if (spec.estimator != EstimatorName::fluctuation &&
      (spec.reference_lag != usual.reference_lag || spec.first_base != usual.first_base ||
       spec.base_step != usual.base_step)) {
    return problem(spec.reference_lag != usual.reference_lag ? "reference_lag"
                   : spec.first_base != usual.first_base     ? "first_base"
                                                             : "base_step",
                   "it belongs to the estimator fluctuation and would change nothing under {}; leave it out, or choose "
                   "that estimator",
                   name_of(spec.estimator));
  }
  if (spec.reference_lag < 0 || spec.reference_lag > most_reference_lag) {
    return problem("reference_lag",
                   "{} layers cannot be measured; give 0 to {} (24 is usual, fewer than 12 are biased)",
                   spec.reference_lag, most_reference_lag);
  }
  if (spec.first_base < 0 || spec.first_base > most_first_base) {
    return problem("first_base", "layer {} is no base; give 0 (where the fluctuations are saturated) to {}",
                   spec.first_base, most_first_base);
  }
  if (spec.base_step < 1 || spec.base_step > most_base_step) {
    return problem("base_step", "{} layers between two bases; give 1 to {} (6 is usual)", spec.base_step,
                   most_base_step);
  }
  if (spec.sign_run < 1 || spec.sign_run > longest_run(lattice)) {
    return problem(
        "sign_run",
        "{} beads: a run has at least one, and where fewer than eight runs fit into a ring of {} columns the "
        "long waves meet hardly any load that differs; give 1 to {} (1 to 3 is usual)",
        spec.sign_run, lattice.columns, longest_run(lattice));
  }
  if (!(std::isfinite(spec.overload) && spec.overload >= least_overload && spec.overload <= most_overload)) {
    return problem("overload",
                   "{} cannot be measured: the response is divided by the overload, and the load "
                   "of its neighbours is 1; give {} to {} (the paper has 1)",
                   spec.overload, least_overload, most_overload);
  }
  if (spec.blocks < min_blocks || spec.blocks > most_blocks) {
    return problem("blocks",
                   "{} blocks: fewer than {} give no reliable standard error, and more than {} no "
                   "better one; give {} to {} (32 is usual)",
                   spec.blocks, min_blocks, most_blocks, min_blocks, most_blocks);
  }
  const std::uint64_t least = group_size * static_cast<std::uint64_t>(spec.blocks - 1) + 1;
  if (spec.samples > most_samples) {
    return problem("samples", "{} samples are too many; give {} to {}, or divide them among seeds", spec.samples, least,
                   most_samples);
  }
  if (spec.samples < least) {
    return problem("samples",
                   "{} samples are too few: each of the {} blocks needs at least one group of {}; give {} or more",
                   spec.samples, spec.blocks, group_size, least);
  }
  return {};
}

}  // namespace granuscope
