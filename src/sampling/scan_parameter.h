#pragma once
#include <string>

#include "sampling/sampler_spec.h"

namespace granuscope {

/// A number of a sampler that an experiment varies from ensemble to ensemble: how strong the disorder of its piles is.
struct ScanParameter {
  const char* name;                        ///< "mu", as experiment files and results have it
  const char* symbol;                      ///< "μ"
  const char* meaning;                     ///< "friction coefficient"
  bool (*belongs_to)(const SamplerSpec&);  ///< whether piles of such a sampler depend on it
  double SamplerSpec::*of_sampler;         ///< where it is, or
  double& (*of_model)(ModelSpec&);         ///< where it is if that is null

  double value(const SamplerSpec& spec) const;
  void set(SamplerSpec& spec, double value) const;
  /// "μ = 0.3".
  std::string at(const SamplerSpec& spec) const;
  /// "mu-0.3", for files.
  std::string file_part(const SamplerSpec& spec) const;
  /// "friction coefficient μ".
  std::string label() const { return std::string(meaning) + " " + symbol; }
};

/// The friction coefficient of beads.
const ScanParameter& friction_parameter();

/// The one that is varied where nothing else is said: the first that belongs to the sampler.
const ScanParameter& usual_parameter(const SamplerSpec& spec);

/// Throws InputError naming those that belong to the sampler.
const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec);

}  // namespace granuscope
