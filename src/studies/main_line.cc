#include "studies/main_line.h"

namespace granuscope {

const ScanParameter& MainLine::scanned() const {
  return scan.parameter.empty() ? usual_parameter(sampling) : scan_parameter_named(scan.parameter, sampling);
}

std::vector<double> MainLine::scan_values() const {
  if (!scan.values.empty()) return scan.values;
  if (&scanned() == &friction_parameter()) return mu;
  return {scanned().value(sampling)};
}

double MainLine::shown_value(double wanted) const {
  const std::vector<double> values = scan_values();
  const bool has_it = std::find(values.begin(), values.end(), wanted) != values.end();
  return has_it || &scanned() == &friction_parameter() ? wanted : values.back();
}

SamplerSpec MainLine::sampler_at(double value) const {
  SamplerSpec spec = sampling;
  if (spec.model.has_contacts()) spec.mu = mu.front();
  scanned().in(spec) = value;
  return spec;
}

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
