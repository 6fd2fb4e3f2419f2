#include "analysis/claims.h"

#include <fmt/format.h>

#include "analysis/claim_judges.h"

namespace granuscope {

std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  return {judge_frictionless(analysis),
          judge_double_peak(analysis, fit, spec),
          judge_two_gaussians(analysis, fit, spec),
          judge_linear_position(analysis, spec),
          judge_diffusive_width(analysis, spec),
          judge_amplitude(analysis, spec),
          judge_no_elastic_scaling(analysis, spec),
          judge_closer_and_wider(analysis, fit),
          judge_c_of_mu(analysis),
          judge_D_of_mu(analysis),
          judge_c_of_D(analysis),
          judge_differs_from_theory(analysis),
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
    sentences.push_back(
        fmt::format("the precision asked for was not reached at mu = {}: {}", one.mu(), one.precision.reason));
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
