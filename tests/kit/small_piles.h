#pragma once
#include <cstdint>

#include "ensemble/ensemble_spec.h"

namespace granuscope::test {

/// Small piles under a uniform load, of which no profiles are kept.
inline EnsembleSpec piles_of(Law law, double mu = 0.3, LatticeSpec lattice = {6, 6}, std::uint64_t samples = 2048) {
  EnsembleSpec spec;
  spec.sampler.law = law;
  spec.sampler.mu = mu;
  spec.lattice = lattice;
  spec.load = Load::uniform;
  spec.record_profiles = false;
  spec.response.samples = samples;
  spec.response.blocks = 32;
  return spec;
}

/// Those of a Markov chain, after 50 sweeps of burn-in.
inline EnsembleSpec chained_piles(std::uint64_t thinning, std::uint64_t samples) {
  EnsembleSpec spec = piles_of(Law::polytope);
  spec.response.samples = samples;
  spec.sampler.burn_in = 50;
  spec.sampler.thinning = thinning;
  return spec;
}

}  // namespace granuscope::test
