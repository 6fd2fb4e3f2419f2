#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Beyond this many standard deviations a single ensemble speaks against an exponent that the mean has: six
/// ensembles meet it by chance once in 2600 experiments.
constexpr double outlier = 4;

/// W grows in proportion to z in an elastic medium, isotropic or not.
const Rival elastic_width{2, "elastic scaling"};

/// Exponents of z or N. The mean over all friction coefficients is judged by the rule for numbers, with the tolerance
/// of the experiment (the paper states these exponents for large z and N); one is also not reproduced if its value at
/// any single mu lies more than four standard errors off.
Claim judge_exponent(const Analysis& analysis, const ClaimSpec& spec, Claim claim, Estimate Exponents::*exponent,
                     double value, const std::optional<Rival>& rival, const std::string& what) {
  const PaperNumber paper{.value = value, .tolerance = spec.exponent_tolerance};
  std::vector<double> values;
  std::string farthest;  // "μ = 0.3"
  double farthest_z = 0;
  Estimate farthest_power;
  for (const Transport& result : analysis.results) {
    const Estimate& power = result.exponents.*exponent;
    if (!power.known()) continue;
    values.push_back(result.scanned());
    const double z = judge_number(power, paper).z_score;
    if (!(std::abs(z) >= std::abs(farthest_z))) continue;  // an error that is unknown hides none
    farthest = result.at();
    farthest_z = z;
    farthest_power = power;
  }
  judge_by_number(claim, analysis.mean_exponents.*exponent, paper, rival,
                  values.empty() ? what : fmt::format("{} {}", what, over_all_values(values, analysis.scan->symbol)));
  if (values.empty()) {
    claim.explanation = fmt::format("No power could be taken: {}.", claim.measured.reason);
    return claim;
  }
  const std::string single = value_with_error(farthest_power.value, farthest_power.standard_error);
  if (std::abs(farthest_z) > outlier && claim.verdict != not_reproduced) {
    claim.verdict = not_reproduced;
    claim.explanation = fmt::format(
        "{} is {} at {}, {} standard errors off, though the mean over {}, {}, lies only {} off.", what, single,
        farthest, significant(std::abs(farthest_z), 2), list_of_values(values, analysis.scan->symbol),
        value_with_error(claim.measured.value, claim.measured.standard_error), significant(std::abs(claim.z_score), 2));
  } else if (std::abs(farthest_z) > outlier) {
    add_sentence(claim, fmt::format("At {} alone it is {}, {} standard errors off.", farthest, single,
                                    significant(std::abs(farthest_z), 2)));
  } else if (values.size() > 1) {
    add_sentence(claim, fmt::format("The single value farthest off is {} at {}.", single, farthest));
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

}  // namespace

// The power p of x_p = x_0 + A z^p against 1: the curvature of x_p(z) over the window.
Claim judge_linear_position(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("linear-position", "The position xₚ of the peaks grows linearly with z.", "power of z in xₚ − x₀"),
      &Exponents::position, 1, {}, "The power of z in xₚ − x₀");
  add_sentence(claim, line_sentence(analysis, &Transport::position_line));
  return claim;
}

// The power p of W^2 = w_0 + A z^p against 1: the curvature of W^2(z) over the window.
Claim judge_diffusive_width(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(analysis, spec,
                               open_claim("diffusive-width", "The squared width W² of the peaks grows linearly with z.",
                                          "power of z in W² − w₀"),
                               &Exponents::width, 1, elastic_width, "The power of z in W² − w₀");
  add_sentence(claim, line_sentence(analysis, &Transport::width_line));
  return claim;
}

// The power p of the peak height h against -1/2: 1/h^2 = a + A z^(-2p), so that an offset of W^2 counts for nothing.
Claim judge_amplitude(const Analysis& analysis, const ClaimSpec& spec) {
  return judge_exponent(
      analysis, spec, open_claim("amplitude", "The height of the peaks falls as 1/√z.", "power of z in the height"),
      &Exponents::amplitude, -0.5, Rival{-1, "elastic scaling"}, "The power of z in the height, apart from an offset,");
}

// The power of W^2 against 2, which every elastic response has.
Claim judge_no_elastic_scaling(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = open_claim("no-elastic-scaling", "The widths do not grow in proportion to z, as in any elastic medium.",
                           "power of z in W² − w₀");
  judge_by_exclusion(claim, analysis.mean_exponents.width, {.value = 1, .tolerance = spec.exponent_tolerance},
                     elastic_width, "The mean power of z in W² − w₀");
  return claim;
}

// The power of N in the rms residual about the fit, over sub-ensembles, against -1/2. A power nearer to 0 says that the
// two Gaussians are not the exact shape, which is told beside the verdict.
Claim judge_noise(const Analysis& analysis, const ClaimSpec& spec) {
  constexpr double paper = -0.5;
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("noise", "The residual noise of the averaged response falls as 1/√N.", "power of N in the residual"),
      &Exponents::noise, paper, {}, "The power of N in the rms residual about the fit");
  if (claim.verdict != not_reproduced) return claim;
  const auto above = [&](const Estimate& power, double allowed) {
    return power.known() && judge_number(power, {paper, 0, spec.exponent_tolerance}).z_score > allowed;
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
