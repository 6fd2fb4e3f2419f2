#include "ensemble/ensemble_runner.h"

#include <algorithm>
#include <array>

#include "ensemble/estimator.h"
#include "ensemble/merge.h"
#include "ensemble/parallel.h"
#include "sampling/chain_plan.h"
#include "support/digest.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

BlockSums empty_sums(const EnsembleSpec& spec) {
  BlockSums sums;
  sums.layers = recorded_layers(spec);
  sums.count.assign(static_cast<std::size_t>(spec.blocks), 0);
  for (const QuantityShape& quantity : quantities_of(spec)) {
    const std::size_t size = sums.count.size() * sums.layers.size() * static_cast<std::size_t>(quantity.width);
    sums.quantities[quantity.name] = {quantity.width, std::vector<double>(size), std::vector<double>(size)};
  }
  return sums;
}

}  // namespace

EnsembleRecord begin_ensemble(const EnsembleSpec& spec) {
  validate(spec);
  EnsembleRecord record;
  record.configuration = configuration_text(spec);
  record.configuration_key = cache_key(record.configuration);
  record.sampling_version = sampling_version;
  record.sums = empty_sums(spec);
  return record;
}

void add_groups(const EnsembleSpec& spec, std::uint64_t from, std::uint64_t to, EnsembleRecord& record, int threads,
                Progress* progress) {
  const auto blocks = static_cast<std::size_t>(spec.blocks);
  // Burn-in and thinning of a chain are measured once for all blocks.
  EnsembleSpec drawn = spec;
  drawn.sampler = with_measured_chain(spec.sampler, Lattice(spec.lattice), top_load(spec));
  std::vector<SamplerCounts> counts(blocks);
  std::vector<std::vector<FailedSample>> failed(blocks);
  const auto run_block = [&](std::size_t b) {
    const auto block = static_cast<int>(b);
    const auto estimator = make_estimator(drawn, record.sums, block);
    std::array<std::optional<SamplingFailure>, group_size> failures;
    for (std::uint64_t group = from; group < to; ++group) {
      const SampleRange samples = samples_of(spec, block, group);
      if (samples.empty()) break;
      throw_if_interrupted();
      const auto in_group = static_cast<std::size_t>(samples.end - samples.first);
      estimator->measure_group(samples.first, {failures.data(), in_group});
      for (std::size_t k = 0; k < in_group; ++k) {
        if (failures[k]) {
          failed[b].push_back({samples.first + k, failures[k]->layer, replay_command(spec, samples.first + k)});
        } else {
          ++record.sums.count[b];
        }
        if (progress != nullptr) progress->advance();
      }
    }
    counts[b] = estimator->counts();
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
  add_groups(spec, 0, groups_per_block(spec), record, threads, progress);
  return record;
}

}  // namespace granuscope
