#include "ensemble/ensemble_runner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "ensemble/parallel.h"
#include "model/identities.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/digest.h"
#include "support/error.h"
#include "support/interruption.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

std::uint64_t groups_of(std::uint64_t samples) { return samples / group_size + (samples % group_size != 0 ? 1 : 0); }

/// First sample of a block; blocks hold whole groups and differ by at most one group.
std::uint64_t first_sample_of(const EnsembleSpec& spec, int block) {
  const std::uint64_t groups = groups_of(spec.samples);
  const std::uint64_t first = groups * static_cast<std::uint64_t>(block) / static_cast<std::uint64_t>(spec.blocks);
  return std::min(first * group_size, spec.samples);
}

std::vector<int> recorded_layers(const EnsembleSpec& spec) {
  if (!spec.layers.empty()) return spec.layers;
  std::vector<int> all(static_cast<std::size_t>(spec.lattice.layers));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Where one block's sums of one quantity stand.
struct BlockView {
  double* sum;
  double* sum_of_squares;
  void add(std::size_t at, double value) const {
    sum[at] += value;
    sum_of_squares[at] += value * value;
  }
};

BlockView block_view(BlockSums& sums, const std::string& quantity, int block) {
  QuantitySums& q = sums.quantities.at(quantity);
  const std::size_t offset = static_cast<std::size_t>(block) * sums.layers.size() * static_cast<std::size_t>(q.width);
  return {q.sum.data() + offset, q.sum_of_squares.data() + offset};
}

/// Adds one pile to a block.
class BlockAccumulator {
 public:
  BlockAccumulator(BlockSums& sums, int block, bool profiles)
      : layers_(sums.layers),
        count_(sums.count[static_cast<std::size_t>(block)]),
        thrust_(block_view(sums, "thrust", block)),
        variance_(block_view(sums, "weight_variance", block)),
        weight_(profiles ? block_view(sums, "weight", block) : BlockView{nullptr, nullptr}) {}

  void add(const Pile& pile) {
    const auto columns = static_cast<std::size_t>(pile.lattice.columns());
    const double total_load = std::accumulate(pile.load.begin(), pile.load.end(), 0.0);
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      const std::size_t row = pile.lattice.index(layers_[l], 0);
      double thrust = 0, variance = 0;
      for (std::size_t i = 0; i < columns; ++i) {
        const double w = pile.V_R[row + i] + pile.V_L[row + i];
        thrust += pile.H_R[row + i] - pile.H_L[row + i];
        variance += (w - 1) * (w - 1);
        if (weight_.sum != nullptr) weight_.add(l * columns + i, w);
      }
      thrust_.add(l, sqrt3 * thrust / total_load);
      variance_.add(l, variance / static_cast<double>(columns));
    }
    ++count_;
  }

 private:
  const std::vector<int>& layers_;
  std::uint64_t& count_;
  BlockView thrust_, variance_, weight_;
};

void add_counts(SamplerCounts& to, const SamplerCounts& from) {
  to.beads += from.beads;
  to.uniforms += from.uniforms;
  to.tries += from.tries;
  to.mended_by_pair += from.mended_by_pair;
  to.mended_by_arc += from.mended_by_arc;
  to.mended_by_ring += from.mended_by_ring;
  to.climbed += from.climbed;
  to.pairs += from.pairs;
  to.arcs += from.arcs;
  to.rings += from.rings;
  to.climbs += from.climbs;
  to.rounded += from.rounded;
}

}  // namespace

std::string name_of(Load load) { return load == Load::uniform ? "uniform" : "point"; }

Load load_named(const std::string& name) {
  for (Load load : {Load::uniform, Load::point}) {
    if (name_of(load) == name) return load;
  }
  throw InputError(fmt::format("there is no load \"{}\": known are uniform and point", name));
}

void validate(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  if (spec.blocks < min_blocks) {
    throw InputError(
        fmt::format("{} blocks are too few: a jackknife over fewer than {} blocks gives no usable standard "
                    "error",
                    spec.blocks, min_blocks));
  }
  if (groups_of(spec.samples) < static_cast<std::uint64_t>(spec.blocks)) {
    throw InputError(fmt::format(
        "{} samples are too few: each of the {} blocks needs at least one group of {} samples; ask for {} or more",
        spec.samples, spec.blocks, group_size, (static_cast<std::uint64_t>(spec.blocks) - 1) * group_size + 1));
  }
  if (spec.samples > max_samples) {
    throw InputError(
        fmt::format("{} samples are too many: one seed names {}; ask for fewer, or divide them among seeds",
                    spec.samples, max_samples));
  }
  if (!(spec.overload > 0) || !std::isfinite(spec.overload)) {
    throw InputError(fmt::format("overload {} is not a positive finite force: there would be no response to measure",
                                 spec.overload));
  }
  if (std::adjacent_find(spec.layers.begin(), spec.layers.end(), std::greater_equal<>()) != spec.layers.end()) {
    throw InputError("the recorded layers are not ascending: each may be named once, from the top down");
  }
  for (int layer : spec.layers) {
    if (layer < 0 || layer >= lattice.layers()) {
      throw InputError(fmt::format("layer {} is outside the lattice of {} layers (0 to {})", layer, lattice.layers(),
                                   lattice.layers() - 1));
    }
  }
}

