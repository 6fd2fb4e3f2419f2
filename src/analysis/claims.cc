#include "analysis/claims.h"

#include <fmt/format.h>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"

namespace granuscope {

namespace {

/// What the paper claims of its beads as friction varies says nothing of another model, or of another parameter.
Claim of_friction(const Analysis& analysis, const Claim& claim) {
  const SamplerSpec sampler = analysis.results.empty() ? SamplerSpec{} : analysis.results.front().spec.sampler;
  if (analysis.scan == &friction_parameter() && sampler.model.is_beads()) return claim;
  Claim open = open_claim(claim.id, claim.statement, claim.quantity);
  leave_open(open, fmt::format("it is about the friction of beads, and this experiment varies the {} of the model {}",
                               analysis.scan->label(), name_of(sampler.model.name)));
  return open;
}

}  // namespace

std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  return {of_friction(analysis, judge_frictionless(analysis)),
          of_friction(analysis, judge_double_peak(analysis, fit, spec)),
          of_friction(analysis, judge_two_gaussians(analysis, fit, spec)),
          judge_linear_position(analysis, spec),
          judge_diffusive_width(analysis, spec),
          judge_amplitude(analysis, spec),
          judge_no_elastic_scaling(analysis, spec),
          of_friction(analysis, judge_closer_and_wider(analysis, fit)),
          of_friction(analysis, judge_c_of_mu(analysis)),
          of_friction(analysis, judge_D_of_mu(analysis)),
          of_friction(analysis, judge_c_of_D(analysis)),
          of_friction(analysis, judge_differs_from_theory(analysis)),
          judge_noise(analysis, spec)};
}

void expect_verdicts(std::vector<Claim>& claims, const std::map<std::string, std::string>& expected) {
  for (Claim& claim : claims) {
    if (const auto verdict = expected.find(claim.id); verdict != expected.end()) claim.expected = verdict->second;
  }
}

std::vector<std::string> unexpected_results(const Analysis& analysis) {
  std::vector<std::string> sentences;
  for (const Claim& claim : analysis.claims) {
    if (claim.expected.empty() || claim.expected == claim.verdict) continue;
    sentences.push_back(fmt::format("{} is \"{}\" where the experiment expects \"{}\": {}", claim.id, claim.verdict,
                                    claim.expected, claim.explanation));
  }
  for (const Transport& one : analysis.results) {
    if (!one.precision.asked || one.precision.reached) continue;
    sentences.push_back(fmt::format("the precision asked for was not reached at {} = {}: {}", one.scan->name,
                                    one.scanned(), one.precision.reason));
  }
  return sentences;
}

std::vector<std::string> claim_ids() {
  // What is decided from nothing measured has every id.
  std::vector<std::string> ids;
  for (const Claim& claim : judge_claims({}, {}, {})) ids.push_back(claim.id);
  return ids;
}

}  // namespace granuscope
