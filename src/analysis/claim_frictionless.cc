#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "model/lattice.h"
#include "support/number_format.h"

namespace granuscope {

namespace {
constexpr double rounding = 1e-12;  ///< of sums over some hundred layers
}

// Holds if at mu = 0 every pile is the same and c = tan 30 deg, D = 0 to rounding.
Claim judge_frictionless(const Analysis& analysis) {
  Claim claim = open_claim("frictionless", "Without friction c = tan 30\u00b0 and D = 0.", "c at \u03bc = 0");
  claim.paper = tan30;
  const auto result = std::find_if(analysis.results.begin(), analysis.results.end(),
                                   [](const Transport& t) { return t.scanned() == 0; });
  if (result == analysis.results.end()) {
    leave_open(claim, "the experiment does not contain \u03bc = 0: add it to friction.mu, it costs next to nothing");
    return claim;
  }
  claim.measured = result->c;
  if (!result->c.known()) {
    leave_open(claim, result->c.reason);
    return claim;
  }
  const double c_error = std::abs(result->c.value - tan30), D_error = std::abs(result->D.value);
  const bool holds = result->exact && c_error <= rounding && D_error <= rounding;
  claim.verdict = holds ? reproduced : not_reproduced;
  claim.explanation = fmt::format(
      "A check of the program, since the rays are exact on this lattice: c differs from tan 30\u00b0 by {} and D "
      "from 0 by {}; up to {} is rounding.",
      significant(c_error, 2), significant(D_error, 2), significant(rounding, 1));
  return claim;
}

}  // namespace granuscope
