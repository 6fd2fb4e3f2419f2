#include "analysis/claims.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/lattice.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double deviation_to_detect = 0.2;  ///< share of the paper's number that must be distinguishable
constexpr double sigmas = 3;
constexpr double rounding = 1e-12;

void judge_number(Claim& claim, const Estimate& measured, const std::string& what) {
  claim.measured = measured;
  claim.z_score = std::numeric_limits<double>::quiet_NaN();
  if (!measured.known()) {
    claim.verdict = "undetermined";
    claim.explanation = fmt::format("{} could not be measured: {}.", what, measured.reason);
    return;
  }
  const double error = std::hypot(measured.standard_error, claim.paper_error);
  claim.z_score = (measured.value - claim.paper) / error;
  const std::string number = value_with_error(measured.value, measured.standard_error);
  if (deviation_to_detect * std::abs(claim.paper) <= sigmas * error) {
    claim.verdict = "undetermined";
    claim.explanation = fmt::format(
        "{} = {} is too uncertain to tell a deviation of 20 % from the paper's value; it lies {} combined standard "
        "errors "
        "from it.",
        what, number, significant(std::abs(claim.z_score), 2));
  } else if (std::abs(claim.z_score) <= sigmas) {
    claim.verdict = "reproduced";
    claim.explanation = fmt::format("{} = {} agrees with the paper within {} combined standard errors.", what, number,
                                    significant(std::abs(claim.z_score), 2));
  } else {
    claim.verdict = "not reproduced";
    claim.explanation = fmt::format("{} = {} lies {} combined standard errors {} the paper's value.", what, number,
                                    significant(std::abs(claim.z_score), 2), claim.z_score > 0 ? "above" : "below");
  }
}

Claim judge_frictionless(const std::vector<Transport>& results) {
  Claim claim;
  claim.id = "frictionless";
  claim.statement = "Without friction c = tan 30\u00b0 and D = 0.";
  claim.paper = tan30;
  claim.z_score = std::numeric_limits<double>::quiet_NaN();
  const auto result = std::find_if(results.begin(), results.end(), [](const Transport& t) { return t.mu == 0; });
  if (result == results.end()) {
    claim.verdict = "undetermined";
    claim.measured.reason = "the experiment does not contain \u03bc = 0";
    claim.explanation = "The experiment does not contain \u03bc = 0.";
    return claim;
  }
  claim.measured = result->c;
  const double c_error = std::abs(result->c.value - tan30), D_error = std::abs(result->D.value);
  const bool holds = result->exact && c_error <= rounding && D_error <= rounding;
  claim.verdict = holds ? "reproduced" : "not reproduced";
  claim.explanation = fmt::format("c differs from tan 30\u00b0 by {} and D from 0 by {}; up to {} is rounding.",
                                  significant(c_error, 2), significant(D_error, 2), significant(rounding, 1));
  return claim;
}

Claim judge_exponent(const char* id, const char* statement, const char* name, const ScalingFit& fit, double paper,
                     double paper_error) {
  Claim claim;
  claim.id = id;
  claim.statement = statement;
  claim.paper = paper;
  claim.paper_error = paper_error;
  judge_number(claim, fit.exponent, fmt::format("{} over \u03bc = {} to {}", name, fit.window[0], fit.window[1]));
  return claim;
}

}  // namespace

std::vector<std::string> claim_ids() { return {"frictionless", "c-of-mu", "D-of-mu", "c-of-D"}; }

std::vector<Claim> judge_claims(const std::vector<Transport>& results, const ScalingFits& scaling,
                                const std::map<std::string, std::string>& expected) {
  // The paper states c0 - c as proportional to mu, which leaves the exponent 1 no error; beta "about 2.5" is taken to
  // half a unit of its last digit; alpha comes with its error.
  std::vector<Claim> claims{
      judge_frictionless(results),
      judge_exponent("c-of-mu", "c decreases with friction, c\u2080 \u2212 c in proportion to \u03bc.",
                     "The exponent \u03b3", scaling.gamma, 1.0, 0.0),
      judge_exponent("D-of-mu", "D grows as \u03bc to the power \u03b2, with \u03b2 about 2.5.", "The exponent \u03b2",
                     scaling.beta, 2.5, 0.05),
      judge_exponent("c-of-D", "c\u2080 \u2212 c grows as D to the power \u03b1, with \u03b1 = 0.4.",
                     "The exponent \u03b1", scaling.alpha, 0.4, 0.01)};
  for (Claim& claim : claims) {
    if (const auto verdict = expected.find(claim.id); verdict != expected.end()) claim.expected = verdict->second;
  }
  return claims;
}

}  // namespace granuscope
