#include "sampling/eloy_clement.h"

#include <algorithm>

#include "sampling/fill_layer.h"
#include "sampling/random_key.h"
#include "support/interruption.h"

namespace granuscope {

EloyClementSampler::EloyClementSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      cone_(spec.mu),
      spec_(spec),
      max_solutions_(static_cast<std::uint64_t>(spec.effort * static_cast<double>(lattice.beads()))),
      failures_(static_cast<std::size_t>(lattice.layers())),
      attempts_(static_cast<std::size_t>(lattice.layers())) {}

std::optional<SamplingFailure> EloyClementSampler::draw(std::uint64_t sample, std::span<const double> load,
                                                        Pile& pile) {
  pile.mu = spec_.mu;
  pile.law = name_of(Law::eloy_clement);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  pile.load_line = load_line(spec_);
  pile.bead_weight = spec_.bead_weight;
  const RandomKey key(spec_.seed, sample);
  std::fill(failures_.begin(), failures_.end(), 0);
  std::fill(attempts_.begin(), attempts_.end(), 0);
  ++counts_.tries;
  std::uint64_t solutions = 0;
  for (int layer = 0; layer < lattice_.layers();) {
    const auto at = static_cast<std::size_t>(layer);
    throw_if_interrupted();
    if (solutions > max_solutions_ || attempts_[at] == most_tries) return SamplingFailure{layer};
    if (++attempts_[at] > 1) ++counts_.redrawn_layers;
    const std::uint64_t drawn_before = counts_.uniforms;
    const bool complete = fill_layer(cone_, layer, pile, [&](int bead, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(layer, bead, attempts_[at]).first);
    });
    solutions += counts_.uniforms - drawn_before + (complete ? 0 : 1);
    if (complete) {
      failures_[at] = 0;
      ++layer;
    } else {
      const int again = (++failures_[at] + failures_per_layer - 1) / failures_per_layer;
      layer = std::max(0, layer - again);
    }
  }
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

}  // namespace granuscope
