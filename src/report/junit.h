#pragma once
#include <string>
#include <vector>

#include "analysis/results.h"

namespace granuscope {

/// One JUnit test case for each claim; a case fails only if its verdict is not the expected one, and a claim without an
/// expectation passes. The verdict is the case's text.
std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name);

}  // namespace granuscope
