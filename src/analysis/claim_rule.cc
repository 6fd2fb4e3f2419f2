#include "analysis/claim_rule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>

#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double in_errors(double distance, double error) {
  // Without any error only the exact number agrees.
  if (error > 0) return distance / error;
  return distance == 0. ? 0. : std::copysign(std::numeric_limits<double>::infinity(), distance);
}

/// Of the values as far off the paper's as must be detected, the one nearer to the measured.
Rival detectable_deviation(const PaperNumber& paper, double measured) {
  const double off = std::copysign(deviation_to_detect * std::abs(paper.value), measured - paper.value);
  return {paper.value + off, fmt::format("{} % off", significant(100 * deviation_to_detect, 2))};
}

std::string number_in_words(const Estimate& measured) {
  std::string number = value_with_error(measured.value, measured.standard_error);
  if (measured.systematic > 0 && measured.standard_error > 0) {
    number += fmt::format(" with a systematic error of {}", significant(measured.systematic, 2));
  }
  return number;
}

std::string rival_in_words(const Claim& claim) {
  return fmt::format("{} from {} ({})", significant(std::abs(claim.rival_distance), 2), significant(claim.rival, 2),
                     claim.rival_name);
}

void take_unmeasured(Claim& claim, const std::string& what) {
  claim.verdict = not_tested;
  if (claim.measured.reason.empty()) claim.measured.reason = "the experiment does not contain it";
  claim.explanation = fmt::format("{} could not be measured: {}.", what, claim.measured.reason);
}

}  // namespace

double total_error(const Estimate& measured) {
  return std::hypot(measured.standard_error, std::isfinite(measured.systematic) ? measured.systematic : 0.0);
}

NumberVerdict judge_number(const Estimate& measured, const PaperNumber& paper, const std::optional<Rival>& rival) {
  const Rival other = rival ? *rival : detectable_deviation(paper, measured.value);
  if (!measured.known() || !std::isfinite(measured.standard_error)) return {not_tested, nan, other, nan};
  const double error = std::hypot(total_error(measured), paper.tolerance);
  const double z = in_errors(measured.value - paper.value, std::hypot(error, paper.error));
  const double rival_distance = in_errors(measured.value - other.value, error);
  if (std::abs(z) > agreement) return {not_reproduced, z, other, rival_distance};
  return {std::abs(rival_distance) > agreement ? reproduced : not_decided, z, other, rival_distance};
}

Claim open_claim(const std::string& id, const std::string& statement, const std::string& quantity) {
  Claim claim;
  claim.id = id;
  claim.statement = statement;
  claim.quantity = quantity;
  claim.paper = claim.z_score = claim.rival = claim.rival_distance = nan;
  return claim;
}

void leave_open(Claim& claim, const std::string& reason) {
  claim.verdict = not_tested;
  claim.measured = {};
  claim.measured.reason = reason;
  claim.explanation = reason + ".";
  // Sentences begin with a capital; letters beyond ASCII (Greek) stay as they are.
  char& first = claim.explanation.front();
  if (first >= 'a' && first <= 'z') first = static_cast<char>(first - 'a' + 'A');
}

void judge_by_number(Claim& claim, const Estimate& measured, const PaperNumber& paper,
                     const std::optional<Rival>& rival, const std::string& what) {
  const NumberVerdict judged = judge_number(measured, paper, rival);
  claim.measured = measured;
  claim.paper = paper.value;
  claim.paper_error = paper.error;
  claim.tolerance = paper.tolerance;
  claim.verdict = judged.verdict;
  claim.z_score = judged.z_score;
  if (!measured.known()) return take_unmeasured(claim, what);
  claim.rival = judged.rival.value;
  claim.rival_name = judged.rival.name;
  claim.rival_distance = judged.rival_distance;
  claim.explanation = fmt::format("{} is {}, in standard errors {} {} the paper’s value and {}", what,
                                  number_in_words(measured), significant(std::abs(judged.z_score), 2),
                                  judged.z_score > 0 ? "above" : "below", rival_in_words(claim));
  claim.explanation +=
      claim.verdict == not_decided ? fmt::format("; {}.", cost_of_deciding(measured, paper, claim.rival)) : ".";
}

void judge_by_exclusion(Claim& claim, const Estimate& measured, const PaperNumber& paper, const Rival& rival,
                        const std::string& what) {
  claim.measured = measured;
  if (!measured.known() || !std::isfinite(measured.standard_error)) return take_unmeasured(claim, what);
  const double error = std::hypot(total_error(measured), paper.tolerance);
  const double from_paper = in_errors(measured.value - paper.value, error);
  claim.tolerance = paper.tolerance;
  claim.rival = rival.value;
  claim.rival_name = rival.name;
  claim.rival_distance = in_errors(measured.value - rival.value, error);
  claim.verdict = std::abs(claim.rival_distance) > agreement ? reproduced
                  : std::abs(from_paper) > agreement         ? not_reproduced
                                                             : not_decided;
  claim.explanation =
      fmt::format("{} is {}, in standard errors {}", what, number_in_words(measured), rival_in_words(claim));
  claim.explanation +=
      claim.verdict == not_decided ? fmt::format("; {}.", cost_of_deciding(measured, paper, claim.rival)) : ".";
}

void add_sentence(Claim& claim, const std::string& sentence) {
  if (sentence.empty()) return;
  std::string& text = claim.explanation.empty() ? claim.explanation : claim.remarks;
  if (!text.empty()) text += ' ';
  text += sentence;
}

std::string cost_of_deciding(const Estimate& measured, const PaperNumber& paper, double rival) {
  const double systematic = std::isfinite(measured.systematic) ? measured.systematic : 0;
  const double room =
      std::pow((rival - paper.value) / agreement, 2) - systematic * systematic - paper.tolerance * paper.tolerance;
  if (!(room > 0)) return "more piles do not decide it, since the systematic error alone hides the difference";
  return more_piles(measured.standard_error * measured.standard_error / room);
}

std::string more_piles(double factor) {
  if (factor < 1) return "somewhat more piles would decide it";
  if (!(factor < 1000)) return "more than a thousand times as many piles would be needed";
  return fmt::format("about {} times as many piles would decide it", significant(factor, 2));
}

std::string list_of_values(const std::vector<double>& values, const std::string& symbol) {
  constexpr std::size_t most_listed = 4;
  if (values.size() > most_listed) {
    return fmt::format("{} values of {} from {} to {}", values.size(), symbol, values.front(), values.back());
  }
  if (values.size() < 2) return fmt::format("{} = {}", symbol, fmt::join(values, ""));
  return fmt::format("{} = {} and {}", symbol, fmt::join(values.begin(), values.end() - 1, ", "), values.back());
}

std::string over_all_values(const std::vector<double>& values, const std::string& symbol) {
  return (values.size() == 1 ? "at " : "over ") + list_of_values(values, symbol);
}

}  // namespace granuscope