std::string configuration_text(const EnsembleSpec& spec) {
  const SamplerSpec& s = spec.sampler;
  return fmt::format(
      "sampling_version={}\nlaw={}\nmu={}\nseed={}\neffort={}\nmax_tries={}\norder={}\ncolumns={}\nlayers={}\nload={}\n"
      "overload={}\nsamples={}\nblocks={}\nrecorded_layers={}\nprofiles={}\n",
      sampling_version, name_of(s.law), exact(s.mu), s.seed, exact(s.effort), s.max_tries, name_of(s.order),
      spec.lattice.columns, spec.lattice.layers, name_of(spec.load),
      spec.load == Load::point ? exact(spec.overload) : "0", spec.samples, spec.blocks,
      fmt::join(recorded_layers(spec), ","), spec.record_profiles);
}

std::vector<double> top_load(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  if (spec.load == Load::point) load[static_cast<std::size_t>(lattice.middle())] += spec.overload;
  return load;
}

std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample) {
  std::string command =
      fmt::format("granuscope sample --law {} --mu {} --columns {} --layers {} --load {}", name_of(spec.sampler.law),
                  exact(spec.sampler.mu), spec.lattice.columns, spec.lattice.layers, name_of(spec.load));
  if (spec.load == Load::point && spec.overload != 1.0) command += fmt::format(" --overload {}", exact(spec.overload));
  if (spec.sampler.effort != SamplerSpec{}.effort) command += fmt::format(" --effort {}", exact(spec.sampler.effort));
  if (spec.sampler.max_tries != SamplerSpec{}.max_tries)
    command += fmt::format(" --max-tries {}", spec.sampler.max_tries);
  if (spec.sampler.order != SamplerSpec{}.order) command += " --layer-order " + name_of(spec.sampler.order);
  return command + fmt::format(" --seed {} --sample {} --out pile.h5", spec.sampler.seed, sample);
}

EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress) {
  validate(spec);
  const Lattice lattice(spec.lattice);
  const std::vector<double> load = top_load(spec);
  const auto blocks = static_cast<std::size_t>(spec.blocks);

  EnsembleRecord record;
  record.configuration = configuration_text(spec);
  record.configuration_key = cache_key(record.configuration);
  record.sampling_version = sampling_version;
  record.sums.layers = recorded_layers(spec);
  record.sums.count.assign(blocks, 0);
  const auto add_quantity = [&](const char* name, int width) {
    const std::size_t size = blocks * record.sums.layers.size() * static_cast<std::size_t>(width);
    record.sums.quantities[name] = {width, std::vector<double>(size), std::vector<double>(size)};
  };
  add_quantity("thrust", 1);
  add_quantity("weight_variance", 1);
  if (spec.record_profiles) add_quantity("weight", lattice.columns());

  std::vector<SamplerCounts> counts(blocks);
  std::vector<std::vector<FailedSample>> failed(blocks);
  const auto run_block = [&](std::size_t b) {
    const auto block = static_cast<int>(b);
    const auto sampler = make_sampler(spec.sampler, lattice);
    Pile pile(lattice);
    BlockAccumulator accumulator(record.sums, block, spec.record_profiles);
    const std::uint64_t end = first_sample_of(spec, block + 1);
    for (std::uint64_t sample = first_sample_of(spec, block); sample < end; ++sample) {
      throw_if_interrupted();
      if (const auto failure = sampler->draw(sample, load, pile)) {
        failed[b].push_back({sample, failure->layer, replay_command(spec, sample)});
      } else {
        assert_identities(pile);
        accumulator.add(pile);
      }
      if (progress != nullptr) progress->advance();
    }
    counts[b] = sampler->counts();
  };
  for_each_index(blocks, threads, run_block);

  for (std::size_t b = 0; b < blocks; ++b) {
    add_counts(record.counts, counts[b]);
    record.failed.insert(record.failed.end(), failed[b].begin(), failed[b].end());
  }
  return record;
}

}  // namespace granuscope
