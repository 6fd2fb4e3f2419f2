#include "ensemble/ensemble_runner.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "ensemble/estimator.h"
#include "sampling/polytope.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

BlockSums empty_sums(const EnsembleSpec& spec, int first_block, int blocks) {
  BlockSums shapes;
  shapes.layers = recorded_layers(spec);
  shapes.rows = rows_of(spec.sampler.model, spec.lattice.angle);
  for (const QuantityShape& quantity : quantities_of(spec)) shapes.quantities[quantity.name].width = quantity.width;
  return zero_sums(shapes, first_block, static_cast<std::size_t>(blocks));
}

/// Groups between two looks for an interruption; enough for the laws that draw several side by side.
constexpr std::size_t groups_at_once = 2;

/// Samplers that wait for the next block: their memory is large, and the system takes long to hand it out anew.
class SamplerPool {
 public:
  explicit SamplerPool(const EnsembleSpec& spec) : spec_(spec) {}

  std::unique_ptr<Sampler> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) {
      auto sampler = make_sampler(spec_.sampler, Lattice(spec_.lattice));
      sampler->keep_layers(layers_to_keep(spec_));
      return sampler;
    }
    auto sampler = std::move(free_.back());
    free_.pop_back();
    return sampler;
  }
  void give_back(std::unique_ptr<Sampler> sampler) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(sampler));
  }

 private:
  const EnsembleSpec& spec_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Sampler>> free_;
};

}  // namespace

EnsembleRecord begin_ensemble(const EnsembleSpec& spec) { return begin_blocks(spec, 0, spec.response.blocks); }

EnsembleRecord begin_blocks(const EnsembleSpec& spec, int first, int blocks) {
  validate(spec);
  EnsembleRecord record;
  record.configuration = configuration_text(spec);
  record.configuration_key = cache_key(record.configuration);
  record.sampling_version = sampling_version;
  record.sums = empty_sums(spec, first, blocks);
  return record;
}

void require_shape(const std::filesystem::path& file, const EnsembleRecord& record, const EnsembleSpec& spec, int first,
                   int blocks) {
  const BlockSums wanted = empty_sums(spec, first, 0);
  const BlockSums& there = record.sums;
  bool same = there.layers == wanted.layers && there.rows == wanted.rows && there.first_block == first &&
              there.blocks() == blocks && there.quantities.size() == wanted.quantities.size();
  for (const auto& [name, quantity] : wanted.quantities) {
    const auto found = there.quantities.find(name);
    same = same && found != there.quantities.end() && found->second.width == quantity.width;
  }
  std::uint64_t counted = record.failed.size();
  for (std::size_t at = 0; same && at < there.count.size(); ++at) {
    same = there.count[at] <= samples_in_block(spec, first + static_cast<int>(at), groups_of(spec));
    counted += there.count[at];
  }
  // A command to be pasted into a shell: nothing but flags and numbers.
  same = same && std::ranges::all_of(record.failed, [](const FailedSample& one) {
           return one.replay.starts_with("granuscope sample ") && is_plain(one.replay, " .=+-_");
         });
  if (same && counted <= spec.response.samples) return;
  throw InputError(
      "'{}' holds other blocks, layers, quantities, samples or failures than its configuration says: it is damaged, or "
      "another program wrote it; make the file again",
      file.string());
}

SamplerSpec measured_sampler(const EnsembleSpec& spec) {
  return with_measured_chain(spec.sampler, Lattice(spec.lattice), top_load(spec));
}

void add_groups(const EnsembleSpec& spec, std::uint64_t from, std::uint64_t to, EnsembleRecord& record, int threads,
                Progress* progress) {
  add_groups(spec, measured_sampler(spec), from, to, record, threads, progress);
}

