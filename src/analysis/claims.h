#pragma once
#include <map>
#include <string>
#include <vector>

#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/results.h"

namespace granuscope {

/// Decides the claims of the paper about the main line from what was measured (all of `analysis` but its claims).
std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec);

/// Notes with each claim the verdict that the experiment expects of it; `expected` maps claim ids to verdicts.
void expect_verdicts(std::vector<Claim>& claims, const std::map<std::string, std::string>& expected);

/// What came out otherwise than the experiment asks, a sentence each: verdicts, and a precision that was not reached.
std::vector<std::string> unexpected_results(const Analysis& analysis);

/// Ids of all claims that judge_claims decides, in its order.
std::vector<std::string> claim_ids();

}  // namespace granuscope
