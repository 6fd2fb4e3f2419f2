#include "sampling/scan_parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

bool is_model(const SamplerSpec& spec, ModelName name) { return spec.model.name == name; }
bool has_free_noise(const SamplerSpec& spec) {
  return is_model(spec, ModelName::three_leg) && spec.model.three_leg.law != MiddleLaw::positive;
}

/// Of each sampler the usual one first.
constexpr std::array<ScanParameter, 7> parameters{{
    {"mu", "μ", "friction coefficient", [](const SamplerSpec& spec) { return spec.model.is_beads(); }, &SamplerSpec::mu,
     nullptr},
    {"lambda", "λ", "power of the intervals",
     [](const SamplerSpec& spec) { return spec.model.is_beads() && spec.law == Law::polytope; }, &SamplerSpec::lambda,
     nullptr},
    {"disorder", "Δ", "disorder of the shares",
     [](const SamplerSpec& spec) { return is_model(spec, ModelName::q_model); }, nullptr,
     [](ModelSpec& model) -> double& { return model.q_model.disorder; }},
    {"middle", "p", "mean share of the middle leg", has_free_noise, nullptr,
     [](ModelSpec& model) -> double& { return model.three_leg.middle; }},
    {"noise", "δ", "noise of the share", has_free_noise, nullptr,
     [](ModelSpec& model) -> double& { return model.three_leg.noise; }},
    {"share", "s", "bound of p over p_max",
     [](const SamplerSpec& spec) {
       return is_model(spec, ModelName::three_leg) && spec.model.three_leg.law == MiddleLaw::positive;
     },
     nullptr, [](ModelSpec& model) -> double& { return model.three_leg.share; }},
    {"disorder", "Δ", "standard deviation of the noise",
     [](const SamplerSpec& spec) { return is_model(spec, ModelName::stochastic_osl); }, nullptr,
     [](ModelSpec& model) -> double& { return model.stochastic_osl.disorder; }},
}};

}  // namespace

double ScanParameter::value(const SamplerSpec& spec) const {
  if (of_sampler != nullptr) return spec.*of_sampler;
  ModelSpec model = spec.model;
  return of_model(model);
}

void ScanParameter::set(SamplerSpec& spec, double value) const {
  if (of_sampler != nullptr) {
    spec.*of_sampler = value;
  } else {
    of_model(spec.model) = value;
  }
}

std::string ScanParameter::at(const SamplerSpec& spec) const {
  return fmt::format("{} = {}", symbol, exact(value(spec)));
}

std::string ScanParameter::file_part(const SamplerSpec& spec) const {
  return fmt::format("{}-{}", name, exact(value(spec)));
}

const ScanParameter& friction_parameter() { return parameters.front(); }

const ScanParameter& usual_parameter(const SamplerSpec& spec) {
  return *std::find_if(parameters.begin(), parameters.end(),
                       [&](const ScanParameter& one) { return one.belongs_to(spec); });
}

const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec) {
  std::string known;
  for (const ScanParameter& one : parameters) {
    if (!one.belongs_to(spec)) continue;
    if (one.name == name) return one;
    known += (known.empty() ? "" : ", ") + std::string(one.name);
  }
  throw InputError(fmt::format("piles of the model {} do not depend on \"{}\"; choose one of: {}",
                               name_of(spec.model.name), name, known));
}

}  // namespace granuscope
