#pragma once
#include <map>
#include <string>
#include <vector>

#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/results.h"

namespace granuscope {

/// Decides every claim of the paper from what was measured (all of `analysis` but its claims). `expected` maps claim
/// ids to the verdict the experiment expects.
std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec,
                                const std::map<std::string, std::string>& expected);

/// Ids of all claims that judge_claims decides, in its order.
std::vector<std::string> claim_ids();

}  // namespace granuscope
