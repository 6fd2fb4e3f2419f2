#include "sampling/rejection.h"

#include "model/equilibrium.h"
#include "sampling/random_key.h"

namespace granuscope {
namespace {

/// Fills the pile with try number `attempt`; the layer of the first bead without a solution, or -1.
int try_pile(const RandomKey& key, std::uint32_t attempt, const FrictionCone& cone, std::span<const double> load,
             Pile& pile, SamplerCounts& counts) {
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
      if (interval.empty()) return n;
      const double u = key.attempt(n, i, attempt).first;
      ++counts.uniforms;
      pile.V_R[at] = out.V_R;
      pile.V_L[at] = out.V_L;
      pile.H_R[at] = point_at(interval, u);
      pile.H_L[at] = in.H - pile.H_R[at];
    }
  }
  return -1;
}

}  // namespace

RejectionSampler::RejectionSampler(const SamplerSpec& spec, const Lattice& lattice)
    : lattice_(lattice), cone_(spec.mu), spec_(spec) {}

std::optional<SamplingFailure> RejectionSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  pile.mu = spec_.mu;
  pile.law = name_of(Law::rejection);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  const RandomKey key(spec_.seed, sample);
  int failed_layer = 0;
  for (std::uint64_t attempt = 1; attempt <= spec_.max_tries; ++attempt) {
    ++counts_.tries;
    failed_layer = try_pile(key, static_cast<std::uint32_t>(attempt), cone_, load, pile, counts_);
    if (failed_layer < 0) {
      counts_.beads += lattice_.beads();
      return std::nullopt;
    }
  }
  return SamplingFailure{failed_layer};
}

}  // namespace granuscope
