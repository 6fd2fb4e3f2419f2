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

}  // namespace granuscope
