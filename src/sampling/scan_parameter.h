#pragma once
#include <functional>
#include <string>
#include <vector>

#include "sampling/sampler_spec.h"

namespace granuscope {

/// A number of a sampler that an experiment varies from ensemble to ensemble: how strong the disorder of its piles is.
struct ScanParameter {
  std::string name;                                    ///< "mu", as experiment files and results have it
  std::string symbol;                                  ///< "μ"
  std::string meaning;                                 ///< "friction coefficient"
  std::function<bool(const SamplerSpec&)> belongs_to;  ///< whether piles of such a sampler depend on it
  std::function<double&(SamplerSpec&)> in;             ///< where it is

  double value(SamplerSpec spec) const { return in(spec); }
  /// "μ = 0.3".
  std::string at(const SamplerSpec& spec) const;
  /// "mu-0.3", for files.
  std::string file_part(const SamplerSpec& spec) const;
  /// "friction coefficient μ".
  std::string label() const { return meaning + " " + symbol; }
};

/// The friction coefficient of beads.
const ScanParameter& friction_parameter();

/// The one that is varied where nothing else is said: friction of beads, else the first of the model.
const ScanParameter& usual_parameter(const SamplerSpec& spec);

/// Throws InputError naming those that belong to the sampler.
const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec);

/// All of them, each with its meaning: "mu (friction coefficient)".
std::vector<std::string> names_of_scan_parameters();

}  // namespace granuscope
