#include <fmt/format.h>

#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Standard deviations sqrt(2 dof) of chi^2 above dof from which points do not follow a power law.
constexpr double largest_excess = 4;

constexpr double paper_gamma = 1.0, paper_gamma_error = 0.0;   ///< stated as a proportionality: exact
constexpr double paper_beta = 2.5, paper_beta_error = 0.05;    ///< "about 2.5": half a unit of its last digit
constexpr double paper_alpha = 0.4, paper_alpha_error = 0.01;  ///< given with its error

std::string over_window(const char* name, const ScalingFit& fit) {
  return fmt::format("the exponent {} over μ = {} to {}", name, fit.window[0], fit.window[1]);
}

/// Adds to the sentence what the same piles give when c and D are read as ratios at one depth, as the paper's Fig. 3
/// shows them.
void add_ratio(Claim& claim, const Analysis& analysis, const char* ratios, ScalingFit ScalingFits::*pick) {
  for (const RatioScaling& ratio : analysis.by_ratio) {
    const Estimate& exponent = (ratio.fits.*pick).exponent;
    if (!exponent.known() || !claim.measured.known()) continue;
    claim.explanation.pop_back();
    claim.explanation +=
        fmt::format("; read as {} at z = {:.1f}, as in the paper’s Fig. 3, the same piles give {} = {}.", ratios,
                    ratio.z, claim.quantity, value_with_error(exponent.value, exponent.standard_error));
    return;
  }
}

/// Where the points scatter about the law by more than their errors, no single power holds over the window.
void add_misfit(Claim& claim, const ScalingFit& fit) {
  const int degrees = fit.scatter.degrees_of_freedom;
  if (degrees < 1 || !(fit.scatter.chi2 > degrees + largest_excess * std::sqrt(2.0 * degrees))) return;
  add_sentence(
      claim,
      fmt::format(
          "χ² of the points about the power law is {} on {} degree{} of freedom: within their statistical errors they "
          "follow no single power over this window, and the exponent is one between those of its parts.",
          significant(fit.scatter.chi2, 3), degrees, degrees == 1 ? "" : "s"));
}

Claim judge_exponent(const char* id, const char* statement, const char* symbol, const ScalingFit& fit, double paper,
                     double paper_error) {
  Claim claim = open_claim(id, statement, symbol);
  std::string what = over_window(symbol, fit);
  what.front() = 'T';
  judge_by_number(claim, fit.exponent, paper, paper_error, what);
  return claim;
}

/// Where the propagation coefficient of the thrust, which is known sharply at every friction, stops falling.
std::string turning_sentence(const Analysis& analysis) {
  const Transport *lowest = nullptr, *last = nullptr;
  for (const Transport& result : analysis.results) {
    if (!result.c_thrust.known()) continue;
    if (lowest == nullptr || result.c_thrust.value < lowest->c_thrust.value) lowest = &result;
    last = &result;
  }
  if (lowest == nullptr || lowest == last) return "";
  const Estimate &least = lowest->c_thrust, &end = last->c_thrust;
  if (end.value - least.value <= agreement * std::hypot(least.standard_error, end.standard_error)) return "";
  return fmt::format(
      "Of the friction coefficients measured the speed that follows from the thrust ratio is least at μ = {}, {}, and "
      "grows beyond it, to {} at μ = {}.",
      lowest->mu(), value_with_error(least.value, least.standard_error),
      value_with_error(end.value, end.standard_error), last->mu());
}

}  // namespace

// By the rule for numbers, over the window of mu of the experiment, c read as the slope of x_p.
Claim judge_c_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-mu", "c decreases with friction, c₀ − c in proportion to μ.", "γ",
                               analysis.scaling.gamma, paper_gamma, paper_gamma_error);
  add_ratio(claim, analysis, "the ratio xₚ/z", &ScalingFits::gamma);
  add_misfit(claim, analysis.scaling.gamma);
  if (claim.verdict == not_reproduced && !analysis.by_ratio.empty()) {
    add_sentence(
        claim,
        "The ratio’s correction of order 1/z can look like a linear law where the slope follows none; the size of the "
        "overload and the law of the piles may shift the exponent as well.");
  }
  add_sentence(claim, turning_sentence(analysis));
  return claim;
}

// By the rule for numbers, D read as the slope of W^2.
Claim judge_D_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("D-of-mu", "D grows as μ to the power β, with β about 2.5.", "β", analysis.scaling.beta,
                               paper_beta, paper_beta_error);
  add_ratio(claim, analysis, "the ratio W²/z", &ScalingFits::beta);
  add_misfit(claim, analysis.scaling.beta);
  return claim;
}

// By the rule for numbers.
Claim judge_c_of_D(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-D", "c₀ − c grows as D to the power α, with α = 0.4.", "α", analysis.scaling.alpha,
                               paper_alpha, paper_alpha_error);
  add_ratio(claim, analysis, "the ratios xₚ/z and W²/z", &ScalingFits::alpha);
  add_misfit(claim, analysis.scaling.alpha);
  return claim;
}

}  // namespace granuscope
