#include "sampling/rejection.h"

#include "sampling/fill_layer.h"
#include "sampling/random_key.h"
#include "sampling/split_uniforms.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

/// Fills the pile with the splits H_R = choose_split(layer, bead, forces, interval); the layer of the first bead
/// without a solution, or -1.
template <typename ChooseSplit>
int try_pile(const FrictionCone& cone, Pile& pile, ChooseSplit choose_split) {
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    const auto choose = [&](int i, Outgoing out, Interval interval) { return choose_split(n, i, out, interval); };
    if (!fill_layer(cone, n, pile, choose)) return n;
  }
  return -1;
}

}  // namespace

RejectionSampler::RejectionSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), cone_(spec.mu), spec_(spec) {}

void RejectionSampler::begin_pile(std::uint64_t sample, std::span<const double> load, Pile& pile) const {
  pile.mu = spec_.mu;
  pile.law = name_of(Law::rejection);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  pile.load_line = load_line(spec_);
  pile.bead_weight = spec_.bead_weight;
}

std::optional<SamplingFailure> RejectionSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  begin_pile(sample, load, pile);
  const RandomKey key(spec_.seed, sample);
  int failed_layer = 0;
  for (std::uint64_t attempt = 1; attempt <= spec_.max_tries; ++attempt) {
    throw_if_interrupted();
    ++counts_.tries;
    failed_layer = try_pile(cone_, pile, [&](int n, int i, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(n, i, static_cast<std::uint32_t>(attempt)).first);
    });
    if (failed_layer < 0) {
      counts_.beads += lattice_.beads();
      return std::nullopt;
    }
  }
  return SamplingFailure{failed_layer};
}

std::optional<SamplingFailure> RejectionSampler::draw_again(std::uint64_t sample, std::span<const double> load,
                                                            const Pile& first, Pile& pile) {
  begin_pile(sample, load, pile);
  const RandomKey key(spec_.seed, sample);
  ++counts_.tries;
  std::vector<double> numbers;
  read_split_uniforms(first, numbers);
  int failed_layer = try_pile(cone_, pile, [&](int n, int i, Outgoing out, Interval interval) {
    const std::size_t at = lattice_.index(n, i);
    return kept_split(first, at, numbers[at], out, interval);
  });
  // The tries of the first solution count upwards; these count down from the last one, so that they are others.
  for (std::uint64_t attempt = 0; failed_layer >= 0 && attempt < spec_.max_tries; ++attempt) {
    throw_if_interrupted();
    ++counts_.tries;
    failed_layer = try_pile(cone_, pile, [&](int n, int i, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(n, i, static_cast<std::uint32_t>(most_tries - attempt)).first);
    });
  }
  if (failed_layer >= 0) return SamplingFailure{failed_layer};
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

}  // namespace granuscope
