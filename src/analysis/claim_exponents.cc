#include <fmt/format.h>

#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "analysis/power_law.h"
#include "model/lattice.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr PaperNumber paper_gamma{.value = 1};                   ///< stated as a proportionality: exact
constexpr PaperNumber paper_beta{.value = 2.5, .error = 0.05};   ///< "about 2.5": half a unit of its last digit
constexpr PaperNumber paper_alpha{.value = 0.4, .error = 0.01};  ///< given with its error

/// c - c_0 in proportion to the variance of the disorder, as D, which grows as mu^2.
const Rival quadratic{2, "second order in μ"};
const Rival linear_in_D{1, "stochastic theory"};

std::string over_window(const char* name, const ScalingFit& fit) {
  return fmt::format("the exponent {} over μ = {} to {}", name, fit.window[0], fit.window[1]);
}

/// "1.68(3)"; without an error, and with chi^2, where the points follow no power law.
std::string exponent_in_words(const ScalingFit& fit) {
  if (!fit.misses_the_points()) return value_with_error(fit.exponent.value, fit.exponent.standard_error);
  return fmt::format("{} (χ² = {} on {}: no power law)", significant(fit.exponent.value, 3),
                     significant(fit.scatter.chi2, 2), fit.scatter.degrees_of_freedom);
}

/// What the same piles give when c and D are read as ratios at one depth, as the paper's Fig. 3 shows them, and by the
/// depth below the load.
std::string ratio_sentence(const Analysis& analysis, const char* name, const char* ratios, const char* from_load,
                           ScalingFit ScalingFits::*pick) {
  for (const RatioScaling& ratio : analysis.by_ratio) {
    const ScalingFit &fit = ratio.fits.*pick, &shifted = ratio.from_load.*pick;
    if (!fit.exponent.known() || !shifted.exponent.known()) continue;
    return fmt::format(
        "Read as {} at z = {:.1f}, as in the paper’s Fig. 3, the same piles give {} = {}; read as {}, {}.", ratios,
        ratio.z, name, exponent_in_words(fit), from_load, exponent_in_words(shifted));
  }
  return "";
}

/// `of`: what the power is one of.
std::string misfit_sentence(const ScalingFit& fit, const char* of) {
  if (!fit.exponent.known() || !fit.misses_the_points()) return "";
  std::string sentence = fmt::format(
      "χ² of the points about the power law is {} on {}: they follow no single power over this window, and the "
      "exponent lies between those of its parts.",
      significant(fit.scatter.chi2, 3), fit.scatter.degrees_of_freedom);
  if (fit.running.meets_the_points()) {
    sentence += fmt::format(" With an exponent that changes steadily, {}, χ² is {} on {}.", in_words(fit.running, of),
                            significant(fit.running.scatter.chi2, 2), fit.running.scatter.degrees_of_freedom);
  }
  return sentence;
}

Claim judge_exponent(const char* id, const char* statement, const char* symbol, const ScalingFit& fit,
                     const PaperNumber& paper, const std::optional<Rival>& rival) {
  Claim claim = open_claim(id, statement, symbol);
  std::string what = over_window(symbol, fit);
  what.front() = 'T';
  judge_by_number(claim, fit.exponent, paper, rival, what);
  return claim;
}

/// Where depth counts from, with the offset of the lines through x_p.
std::string origin_sentence(const Analysis& analysis) {
  const Estimate& offset = analysis.mean_position_offset;
  if (!offset.known()) return "";
  return fmt::format(
      "z counts from the surface, the load acts half a bead below it: without friction xₚ = c₀ (z − ½), so that "
      "x₀ = −c₀/2 = {}; the lines through xₚ have x₀ = {} on average.",
      significant(-tan30 / 2, 4), value_with_error(offset.value, offset.standard_error));
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
      lowest->scanned(), value_with_error(least.value, least.standard_error),
      value_with_error(end.value, end.standard_error), last->scanned());
}

}  // namespace

// By the rule for numbers, over the window of mu of the experiment, c read as the slope of x_p.
Claim judge_c_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-mu", "c decreases with friction, c₀ − c in proportion to μ.", "γ",
                               analysis.scaling.gamma, paper_gamma, quadratic);
  const std::string ratio =
      ratio_sentence(analysis, "γ", "xₚ/z", "xₚ/(z − ½), from the centre of the loaded bead", &ScalingFits::gamma);
  if (claim.measured.known() && !ratio.empty()) {
    add_sentence(claim, ratio);
    add_sentence(claim, origin_sentence(analysis));
    if (claim.verdict == not_reproduced) {
      add_sentence(claim,
                   "The paper’s law would follow from where z starts; its curves are not available to check that.");
    }
  }
  add_sentence(claim, misfit_sentence(analysis.scaling.gamma, "μ"));
  add_sentence(claim, turning_sentence(analysis));
  return claim;
}

// By the rule for numbers, D read as the slope of W^2.
Claim judge_D_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("D-of-mu", "D grows as μ to the power β, with β about 2.5.", "β", analysis.scaling.beta,
                               paper_beta, {});
  if (claim.measured.known()) {
    add_sentence(claim, ratio_sentence(analysis, "β", "W²/z", "W²/(z − ½)", &ScalingFits::beta));
  }
  add_sentence(claim, misfit_sentence(analysis.scaling.beta, "μ"));
  return claim;
}

// By the rule for numbers.
Claim judge_c_of_D(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-D", "c₀ − c grows as D to the power α, with α = 0.4.", "α", analysis.scaling.alpha,
                               paper_alpha, linear_in_D);
  if (!claim.measured.known()) return claim;
  const ScalingFits& fits = analysis.scaling;
  if (fits.gamma.exponent.known() && fits.beta.exponent.known()) {
    add_sentence(claim, fmt::format("It is no third fact beside β and γ: γ/β is {}.",
                                    significant(fits.gamma.exponent.value / fits.beta.exponent.value, 3)));
  }
  add_sentence(claim, ratio_sentence(analysis, "α", "xₚ/z and W²/z", "xₚ/(z − ½) and W²/(z − ½)", &ScalingFits::alpha));
  add_sentence(claim, misfit_sentence(fits.alpha, "D"));
  return claim;
}

// alpha against 1, which the stochastic theory predicts.
Claim judge_differs_from_theory(const Analysis& analysis) {
  Claim claim = open_claim("differs-from-theory",
                           "c₀ − c is not proportional to D, as the stochastic theory has it at small D.", "α");
  judge_by_exclusion(claim, analysis.scaling.alpha.exponent, paper_alpha, linear_in_D,
                     "T" + over_window("α", analysis.scaling.alpha).substr(1));
  return claim;
}

}  // namespace granuscope