void add_groups(const EnsembleSpec& spec, const SamplerSpec& measured, std::uint64_t from, std::uint64_t to,
                EnsembleRecord& record, int threads, Progress* progress) {
  const std::size_t blocks = record.sums.count.size();
  const auto all_blocks = static_cast<std::uint64_t>(spec.response.blocks);
  EnsembleSpec drawn = spec;
  drawn.sampler = measured;
  std::vector<SamplerCounts> counts(blocks);
  std::vector<std::vector<FailedSample>> failed(blocks);
  SamplerPool samplers(drawn);
  const auto run_block = [&](std::size_t b) {
    const int block = record.sums.first_block + static_cast<int>(b);
    std::unique_ptr<Sampler> sampler = samplers.take();
    std::unique_ptr<Sampler> second = needs_two_samplers(drawn) ? samplers.take() : nullptr;
    const auto estimator = make_estimator(drawn, {*sampler, second ? *second : *sampler}, record.sums, block);
    std::vector<std::uint64_t> samples;
    std::vector<std::optional<SamplingFailure>> failures;
    for (std::uint64_t group = group_of_block(spec, block, from); group < to;) {
      samples.clear();
      for (std::size_t k = 0; k < groups_at_once && group < to; ++k, group += all_blocks) {
        const SampleRange range = samples_of(spec, group);
        for (std::uint64_t sample = range.first; sample < range.end; ++sample) samples.push_back(sample);
      }
      throw_if_interrupted();
      failures.assign(samples.size(), std::nullopt);
      estimator->measure_samples(samples, failures);
      for (std::size_t k = 0; k < samples.size(); ++k) {
        if (failures[k]) {
          failed[b].push_back({samples[k], failures[k]->layer, replay_command(spec, samples[k])});
        } else {
          ++record.sums.count[b];
        }
        if (progress != nullptr) progress->advance();
      }
    }
    counts[b] = sampler->take_counts();
    samplers.give_back(std::move(sampler));
    if (second) {
      counts[b] += second->take_counts();
      samplers.give_back(std::move(second));
    }
  };
  for_each_index(blocks, threads, run_block);

  for (std::size_t b = 0; b < blocks; ++b) {
    record.counts += counts[b];
    record.failed.insert(record.failed.end(), failed[b].begin(), failed[b].end());
  }
  std::ranges::sort(record.failed,
                    [](const FailedSample& one, const FailedSample& other) { return one.sample < other.sample; });
}

EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress) {
  EnsembleRecord record = begin_ensemble(spec);
  add_groups(spec, 0, groups_of(spec), record, threads, progress);
  return record;
}

namespace {

/// Whether this thread runs a body: what a body repeats it repeats alone, since the others are at work already.
thread_local bool inside_body = false;

}  // namespace

