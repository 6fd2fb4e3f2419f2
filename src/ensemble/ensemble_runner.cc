#include "ensemble/ensemble_runner.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "ensemble/estimator.h"
#include "ensemble/merge.h"
#include "ensemble/parallel.h"
#include "sampling/chain_plan.h"
#include "support/digest.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

BlockSums empty_sums(const EnsembleSpec& spec, int first_block, int blocks) {
  BlockSums shapes;
  shapes.layers = recorded_layers(spec);
  shapes.rows = rows_of(spec.sampler.model);
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
  std::sort(record.failed.begin(), record.failed.end(),
            [](const FailedSample& one, const FailedSample& other) { return one.sample < other.sample; });
}

EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress) {
  EnsembleRecord record = begin_ensemble(spec);
  add_groups(spec, 0, groups_of(spec), record, threads, progress);
  return record;
}

}  // namespace granuscope
