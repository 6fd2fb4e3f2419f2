#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Beyond this many standard deviations a single friction coefficient speaks against an exponent that the mean has: six
/// coefficients meet it by chance once in 2600 experiments.
constexpr double outlier = 4;

/// Exponents of z or N. The mean over all friction coefficients is judged by the rule for numbers, the tolerance of the
/// experiment taking the place of the paper's error (the paper states these exponents for large z and N); one is also
/// not reproduced if its value at any single mu lies more than four combined standard errors off.
Claim judge_exponent(const Analysis& analysis, const ClaimSpec& spec, Claim claim, Estimate Exponents::*exponent,
                     double paper, const std::string& what) {
  std::vector<double> mu;
  double farthest = 0, farthest_z = 0;
  Estimate farthest_power;
  for (const Transport& result : analysis.results) {
    const Estimate& power = result.exponents.*exponent;
    if (!power.known()) continue;
    mu.push_back(result.mu());
    const double z = judge_number(power, paper, spec.exponent_tolerance).z_score;
    if (std::abs(z) < std::abs(farthest_z)) continue;
    farthest = result.mu();
    farthest_z = z;
    farthest_power = power;
  }
  judge_by_number(claim, analysis.mean_exponents.*exponent, paper, spec.exponent_tolerance,
                  mu.empty() ? what : fmt::format("{} {}", what, over_all_mu(mu)));
  if (mu.empty()) {
    claim.explanation = fmt::format("No power could be taken: {}.", claim.measured.reason);
    return claim;
  }
  const std::string single = value_with_error(farthest_power.value, farthest_power.standard_error);
  if (std::abs(farthest_z) > outlier && claim.verdict != not_reproduced) {
    claim.verdict = not_reproduced;
    claim.explanation = fmt::format(
        "{} is {} at μ = {}, {} combined standard errors off, though the mean over {}, {}, lies only {} off.", what,
        single, farthest, significant(std::abs(farthest_z), 2), list_of_mu(mu),
        value_with_error(claim.measured.value, claim.measured.standard_error), significant(std::abs(claim.z_score), 2));
  } else if (std::abs(farthest_z) > outlier) {
    add_sentence(claim, fmt::format("At μ = {} alone it is {}, {} combined standard errors off.", farthest, single,
                                    significant(std::abs(farthest_z), 2)));
  } else if (mu.size() > 1) {
    add_sentence(claim, fmt::format("The single value farthest off is {} at μ = {}.", single, farthest));
  }
  return claim;
}

/// What the straight lines through the depths leave, with the joint covariance of the depths.
std::string line_sentence(const Analysis& analysis, LineTest Transport::*line) {
  double chi2 = 0;
  int degrees_of_freedom = 0;
  for (const Transport& result : analysis.results) {
    const LineTest& test = result.*line;
    if (!test.reason.empty() || test.degrees_of_freedom == 0) continue;
    chi2 += test.chi2;
    degrees_of_freedom += test.degrees_of_freedom;
  }
  if (degrees_of_freedom == 0) return "";
  return fmt::format(
      "The straight lines leave χ² = {} on {} degrees of freedom, with the joint covariance of the depths.",
      significant(chi2, 3), degrees_of_freedom);
}

/// The power that the straight lines W^2 = w_0 + D z alone would give the heights, at the middle of the window, over
/// the friction coefficients whose D is known to differ from 0.
std::string offset_sentence(const Analysis& analysis) {
  double lowest = 0, highest = -1;
  for (const Transport& result : analysis.results) {
    if (!result.exponents.amplitude.known() || result.depths.empty()) continue;
    if (!(result.D.value > agreement * result.D.standard_error)) continue;
    double first = 0, last = 0;
    for (const DepthFit& depth : result.depths) {
      if (depth.layer == result.window_layers[0]) first = depth.z;
      if (depth.layer == result.window_layers[1]) last = depth.z;
    }
    const double spread = result.D.value * std::sqrt(first * last);
    const double power = -0.5 * spread / (result.width_offset.value + spread);
    lowest = std::min(lowest, power);
    highest = std::max(highest, power);
  }
  if (highest < lowest) return "";
  std::string range = significant(highest, 2);
  if (significant(lowest, 2) != range) range += " to " + significant(lowest, 2);
  return fmt::format("At these depths the offset w₀ of W² = w₀ + D z alone makes it {}; −1/2 is its limit at large z.",
                     range);
}

}  // namespace

// The power p of x_p = x_0 + A z^p against 1: the curvature of x_p(z) over the window.
Claim judge_linear_position(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("linear-position", "The position xₚ of the peaks grows linearly with z.", "power of z in xₚ − x₀"),
      &Exponents::position, 1, "The power of z in xₚ − x₀");
  add_sentence(claim, line_sentence(analysis, &Transport::position_line));
  return claim;
}

// The power p of W^2 = w_0 + A z^p against 1: the curvature of W^2(z) over the window.
Claim judge_diffusive_width(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(analysis, spec,
                               open_claim("diffusive-width", "The squared width W² of the peaks grows linearly with z.",
                                          "power of z in W² − w₀"),
                               &Exponents::width, 1, "The power of z in W² − w₀");
  add_sentence(claim, line_sentence(analysis, &Transport::width_line));
  return claim;
}

// The power of z in the height of the measured peaks against -1/2, an exact fraction: the slope of ln height on ln z.
Claim judge_amplitude(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(
      analysis, spec, open_claim("amplitude", "The height of the peaks falls as 1/√z.", "power of z in the height"),
      &Exponents::amplitude, -0.5, "The power of z in the height");
  if (claim.measured.known()) add_sentence(claim, offset_sentence(analysis));
  return claim;
}

// The power of N in the rms residual about the fit, over sub-ensembles, against -1/2. A power nearer to 0 says that the
// two Gaussians are not the exact shape, which is told beside the verdict.
Claim judge_noise(const Analysis& analysis, const ClaimSpec& spec) {
  constexpr double paper = -0.5;
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("noise", "The residual noise of the averaged response falls as 1/√N.", "power of N in the residual"),
      &Exponents::noise, paper, "The power of N in the rms residual about the fit");
  if (claim.verdict != not_reproduced) return claim;
  const auto above = [&](const Estimate& power, double allowed) {
    return power.known() && judge_number(power, paper, spec.exponent_tolerance).z_score > allowed;
  };
  const bool another_shape =
      above(claim.measured, agreement) ||
      std::any_of(analysis.results.begin(), analysis.results.end(),
                  [&](const Transport& result) { return above(result.exponents.noise, outlier); });
  if (another_shape) {
    add_sentence(
        claim,
        "A power nearer to 0 than −1/2: the response has not exactly the shape of two Gaussians, and what they miss "
        "stays however many piles are averaged. Of the noise itself that says nothing.");
  }
  return claim;
}

}  // namespace granuscope