void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  // Threads without work would still be started, thousands of them in the worst case.
  const std::size_t wanted =
      inside_body ? 1 : std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(worker_count(threads)));

  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  const auto work = [&] {
    const bool was_inside = std::exchange(inside_body, true);
    try {
      for (std::size_t i = next++; i < count && !failed; i = next++) body(i);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
    inside_body = was_inside;
  };
  {
    std::vector<std::jthread> others;  // joined at the end of the block, also when one cannot be started
    others.reserve(wanted - 1);
    try {
      while (others.size() + 1 < wanted) others.emplace_back(work);
    } catch (...) {
      failed = true;
      throw;
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

void merge_into(EnsembleRecord& to, const EnsembleRecord& more) {
  const auto add = [](auto& numbers, const auto& others) {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] += others[i];
  };
  bool alike = to.sums.layers == more.sums.layers && to.sums.blocks() == more.sums.blocks() &&
               to.sums.quantities.size() == more.sums.quantities.size();
  for (const auto& [name, quantity] : to.sums.quantities) {
    const auto other = more.sums.quantities.find(name);
    alike = alike && other != more.sums.quantities.end() && other->second.width == quantity.width;
  }
  if (!alike) {
    throw InputError(
        "two ensembles of other layers, blocks or quantities cannot be added; draw them with one configuration");
  }
  add(to.sums.count, more.sums.count);
  for (auto& [name, quantity] : to.sums.quantities) {
    const QuantitySums& other = more.sums.quantities.at(name);
    add(quantity.sum, other.sum);
    add(quantity.sum_of_squares, other.sum_of_squares);
  }
  to.counts += more.counts;
  to.failed.insert(to.failed.end(), more.failed.begin(), more.failed.end());
}

namespace {

std::optional<SamplingFailure> replay_pair(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto sampler = make_sampler(spec.sampler, pile.lattice);
  const std::vector<double> uniform(static_cast<std::size_t>(pile.lattice.columns()), 1.0);
  Pile before(pile.lattice);
  if (const auto failure = sampler->draw(sample, uniform, before)) return failure;
  return sampler->draw_again(sample, top_load(spec), before, pile);
}

std::optional<SamplingFailure> replay_signs(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto sampler = make_sampler(spec.sampler, pile.lattice);
  std::vector<double> signs(static_cast<std::size_t>(pile.lattice.columns())), load(signs.size());
  draw_signs(spec, sample, signs);
  for (const double side : {1.0, -1.0}) {
    if (side < 0 && !spec.response.opposite) break;
    for (std::size_t i = 0; i < load.size(); ++i) load[i] = 1 + side * spec.response.epsilon * signs[i];
    if (const auto failure = sampler->draw(sample, load, pile)) return failure;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SamplingFailure> replay(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  switch (spec.response.estimator) {
    case EstimatorName::paired:
      return replay_pair(spec, sample, pile);
    case EstimatorName::multiplexed:
      return replay_signs(spec, sample, pile);
    case EstimatorName::point:
    case EstimatorName::fluctuation:
      break;
  }
  auto failure = make_sampler(spec.sampler, pile.lattice)
                     ->draw(numbers_of(spec, sample), top_load(spec, overloaded_bead(spec, sample)), pile);
  pile.sample = sample;  // whose load it has, whosever numbers
  return failure;
}

namespace {

/// Piles drawn side by side by the law that gains most from it, in whole groups.
constexpr std::uint64_t samples_at_once = 2 * group_size;
/// Beads of a trial under the law granusolve, for each second it is given.
constexpr double trial_beads_per_second = 5e6;
/// Of its piles: fewer cost more for each bead.
constexpr int fewest_layers = 32, fewest_columns = 64;
/// A trial shorter than this is not measured but noise.
constexpr double shortest_trial = 2e-3;
/// So many piles give the mean of an exponential distribution to a third.
constexpr std::uint64_t enough_piles = 8;
/// Tries per pile, or solutions per bead, of the first trial.
constexpr double first_tries = 64, first_effort = 16;

bool is_diluted(const EnsembleSpec& spec) { return spec.sampler.model.name == ModelName::diluted_beads; }

/// How the work of a sample grows with the beads. Diluted beads: measured from 192 to 432 of them.
double growth_of_work(const EnsembleSpec& spec) { return is_diluted(spec) ? 2.7 : 1; }

/// The ensemble with fewer layers, then fewer columns, where that changes nothing but the amount of work.
EnsembleSpec smaller(const EnsembleSpec& spec, double seconds) {
  if (spec.sampler.law != Law::granusolve) return spec;
  EnsembleSpec small = spec;
  if (is_diluted(spec)) {
    constexpr double most_beads = 192;  // some tenths of a second for eight piles
    const double beads = 1.0 * spec.lattice.columns * spec.lattice.layers, side = std::sqrt(most_beads / beads);
    if (side >= 1) return spec;
    small.lattice.columns = static_cast<int>(std::lround(side * spec.lattice.columns));
    small.lattice.layers = static_cast<int>(std::lround(side * spec.lattice.layers));
    small.layers = {0, small.lattice.layers - 1};
    small.response = on_ring(spec.response, small.lattice);
    return find_problem(small) ? spec : small;
  }
  const double beads = trial_beads_per_second * seconds / static_cast<double>(samples_at_once);
  const auto least = [&](int size, int other, int fewest) {
    return static_cast<int>(std::clamp(beads / other, 1.0 * std::min(fewest, size), 1.0 * size));
  };
  if (spec.response.estimator == EstimatorName::fluctuation) {  // what it records is no layer, but a lag
    const double enough = 2.0 * fluctuation_plan(spec).layers_needed;
    small.lattice.layers = least(spec.lattice.layers, spec.lattice.columns, static_cast<int>(enough));
  } else {
    small.lattice.layers = least(spec.lattice.layers, spec.lattice.columns, fewest_layers);
    // The same share of the layers is recorded.
    const double in_proportion = 1.0 * small.lattice.layers / spec.lattice.layers;
    const std::vector<int> recorded = recorded_layers(spec);
    const auto all = static_cast<double>(recorded.size());
    const auto kept = static_cast<std::size_t>(std::max(1.0, std::round(all * in_proportion)));
    small.layers.clear();
    for (std::size_t k = 0; k < kept; ++k) {
      const int layer = static_cast<int>(in_proportion * recorded[k * recorded.size() / kept]);
      if (small.layers.empty() || layer > small.layers.back()) small.layers.push_back(layer);
    }
  }
  if (!moves_loads(spec)) small.lattice.columns = least(spec.lattice.columns, small.lattice.layers, fewest_columns);
  small.response = on_ring(spec.response, small.lattice);
  return find_problem(small) ? spec : small;
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
  std::vector<std::uint64_t> samples(std::min(is_diluted(spec) ? group_size : samples_at_once, spec.response.samples));
  std::vector<std::optional<SamplingFailure>> failures(samples.size());
  Trial trial;
  for (std::uint64_t first = 0; first + samples.size() <= spec.response.samples; first += samples.size()) {
    throw_if_interrupted();
    std::iota(samples.begin(), samples.end(), first);
    std::ranges::fill(failures, std::nullopt);
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
  EnsembleSpec trial_spec = smaller(spec, seconds);
  const auto beads = [](const LatticeSpec& lattice) { return 1.0 * lattice.columns * lattice.layers; };
  const double in_proportion = std::pow(beads(spec.lattice) / beads(trial_spec.lattice), growth_of_work(spec));
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
