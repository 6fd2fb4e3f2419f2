#include "sampling/scan_parameter.h"

#include <fmt/format.h>

#include <algorithm>

#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

std::vector<ScanParameter> all_parameters() {
  std::vector<ScanParameter> all = {
      {"mu", "μ", "friction coefficient", [](const SamplerSpec& spec) { return spec.model.has_contacts(); },
       [](SamplerSpec& spec) -> double& { return spec.mu; }},
      {"lambda", "λ", "power of the intervals",
       [](const SamplerSpec& spec) { return spec.model.is_beads() && spec.law == Law::polytope; },
       [](SamplerSpec& spec) -> double& { return spec.lambda; }},
      {"bead_weight", "g", "weight of a bead", [](const SamplerSpec& spec) { return spec.model.is_beads(); },
       [](SamplerSpec& spec) -> double& { return spec.bead_weight; }}};
  for (const ModelParameter& one : model_parameters()) {
    all.push_back({one.name, one.symbol, one.meaning,
                   [&one](const SamplerSpec& spec) { return one.belongs_to(spec.model); },
                   [&one](SamplerSpec& spec) -> double& { return one.in(spec.model); }});
  }
  return all;
}

/// Those of beads first.
const std::vector<ScanParameter>& parameters() {
  static const std::vector<ScanParameter> all = all_parameters();
  return all;
}

}  // namespace

std::string ScanParameter::at(const SamplerSpec& spec) const {
  return fmt::format("{} = {}", symbol, exact(value(spec)));
}

std::string ScanParameter::file_part(const SamplerSpec& spec) const {
  return fmt::format("{}-{}", name, exact(value(spec)));
}

const ScanParameter& friction_parameter() { return parameters().front(); }

const ScanParameter& usual_parameter(const SamplerSpec& spec) {
  const auto of_model = std::find_if(parameters().begin(), parameters().end(), [&](const ScanParameter& one) {
    return &one != &friction_parameter() && one.belongs_to(spec);
  });
  return spec.model.is_beads() || of_model == parameters().end() ? friction_parameter() : *of_model;
}

const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec) {
  std::string known;
  for (const ScanParameter& one : parameters()) {
    if (!one.belongs_to(spec)) continue;
    if (one.name == name) return one;
    known += (known.empty() ? "" : ", ") + one.name;
  }
  throw InputError(fmt::format("piles of the model {} do not depend on \"{}\"; {}", name_of(spec.model.name), name,
                               known.empty() ? "leave it empty" : "choose one of: " + known));
}

std::vector<std::string> names_of_scan_parameters() {
  std::vector<std::string> names;
  for (const ScanParameter& one : parameters()) names.push_back(fmt::format("{} ({})", one.name, one.meaning));
  return names;
}

}  // namespace granuscope
