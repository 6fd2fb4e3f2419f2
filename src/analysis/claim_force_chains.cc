#include <fmt/format.h>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {

// The share of the mean response within three beads of the two rays x = +-c z, on piles of the size of the picture,
// averaged over the depths where the two bands are apart. Two chains are there if it exceeds both
// ClaimSpec::chain_share and what a response spread evenly between the rays would put there by more than three standard
// errors; they are not if it falls short of either by as much.
Claim judge_force_chains(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = open_claim("force-chains", "A pile of 70 × 60 beads at μ = 0.1 shows two oblique force chains.",
                           "share of the response along the rays");
  if (analysis.side.chain_share.empty()) {
    leave_open(claim,
               "the share of the response along the rays was not measured: set figures.chain_share.samples; a "
               "few hundred piles of 70 × 60 beads decide");
    return claim;
  }
  const ChainShare& chains = analysis.side.chain_share.front();
  claim.statement = fmt::format("A pile of {} × {} beads at μ = {} shows two oblique force chains.",
                                chains.spec.lattice.columns, chains.layers, chains.spec.sampler.mu);
  if (!chains.share.known()) {
    leave_open(claim, fmt::format("the share of the response along the rays is unknown: {}", chains.share.reason));
    return claim;
  }
  claim.measured = chains.share;
  const double needed = std::max(spec.chain_share, chains.even_share);
  const double margin = agreement * chains.share.standard_error;
  const double excess = chains.share.value - needed;
  claim.verdict = excess > margin ? reproduced : excess < -margin ? not_reproduced : undetermined;
  claim.explanation = fmt::format(
      "{} of the response of {} piles lies within {} beads of the rays x = ±c z, c = {} by the thrust ratio of the "
      "same piles; spread evenly between the rays it would be {}, and more than {} is asked for.",
      value_with_error(chains.share.value, chains.share.standard_error), chains.samples, chains.half_width,
      value_with_error(chains.c.value, chains.c.standard_error), significant(chains.even_share, 2),
      significant(needed, 2));
  if (claim.verdict == undetermined) say(claim, "The difference is within three standard errors.");
  return claim;
}

}  // namespace granuscope
