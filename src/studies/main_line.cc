#include "studies/main_line.h"

namespace granuscope {

EnsembleSpec MainLine::ensemble_at(double friction, LatticeSpec size, std::uint64_t samples) const {
  EnsembleSpec spec;
  spec.sampler = sampler_for(friction);
  spec.lattice = size;
  spec.response.overload = response.overload;
  spec.response.blocks = response.blocks;
  spec.response.samples = samples;
  return spec;
}

EnsembleSpec MainLine::uniform_piles(Law law, double friction, LatticeSpec size, std::uint64_t samples) const {
  EnsembleSpec spec = ensemble_at(friction, size, samples);
  spec.sampler = {};
  spec.sampler.mu = friction;
  spec.sampler.seed = sampling.seed;
  spec.sampler.law = law;
  spec.load = Load::uniform;
  spec.record_profiles = false;
  return spec;
}

}  // namespace granuscope
