#include "ensemble/time_estimate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "sampling/chain_plan.h"
#include "support/interruption.h"
#include "support/processor_time.h"

namespace granuscope {
namespace {

/// Piles drawn side by side by the law that gains most from it, in whole groups.
constexpr std::uint64_t samples_at_once = 2 * group_size;
/// Beads of a trial under the law granusolve: those of sixteen piles of the default size.
constexpr double trial_beads = 1.6e6;
constexpr int fewest_layers = 32;
/// A trial shorter than this is not measured but noise.
constexpr double shortest_trial = 2e-3;
/// So many piles give the mean of an exponential distribution to a third.
constexpr std::uint64_t enough_piles = 8;
/// Tries per pile, or solutions per bead, of the first trial.
constexpr double first_tries = 64, first_effort = 16;

/// The ensemble with fewer layers where that changes nothing but the amount of work.
EnsembleSpec shallower(EnsembleSpec spec) {
  if (spec.sampler.law != Law::granusolve) return spec;
  if (spec.response.estimator == EstimatorName::fluctuation) return spec;  // what it records is no layer, but a lag
  const int deepest = spec.lattice.layers;
  const double wanted = trial_beads / static_cast<double>(samples_at_once) / spec.lattice.columns;
  spec.lattice.layers =
      static_cast<int>(std::clamp(wanted, std::min(1.0 * fewest_layers, 1.0 * deepest), 1.0 * deepest));
  // The same share of the layers is recorded.
  const double in_proportion = static_cast<double>(spec.lattice.layers) / deepest;
  const std::vector<int> recorded = recorded_layers(spec);
  const auto all = static_cast<double>(recorded.size());
  const auto kept = static_cast<std::size_t>(std::max(1.0, std::round(all * in_proportion)));
  spec.layers.clear();
  for (std::size_t k = 0; k < kept; ++k) {
    const int layer = static_cast<int>(in_proportion * recorded[k * recorded.size() / kept]);
    if (spec.layers.empty() || layer > spec.layers.back()) spec.layers.push_back(layer);
  }
  return spec;
}

/// At which a pile is given up, whatever the law counts.
double limit_of(const SamplerSpec& spec) {
  return spec.law == Law::rejection ? static_cast<double>(spec.max_tries) : spec.effort;
}

SamplerSpec with_limit(SamplerSpec spec, double limit) {
  if (spec.law == Law::rejection) spec.max_tries = static_cast<std::uint64_t>(limit);
  spec.effort = spec.law == Law::rejection ? spec.effort : limit;
  return spec;
}

struct Trial {
  double seconds = 0;
  std::uint64_t completed = 0, samples = 0;
};

/// Draws piles until there is something to measure. The first ones, which also fetch memory, count only if they take
/// long.
Trial draw_some(const EnsembleSpec& spec, double seconds) {
  EnsembleSpec smallest = spec;
  smallest.response.blocks = min_blocks;
  smallest.response.samples = group_size * min_blocks;
  EnsembleRecord record = begin_ensemble(smallest);
  const auto sampler = make_sampler(spec.sampler, Lattice(spec.lattice));
  sampler->keep_layers(layers_to_keep(spec));
  const auto second = needs_two_samplers(spec) ? make_sampler(spec.sampler, Lattice(spec.lattice)) : nullptr;
  const auto estimator = make_estimator(spec, {*sampler, second ? *second : *sampler}, record.sums, 0);
  std::vector<std::uint64_t> samples(std::min(samples_at_once, spec.response.samples));
  std::vector<std::optional<SamplingFailure>> failures(samples.size());
  Trial trial;
  for (std::uint64_t first = 0; first + samples.size() <= spec.response.samples; first += samples.size()) {
    throw_if_interrupted();
    std::iota(samples.begin(), samples.end(), first);
    std::fill(failures.begin(), failures.end(), std::nullopt);
    const double before = processor_seconds();
    estimator->measure_samples(samples, failures);
    if (first == samples.size() && trial.seconds < seconds / 4) trial = {};
    trial.seconds += processor_seconds() - before;
    trial.samples += samples.size();
    trial.completed += static_cast<std::uint64_t>(std::count(failures.begin(), failures.end(), std::nullopt));
    if (first > 0 && trial.seconds > shortest_trial) break;
    if (trial.seconds > seconds / 4) break;
  }
  return trial;
}

TimeEstimate estimate_time_of_chains(const EnsembleSpec& spec, double seconds) {
  const ChainForecast chain = estimate_chain_time(spec.sampler, Lattice(spec.lattice), top_load(spec), seconds);
  const ChainPlan& plan = chain.plan;
  const double sweeps_per_group =
      static_cast<double>(flat_sweeps + plan.burn_in) + static_cast<double>((group_size - 1) * plan.thinning);
  TimeEstimate estimate;
  estimate.once = chain.seconds_per_sweep * static_cast<double>(plan.pilot_sweeps);
  estimate.per_sample =
      chain.seconds_per_sweep * sweeps_per_group * piles_per_sample(spec) / static_cast<double>(group_size);
  estimate.at_least = !chain.known;
  return estimate;
}

}  // namespace

TimeEstimate estimate_time(const EnsembleSpec& spec, double seconds) {
  if (spec.sampler.law == Law::polytope && spec.sampler.mu > 0) return estimate_time_of_chains(spec, seconds);
  EnsembleSpec trial_spec = shallower(spec);
  const double in_proportion = static_cast<double>(spec.lattice.layers) / trial_spec.lattice.layers;
  const double full = limit_of(spec.sampler), start = processor_seconds();
  double limit = std::min(full, spec.sampler.law == Law::rejection ? first_tries : first_effort);
  for (;; limit = std::min(full, 2 * limit)) {
    trial_spec.sampler = with_limit(spec.sampler, limit);
    const Trial trial = draw_some(trial_spec, seconds);
    const bool time_is_up = processor_seconds() - start > seconds;
    const bool enough = limit >= full || trial.completed >= std::min(enough_piles, trial.samples);
    if (!enough && !time_is_up) continue;
    const auto samples = static_cast<double>(trial.samples), completed = static_cast<double>(trial.completed);
    // Given up after `limit`, tries that forget what was before take on average all time over the piles completed, or
    // more than all if there is none; and no pile takes longer than up to the full limit.
    const double mean = trial.seconds / std::max(1.0, completed), longest = trial.seconds / samples * full / limit;
    TimeEstimate estimate;
    estimate.per_sample = in_proportion * std::min(mean, longest);
    estimate.at_least = trial.completed == 0 && mean < longest;
    return estimate;
  }
}

}  // namespace granuscope
