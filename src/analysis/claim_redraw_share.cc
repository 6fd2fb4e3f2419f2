#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// What the paper states ("of the order of"), each taken to half a unit of its last digit.
struct StatedShare {
  double mu, share, error;
};
/// Numbers that differ by less than this factor are of one order.
constexpr double same_order_up_to = 2;

constexpr std::array<StatedShare, 2> stated{{{0.1, 0.005, 0.0005}, {0.3, 0.024, 0.0005}}};

std::string percent(const Estimate& share) {
  return value_with_error(100 * share.value, 100 * share.standard_error) + " %";
}

/// Adds the share of the beads below the overload to a list in words.
void say_below(std::string& list, const RedrawnBeads& beads) {
  if (!beads.below_overload.known()) return;
  list += fmt::format("{}{} at μ = {}", list.empty() ? "" : ", ", percent(beads.below_overload), beads.spec.sampler.mu);
}

}  // namespace

// Both numbers of the paper by the rule for numbers, against the share of all beads of the usable layers: not
// reproduced if either is not, reproduced if both are, else undetermined. The number shown is the one farther off.
Claim judge_redraw_share(const Analysis& analysis) {
  Claim claim = open_claim("redraw-share",
                           "In the standard procedure beads draw again, of the order of 0.5 % at μ = 0.1 and 2.4 % at "
                           "μ = 0.3.",
                           "share of beads");
  std::vector<double> missing;
  std::vector<std::string> clauses;
  std::string below;
  bool failed = false, open = false, same_order = true;
  double farthest = -1;
  for (const StatedShare& one : stated) {
    const auto& measured = analysis.side.redrawn_beads;
    const auto found = std::find_if(measured.begin(), measured.end(), [&](const RedrawnBeads& beads) {
      return std::abs(beads.spec.sampler.mu - one.mu) < 1e-9;
    });
    if (found == measured.end()) {
      missing.push_back(one.mu);
      continue;
    }
    const Estimate& share = found->whole_pile;
    const NumberVerdict judged = judge_number(share, one.share, one.error);
    failed = failed || judged.verdict == not_reproduced;
    open = open || judged.verdict == undetermined;
    if (!share.known()) {
      clauses.push_back(fmt::format("at μ = {} it could not be measured: {}", one.mu, share.reason));
      continue;
    }
    clauses.push_back(fmt::format(
        "{} of the beads draw again at μ = {}, {} combined standard errors {} the paper’s {} %", percent(share), one.mu,
        significant(std::abs(judged.z_score), 2), judged.z_score > 0 ? "above" : "below", 100 * one.share));
    say_below(below, *found);
    same_order = same_order && share.value < same_order_up_to * one.share && share.value * same_order_up_to > one.share;
    if (std::abs(judged.z_score) > farthest) {
      farthest = std::abs(judged.z_score);
      claim.quantity = fmt::format("share of beads at μ = {}", one.mu);
      claim.measured = share;
      claim.paper = one.share;
      claim.paper_error = one.error;
      claim.z_score = judged.z_score;
    }
  }
  if (missing.size() == stated.size()) {
    leave_open(claim,
               "nothing was measured with the standard procedure: set figures.redrawn_beads.mu = [0.1, 0.3]; "
               "a few hundred pairs of piles decide");
    return claim;
  }
  say(claim, fmt::format("{}.", fmt::join(clauses, "; ")));
  if (!missing.empty()) {
    say(claim, fmt::format("The other number of the paper needs {} in figures.redrawn_beads.mu.", list_of_mu(missing)));
  }
  if (failed && same_order) {
    say(claim,
        "Of the order of the paper’s numbers they are; the paper gives no errors, for which half a unit of their last "
        "digit stands here.");
  }
  if (!below.empty()) say(claim, fmt::format("Of the beads with |x| ≤ z it is {}.", below));
  if (!claim.measured.known()) claim.measured.reason = "the shares are unknown";
  claim.verdict = failed ? not_reproduced : open || !missing.empty() ? undetermined : reproduced;
  return claim;
}

}  // namespace granuscope
