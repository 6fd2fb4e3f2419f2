#pragma once
#include <string>
#include <vector>

#include "analysis/results.h"

namespace granuscope {

/// One JUnit test case for each claim; a case fails only if its verdict is not the expected one, and a claim without an
/// expectation passes. One that is neither reproduced nor refuted, and not expected to be, is skipped. What is written
/// to the case begins with the verdict.
std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name);

}  // namespace granuscope
