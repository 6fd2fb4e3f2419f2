#include "sampling/rejection.h"

#include "model/equilibrium.h"
#include "sampling/random_key.h"
#include "sampling/split_numbers.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

/// Fills the pile with the splits H_R = choose_split(layer, bead, forces, interval); the layer of the first bead
/// without a solution, or -1.
template <typename ChooseSplit>
int try_pile(const FrictionCone& cone, std::span<const double> load, Pile& pile, ChooseSplit choose_split) {
  const Lattice& lattice = pile.lattice;
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i);
      Incoming in{load[static_cast<std::size_t>(i)] / 2, load[static_cast<std::size_t>(i)] / 2, 0};
      if (n > 0) {
        const std::size_t a = lattice.index(n - 1, lattice.upper_left(n, i));
        const std::size_t b = lattice.index(n - 1, lattice.upper_right(n, i));
        in = {pile.V_R[a], pile.V_L[b], pile.H_R[a] + pile.H_L[b]};
      }
      const Outgoing out = balance(in);
      const Interval interval = split_interval(cone, out, in.H);
      if (unsolvable(out, interval)) return n;
      pile.V_R[at] = out.V_R;
      pile.V_L[at] = out.V_L;
      pile.H_R[at] = choose_split(n, i, out, interval);
      pile.H_L[at] = in.H - pile.H_R[at];
    }
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
}

std::optional<SamplingFailure> RejectionSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  begin_pile(sample, load, pile);
  const RandomKey key(spec_.seed, sample);
  int failed_layer = 0;
  for (std::uint64_t attempt = 1; attempt <= spec_.max_tries; ++attempt) {
    throw_if_interrupted();
    ++counts_.tries;
    failed_layer = try_pile(cone_, load, pile, [&](int n, int i, Outgoing, Interval interval) {
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
  read_split_numbers(first, numbers);
  int failed_layer = try_pile(cone_, load, pile, [&](int n, int i, Outgoing out, Interval interval) {
    const std::size_t at = lattice_.index(n, i);
    return kept_split(first, at, numbers[at], out, interval);
  });
  // The tries of the first solution count upwards; these count down from the last one, so that they are others.
  for (std::uint64_t attempt = 0; failed_layer >= 0 && attempt < spec_.max_tries; ++attempt) {
    throw_if_interrupted();
    ++counts_.tries;
    failed_layer = try_pile(cone_, load, pile, [&](int n, int i, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(n, i, static_cast<std::uint32_t>(most_tries - attempt)).first);
    });
  }
  if (failed_layer >= 0) return SamplingFailure{failed_layer};
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

}  // namespace granuscope
