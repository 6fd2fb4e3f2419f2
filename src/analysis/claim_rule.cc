#include "analysis/claim_rule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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
  if (std::abs(z) > agreement) return {not_reproduced, z};
  return {hidden && !hidden_by_paper ? undetermined : reproduced, z};
}

Claim open_claim(const std::string& id, const std::string& statement, const std::string& quantity) {
  Claim claim;
  claim.id = id;
  claim.statement = statement;
  claim.quantity = quantity;
  claim.paper = std::numeric_limits<double>::quiet_NaN();
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
    if (claim.measured.reason.empty()) claim.measured.reason = "the experiment does not contain it";
    claim.explanation = fmt::format("{} could not be measured: {}.", what, claim.measured.reason);
    return;
  }
  const std::string number = value_with_error(measured.value, measured.standard_error);
  const std::string distance = significant(std::abs(judged.z_score), 2);
  if (claim.verdict == undetermined) {
    const std::string cost = cost_of_deciding(measured, paper, paper_error);
    claim.explanation = fmt::format(
        "{} is {}, too uncertain to tell a deviation of 20 %; it lies {} combined standard errors from the paper’s "
        "value{}.",
        what, number, distance, cost.empty() ? "" : "; " + cost);
  } else if (claim.verdict == reproduced) {
    claim.explanation =
        fmt::format("{} is {} and agrees with the paper within {} combined standard errors.", what, number, distance);
  } else {
    claim.explanation = fmt::format("{} is {}; it lies {} combined standard errors {} the paper’s value.", what, number,
                                    distance, judged.z_score > 0 ? "above" : "below");
  }
}

void add_sentence(Claim& claim, const std::string& sentence) {
  if (sentence.empty()) return;
  std::string& text = claim.explanation.empty() ? claim.explanation : claim.remarks;
  if (!text.empty()) text += ' ';
  text += sentence;
}

std::string cost_of_deciding(const Estimate& measured, double paper, double paper_error) {
  const double room = std::pow(deviation_to_detect * paper / agreement, 2) - paper_error * paper_error;
  if (!measured.known() || !(room > 0)) return "";
  const double factor = measured.standard_error * measured.standard_error / room;
  return factor > 1 ? more_piles(factor) : "";
}

std::string more_piles(double factor) {
  if (!(factor < 1000)) return "more than a thousand times as many piles would be needed";
  return fmt::format("about {} times as many piles would decide it", significant(factor, 2));
}

std::string list_of_mu(const std::vector<double>& mu) {
  constexpr std::size_t most_listed = 4;
  if (mu.size() > most_listed) {
    return fmt::format("{} values of μ from {} to {}", mu.size(), mu.front(), mu.back());
  }
  if (mu.size() < 2) return fmt::format("μ = {}", fmt::join(mu, ""));
  return fmt::format("μ = {} and {}", fmt::join(mu.begin(), mu.end() - 1, ", "), mu.back());
}

std::string over_all_mu(const std::vector<double>& mu) { return (mu.size() == 1 ? "at " : "over ") + list_of_mu(mu); }

}  // namespace granuscope
