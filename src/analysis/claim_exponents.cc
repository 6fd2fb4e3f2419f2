#include <fmt/format.h>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double paper_gamma = 1.0, paper_gamma_error = 0.0;   ///< stated as a proportionality: exact
constexpr double paper_beta = 2.5, paper_beta_error = 0.05;    ///< "about 2.5": half a unit of its last digit
constexpr double paper_alpha = 0.4, paper_alpha_error = 0.01;  ///< given with its error

std::string over_window(const char* name, const ScalingFit& fit) {
  return fmt::format("the exponent {} over \u03bc = {} to {}", name, fit.window[0], fit.window[1]);
}

/// What the same piles give when c and D are read as ratios at one depth, as the paper's Fig. 3 shows them.
std::string ratio_sentence(const Analysis& analysis, const char* symbol, const char* ratios,
                           ScalingFit ScalingFits::*pick) {
  for (const RatioScaling& ratio : analysis.by_ratio) {
    const Estimate& exponent = (ratio.fits.*pick).exponent;
    if (!exponent.known()) continue;
    return fmt::format(" Read as {} at z = {:.1f}, as in the paper's Fig. 3, the same piles give {} = {}.", ratios,
                       ratio.z, symbol, value_with_error(exponent.value, exponent.standard_error));
  }
  return "";
}

Claim judge_exponent(const char* id, const char* statement, const char* symbol, const ScalingFit& fit, double paper,
                     double paper_error) {
  Claim claim = open_claim(id, statement, symbol);
  std::string what = over_window(symbol, fit);
  what.front() = 'T';
  judge_by_number(claim, fit.exponent, paper, paper_error, what);
  return claim;
}

}  // namespace

// By the rule for numbers, over the window of mu of the experiment, c read as the slope of x_p.
Claim judge_c_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-mu", "c decreases with friction, c\u2080 \u2212 c in proportion to \u03bc.",
                               "\u03b3", analysis.scaling.gamma, paper_gamma, paper_gamma_error);
  claim.explanation += ratio_sentence(analysis, "\u03b3", "the ratio x\u209a/z", &ScalingFits::gamma);
  if (claim.verdict == not_reproduced && !analysis.by_ratio.empty()) {
    claim.explanation +=
        " The ratio's correction of order 1/z carries a law that the slope does not follow; size of the "
        "overload and law of the piles shift it further.";
  }
  return claim;
}

// By the rule for numbers, D read as the slope of W^2.
Claim judge_D_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("D-of-mu", "D grows as \u03bc to the power \u03b2, with \u03b2 about 2.5.", "\u03b2",
                               analysis.scaling.beta, paper_beta, paper_beta_error);
  claim.explanation += ratio_sentence(analysis, "\u03b2", "the ratio W\u00b2/z", &ScalingFits::beta);
  return claim;
}

// By the rule for numbers.
Claim judge_c_of_D(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-D", "c\u2080 \u2212 c grows as D to the power \u03b1, with \u03b1 = 0.4.",
                               "\u03b1", analysis.scaling.alpha, paper_alpha, paper_alpha_error);
  claim.explanation += ratio_sentence(analysis, "\u03b1", "the ratios x\u209a/z and W\u00b2/z", &ScalingFits::alpha);
  return claim;
}

}  // namespace granuscope
