#include "analysis/claim_rule.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "support/number_format.h"

namespace granuscope {

NumberVerdict judge_number(const Estimate& measured, double paper, double paper_error) {
  if (!measured.known() || !std::isfinite(measured.standard_error)) {
    return {undetermined, std::numeric_limits<double>::quiet_NaN()};
  }
  const double error = std::hypot(measured.standard_error, paper_error);
  const double distance = measured.value - paper;
  // Without any error only the exact number agrees.
  const double z = error > 0        ? distance / error
                   : distance == 0. ? 0.
                                    : std::copysign(std::numeric_limits<double>::infinity(), distance);
  const double deviation = deviation_to_detect * std::abs(paper);
  const bool hidden = deviation <= agreement * error;
  const bool hidden_by_paper = deviation <= agreement * paper_error && measured.standard_error <= paper_error;
  if (hidden && !hidden_by_paper) return {undetermined, z};
  return {std::abs(z) <= agreement ? reproduced : not_reproduced, z};
}

Claim open_claim(const std::string& id, const std::string& statement) {
  Claim claim;
  claim.id = id;
  claim.statement = statement;
  claim.z_score = std::numeric_limits<double>::quiet_NaN();
  return claim;
}

void leave_open(Claim& claim, const std::string& reason) {
  claim.verdict = undetermined;
  claim.measured = {};
  claim.measured.reason = reason;
  claim.explanation = reason + ".";
  // Sentences begin with a capital; letters beyond ASCII (Greek) stay as they are.
  char& first = claim.explanation.front();
  if (first >= 'a' && first <= 'z') first = static_cast<char>(first - 'a' + 'A');
}

void judge_by_number(Claim& claim, const Estimate& measured, double paper, double paper_error,
                     const std::string& what) {
  claim.measured = measured;
  claim.paper = paper;
  claim.paper_error = paper_error;
  const NumberVerdict judged = judge_number(measured, paper, paper_error);
  claim.verdict = judged.verdict;
  claim.z_score = judged.z_score;
  if (!measured.known()) {
    claim.explanation = fmt::format("{} could not be measured: {}.", what, measured.reason);
    return;
  }
  const std::string number = value_with_error(measured.value, measured.standard_error);
  const std::string distance = significant(std::abs(judged.z_score), 2);
  if (claim.verdict == undetermined) {
    claim.explanation = fmt::format(
        "{} = {} is too uncertain to tell a deviation of 20 % from the paper's value; it lies {} combined standard "
        "errors from it.",
        what, number, distance);
  } else if (claim.verdict == reproduced) {
    claim.explanation =
        fmt::format("{} = {} agrees with the paper within {} combined standard errors.", what, number, distance);
  } else {
    claim.explanation = fmt::format("{} = {} lies {} combined standard errors {} the paper's value.", what, number,
                                    distance, judged.z_score > 0 ? "above" : "below");
  }
}

}  // namespace granuscope
