#pragma once
#include <map>
#include <string>
#include <vector>

#include "analysis/results.h"

namespace granuscope {

/// Holds the claims of the paper that carry a number against the measurement. `expected` maps claim ids to the verdict
/// the experiment expects. Rule: z = (m - p)/sqrt(s^2 + s_p^2), s_p the paper's error where it gives one, half a unit
/// of its last digit otherwise, 0 for a law stated as exact; "undetermined" if a deviation of 20 % of p would not reach
/// |z| > 3 or the number is unknown, else "reproduced" if |z| <= 3, else "not reproduced".
/// `frictionless` has its own test: at mu = 0, c = tan 30 deg and D = 0 to rounding.
std::vector<Claim> judge_claims(const std::vector<Transport>& results, const ScalingFits& scaling,
                                const std::map<std::string, std::string>& expected);

/// Ids of all claims that judge_claims decides.
std::vector<std::string> claim_ids();

}  // namespace granuscope
